// SPDX-License-Identifier: Apache-2.0
#include "tools/locate/located_json.h"

#include <array>
#include <cmath>
#include <string>

#include "calib/base/statistics/random.h"
#include "vision/render/render.h"
#include "vision/render/scene_marks.h"
#include "vision/tag/family.h"
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace panelcal {
namespace {

using nlohmann::json;

constexpr double kNear_px = 0.1;
constexpr double kNear_rad = 2e-3;
const Eigen::Vector2d kCenter_px(160.3, 118.8);
const Angle kTurn = deg(3);

/// A camera that sees targets in px upright, 1 px a px.
Camera plain_camera() {
  CameraMapping::Parameters parameters;
  parameters.scale_mm_per_px = 0.01;
  parameters.axis_px = {159.5, 119.5};
  Camera camera{.mapping = CameraMapping(parameters)};
  camera.width = 320;
  camera.height = 240;
  camera.noise = 2;
  return camera;
}

/// Output of `panelcal locate` for a picture of the target at kCenter_px, turned by kTurn.
json located(const Target& target, const Displacement<frame::Optical>& hole_offset = {}) {
  const Camera camera = plain_camera();
  MarkLook look;
  look.center = camera.mapping(position_px<frame::Image>(kCenter_px));
  look.turn = kTurn;
  look.hole_offset = hole_offset;
  Scene scene;
  scene.background = 0.3;
  scene.features = mark_features(target, look, camera.mapping);
  Random random(1);
  const Detection detection = locate(render(scene, camera, random), target);
  return json::parse(facts::text(located_row({"a \"b\".png", target.number, false}, detection)));
}

Target target_of(Shape shape, double size_px) {
  Target target;
  target.number = 7;
  target.shape = shape;
  target.size_px = px(size_px);
  return target;
}

Eigen::Vector2d point_of(const json& value) {
  return {value.at(0).get<double>(), value.at(1).get<double>()};
}

void expect_found_at_center(const json& line) {
  ASSERT_EQ(line["status"], "found") << line;
  EXPECT_EQ(line["image"], "a \"b\".png");
  EXPECT_EQ(line["tool"], 7);
  EXPECT_EQ(line["candidates"], 1);
  EXPECT_FALSE(line.contains("others"));
}

TEST(LocatedJson, ATagHasItsNumberAndCorners) {
  constexpr double kSide_px = 96;
  Target target = target_of(Shape::AprilTag, kSide_px);
  target.tag_id = 23;
  const json line = located(target);
  expect_found_at_center(line);
  EXPECT_EQ(line["id"], 23);
  EXPECT_LT((point_of(line["center_px"]) - kCenter_px).norm(), kNear_px);
  ASSERT_EQ(line["corners_px"].size(), 4u);
  const double c = std::cos(kTurn.in_rad());
  const double s = std::sin(kTurn.in_rad());
  const auto corners = tag_corners();
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d v = kSide_px * corners[i];
    const Eigen::Vector2d truth_px =
        kCenter_px + Eigen::Vector2d(c * v.x() - s * v.y(), s * v.x() + c * v.y());
    EXPECT_LT((point_of(line["corners_px"][i]) - truth_px).norm(), kNear_px) << i;
  }
  EXPECT_FALSE(line.contains("blind_rad"));
}

TEST(LocatedJson, ASlotSaysAlongWhichDirectionNothingIsMeasured) {
  const json line = located(target_of(Shape::Slot, 30));
  expect_found_at_center(line);
  ASSERT_TRUE(line.contains("blind_rad")) << line;
  const double blind_rad = line["blind_rad"];
  EXPECT_NEAR(blind_rad, kTurn.in_rad(), kNear_rad);
  EXPECT_NEAR(line["angle_rad"], blind_rad, 1e-9);
  const Eigen::Vector2d along(std::cos(kTurn.in_rad()), std::sin(kTurn.in_rad()));
  const Eigen::Vector2d across(-along.y(), along.x());
  const Eigen::Vector2d error_px = point_of(line["center_px"]) - kCenter_px;
  EXPECT_LT(std::abs(across.dot(error_px)), kNear_px);
  Eigen::Matrix2d cov;
  cov << line["cov_px"][0], line["cov_px"][1], line["cov_px"][1], line["cov_px"][2];
  EXPECT_LT(std::sqrt(across.dot(cov * across)), kNear_px);
  // The slot runs through the picture, 320 px wide: uniform, sigma 320 / sqrt(12).
  EXPECT_NEAR(std::sqrt(along.dot(cov * along)), 320 / std::sqrt(12.0), 5);
  EXPECT_FALSE(line.contains("id"));
  EXPECT_FALSE(line.contains("corners_px"));
}

TEST(LocatedJson, ARingSaysWhereItsHoleIs) {
  // y is up on the board, down in the picture: 4 px to the right, 3 px up.
  const json line =
      located(target_of(Shape::Ring, 80), displacement_mm<frame::Optical>(0.04, 0.03));
  expect_found_at_center(line);
  const Eigen::Vector2d offset_px = point_of(line["hole_offset_px"]);
  EXPECT_LT((offset_px - Eigen::Vector2d(4, -3)).norm(), kNear_px);
  EXPECT_FALSE(located(target_of(Shape::Disc, 80)).contains("hole_offset_px"));
}

}  // namespace
}  // namespace panelcal
