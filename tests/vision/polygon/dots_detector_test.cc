// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>
#include <vector>

#include "vision/polygon/dot_code.h"
#include <Eigen/Core>
#include <gtest/gtest.h>

#include "tests/vision/polygon/dot_board.h"

namespace panelcal::test {
namespace {

using internal::DotAssignment;
using internal::DotCode;
using internal::SeenDot;

TEST(DotsDetector, FindsTheCodeAmongOtherDots) {
  DotBoard board;
  const Eigen::Vector2d at(0.1234, -0.0567);
  board.add_code(at, 0.05);
  board.add({-0.9, 0.8});
  const Detection d = board.locate();
  ASSERT_EQ(d.status, DetectionStatus::Found) << d.reason;
  const TargetFit& fit = *d.best;
  EXPECT_LT((fit.center_optical->position.in_mm() - at).norm(), 1e-4);
  EXPECT_NEAR(fit.angle.in_rad(), 0.05, 5e-4);
  EXPECT_GT(fit.angle_sigma.in_rad(), 0);
  EXPECT_NEAR(fit.size_mm->in_mm(), 0.16, 0.001);
  EXPECT_NEAR(fit.contrast, 100, 2);
  EXPECT_GT(fit.visible, 0.95);
  const auto px = board.camera.mapping.image_of(fit.center_optical->position);
  EXPECT_LT((px->in_px() - fit.center.position.in_px()).norm(), 1e-9);
}

TEST(DotsDetector, MayLackAQuarterOfItsDots) {
  DotBoard board;
  board.add_code({0, 0}, 0.02);
  board.scene.features.erase(board.scene.features.begin() + 2);
  const Detection one_missing = board.locate();
  ASSERT_EQ(one_missing.status, DetectionStatus::Found) << one_missing.reason;
  EXPECT_LT(one_missing.best->center_optical->position.in_mm().norm(), 1e-4);
  EXPECT_NEAR(one_missing.best->visible, 0.8, 0.05);
  board.scene.features.erase(board.scene.features.begin());
  const Detection two_missing = board.locate();
  EXPECT_EQ(two_missing.status, DetectionStatus::NotFound);
  EXPECT_NE(
      two_missing.reason.find("no 4 of the code's 5 dots are in their places; 3 dots are seen"),
      std::string::npos)
      << two_missing.reason;
}

TEST(DotsDetector, RejectsDotsThatAreOff) {
  DotBoard board;
  board.add_code({0, 0}, 0);
  // 20 um on a dot of 160 um; 4 % of it, 6.4 um, are allowed.
  board.scene.features[1].center =
      board.scene.features[1].center + displacement_mm<frame::Optical>(Eigen::Vector2d(0.02, 0));
  const Detection d = board.locate();
  EXPECT_EQ(d.status, DetectionStatus::Rejected) << d.reason;
  EXPECT_EQ(d.reason.find("the dots are not where the code has them: dot 2 is off by"), 0u)
      << d.reason;
  // A small error is tolerated, but makes the place less sure.
  DotBoard good;
  good.add_code({0, 0}, 0);
  const double sure = good.locate().best->center.cov.trace();
  good.scene.features[1].center =
      good.scene.features[1].center + displacement_mm<frame::Optical>(Eigen::Vector2d(0.004, 0));
  const Detection scattered = good.locate();
  ASSERT_EQ(scattered.status, DetectionStatus::Found) << scattered.reason;
  EXPECT_GT(scattered.best->center.cov.trace(), 10 * sure);
}

TEST(DotsDetector, TwoCodesAreAmbiguous) {
  DotBoard board;
  board.target.dots = {{-0.3, -0.2}, {0.3, -0.25}, {0.1, 0.3}};
  board.add_code({-0.6, 0.3}, 0.02);
  board.add_code({0.6, -0.3}, -0.03);
  const Detection d = board.locate();
  EXPECT_EQ(d.status, DetectionStatus::Ambiguous) << d.reason;
  EXPECT_EQ(d.n_candidates, 2);
  LocateOptions options;
  options.search_center =
      *board.camera.mapping.image_of(position_mm<frame::Optical>(Eigen::Vector2d(0.6, -0.3)));
  options.search_radius = px(10);
  const Detection one = board.locate(1, options);
  ASSERT_EQ(one.status, DetectionStatus::Found) << one.reason;
  EXPECT_LT((one.best->center_optical->position.in_mm() - Eigen::Vector2d(0.6, -0.3)).norm(), 1e-3);
}

TEST(DotsDetector, RefusesCodesThatLookTheSameTurned) {
  DotBoard board;
  board.target.dots = {{0.4, 0.4}, {-0.4, 0.4}, {-0.4, -0.4}, {0.4, -0.4}};
  board.add_code({0, 0}, 0.02);
  EXPECT_EQ(board.locate().status, DetectionStatus::Found);
  board.target.angle_tolerance = deg(100);
  const Detection d = board.locate();
  EXPECT_EQ(d.status, DetectionStatus::Rejected);
  EXPECT_NE(d.reason.find("looks the same when turned by"), std::string::npos) << d.reason;
}

TEST(DotsDetector, WorksInPixelsWithoutAMapping) {
  DotBoard board;
  board.target.size.reset();
  board.target.size_px = px(2 * kDotRadiusPx);
  // Pictures' y points down.
  for (auto& dot : board.target.dots) dot = Eigen::Vector2d(dot.x(), -dot.y()) / kDotScaleMm;
  for (const auto& dot : kCode) {
    Feature feature;
    feature.center = position_mm<frame::Optical>(
        Eigen::Vector2d(1.02 * turned(dot, 0.04) + Eigen::Vector2d(0.1, 0.05)));
    feature.size = mm(2 * kDotRadiusPx * kDotScaleMm);
    feature.level = kDotLevel;
    board.scene.features.push_back(feature);
  }
  Random random(4);
  const Detection d = panelcal::locate(render(board.scene, board.camera, random), board.target);
  ASSERT_EQ(d.status, DetectionStatus::Found) << d.reason;
  const auto truth =
      board.camera.mapping.image_of(position_mm<frame::Optical>(Eigen::Vector2d(0.1, 0.05)));
  EXPECT_LT((d.best->center.position.in_px() - truth->in_px()).norm(), 0.01);
  EXPECT_NEAR(d.best->angle.in_rad(), -0.04, 5e-4);
}

DotCode code_of(const std::vector<Eigen::Vector2d>& dots, double turn_tolerance) {
  DotCode code;
  code.dots = dots;
  code.turn_tolerance = turn_tolerance;
  code.scale_tolerance = 0.04;
  code.place_tolerance = 0.07;
  return code;
}

/// A crowd of dots, in which a code is searched at every angle.
TEST(DotCode, IsFoundAmongTwoHundred) {
  Random random(9);
  std::vector<SeenDot> seen;
  const Eigen::Matrix2d cov = 1e-8 * Eigen::Matrix2d::Identity();
  const double turn = 2.5;
  const Eigen::Vector2d at(3, 4);
  for (const auto& dot : kCode) seen.push_back({at + turned(dot, turn), cov});
  while (seen.size() < 200) {
    const Eigen::Vector2d other(random.uniform(0, 6), random.uniform(0, 6));
    bool is_free = true;
    for (const SeenDot& dot : seen) is_free = is_free && (dot.at - other).norm() > 0.2;
    if (is_free) seen.push_back({other, cov});
  }
  const DotCode code = code_of(kCode, std::numbers::pi);
  bool has_truth = false;
  for (const DotAssignment& way : match_dots(code, seen)) {
    const auto pose = fit_dots(code, seen, way);
    has_truth = has_truth || ((pose.at - at).norm() < 1e-6 && std::abs(pose.turn - turn) < 1e-6);
  }
  EXPECT_TRUE(has_truth);
}

TEST(DotCode, ShiftedGridIsAShadow) {
  std::vector<Eigen::Vector2d> grid;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 3; ++j) grid.emplace_back(0.5 * i, 0.5 * j);
  }
  std::vector<SeenDot> seen;
  for (const auto& dot : grid) seen.push_back({dot, 1e-8 * Eigen::Matrix2d::Identity()});
  const DotCode code = code_of(grid, 0.1);
  // Moved by one column nine of twelve dots fit, which is enough if the twelve were not there.
  ASSERT_EQ(match_dots(code, seen).size(), 1u);
  seen.resize(9);
  EXPECT_EQ(match_dots(code, seen).size(), 2u);
}

TEST(DotCode, FitKeepsWhatItIsNotTold) {
  const DotCode rigid = code_of(kCode, 0.1);
  std::vector<SeenDot> seen;
  DotAssignment all;
  for (std::size_t i = 0; i < kCode.size(); ++i) {
    seen.push_back({Eigen::Vector2d(1, 2) + 1.01 * turned(kCode[i], 0.03),
                    1e-8 * Eigen::Matrix2d::Identity()});
    all.push_back(static_cast<int>(i));
  }
  DotCode similar = rigid;
  similar.fits_scale = true;
  const auto pose = fit_dots(similar, seen, all);
  EXPECT_NEAR(std::exp(pose.log_scale), 1.01, 1e-9);
  EXPECT_NEAR(pose.turn, 0.03, 1e-9);
  EXPECT_LT((pose.at - Eigen::Vector2d(1, 2)).norm(), 1e-9);
  EXPECT_LT(pose.chi_square, 1e-9);
  EXPECT_EQ(pose.degrees_of_freedom, 6);
  EXPECT_EQ(fit_dots(rigid, seen, all).log_scale, 0);
  EXPECT_GT(fit_dots(rigid, seen, all).chi_square, 100);
}

TEST(DotCode, NeedsAllOfFewAndThreeQuartersOfMany) {
  EXPECT_EQ(internal::least_dots(2), 2);
  EXPECT_EQ(internal::least_dots(3), 3);
  EXPECT_EQ(internal::least_dots(4), 3);
  EXPECT_EQ(internal::least_dots(7), 6);
  EXPECT_EQ(internal::least_dots(64), 48);
}

}  // namespace
}  // namespace panelcal::test
