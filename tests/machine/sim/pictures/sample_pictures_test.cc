// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/pictures/sample_pictures.h"

#include <algorithm>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "vision/locate/locate.h"
#include "vision/picture/files/image_io.h"
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

constexpr double kCenter_px = 1e-4;
constexpr double kSeen_px = 0.1;  // of a located target, ten sigmas and more

Expected<MachineConfig> config_of(const std::string& text) {
  const test::TemporaryFolder folder;
  return test::config_with_camera(folder.path(),
                                  test::test_camera(320, 240),
                                  "[camera]\ncalibration = \"camera.cal.json\"\n" + text);
}

Target target_of(Shape shape, Length size) {
  Target target;
  target.number = 1;
  target.shape = shape;
  target.size = size;
  return target;
}

SampleRenderer renderer_of(const std::string& sim, const Target& target) {
  auto config = config_of(sim);
  EXPECT_TRUE(config) << config.error().text();
  config->vision_tools[1] = target;
  auto renderer = SampleRenderer::create(*config, 1);
  EXPECT_TRUE(renderer) << renderer.error().text();
  return *renderer;
}

std::string refusal(const std::string& sim, const Target& target, int tool = 1) {
  auto config = config_of(sim);
  if (!config) return test::brief(config.error());
  config->vision_tools[1] = target;
  const auto renderer = SampleRenderer::create(*config, tool);
  if (renderer) return "accepted";
  const std::string message = test::brief(renderer.error());
  return message.substr(message.find("machine.toml"));
}

Detection locate_in(const Image& image, const Target& target) {
  const CameraMapping mapping = test::test_camera(320, 240).mapping();
  return locate(image, target, &mapping);
}

/// Whatever is brighter than the ground.
Eigen::Vector2d centroid_px(const Image& image, double ground) {
  double sum = 0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double v = static_cast<double>(image.at(x, y)) - ground;
      sum += v;
      moment += v * Eigen::Vector2d(x, y);
    }
  }
  return moment / sum;
}

/// Targets in px are drawn without lens distortion: the centre of gravity is the centre.
TEST(SamplePictures, TruthIsTheCentroidOfSymmetricTargets) {
  Target target;
  target.number = 1;
  target.size_px = px(60);
  target.angle_tolerance = deg(20);
  for (const Shape shape :
       {Shape::Disc, Shape::Hole, Shape::Ring, Shape::Square, Shape::Diamond, Shape::Cross}) {
    target.shape = shape;
    target.width_px = shape == Shape::Cross ? std::optional(px(15)) : std::nullopt;
    const SampleRenderer renderer =
        renderer_of("[sim]\nbit_depth = 16\nbackground = 0.2\n", target);
    for (int i = 0; i < 5; ++i) {
      const Sample sample = renderer.draw(i);
      const Eigen::Vector2d seen = centroid_px(sample.image, 0.2 * 65535);  // 13107 exactly
      EXPECT_NEAR((seen - sample.truth.center_px).norm(), 0, kCenter_px) << name(shape) << i;
    }
  }
}

TEST(SamplePictures, CentresAgreeWithTheCalibration) {
  auto config = config_of("[sim]\n");
  ASSERT_TRUE(config) << config.error().text();
  config->vision_tools[1] = target_of(Shape::Disc, mm(0.6));
  const auto renderer = SampleRenderer::create(*config, 1);
  ASSERT_TRUE(renderer) << renderer.error().text();
  for (int i = 0; i < 5; ++i) {
    const SampleTruth truth = renderer->draw(i).truth;
    const auto at = config->camera->mapping()(position_px<frame::Image>(truth.center_px));
    ASSERT_TRUE(truth.center_mm);
    EXPECT_NEAR((at.in_mm() - *truth.center_mm).norm(), 0, 1e-12);
  }
}

TEST(SamplePictures, ArePicturesOfTheSeed) {
  const std::string sim = "[sim]\nnoise = 3\nweave_amplitude = 0.05\nneighbors = 3\nseed = ";
  const Target target = target_of(Shape::Disc, mm(0.4));
  const SampleRenderer first = renderer_of(sim + "7", target);
  const SampleRenderer same = renderer_of(sim + "7", target);
  const SampleRenderer other = renderer_of(sim + "8", target);
  const Sample sample = first.draw(4);
  EXPECT_EQ(sample.image, same.draw(4).image);
  EXPECT_NE(sample.image, first.draw(5).image);
  EXPECT_NE(sample.image, other.draw(4).image);
  EXPECT_GE(sample.truth.n_neighbors, 1);
}

TEST(SamplePictures, TurnWithinTheTolerance) {
  Target square = target_of(Shape::Square, mm(0.4));
  square.angle = deg(10);
  square.angle_tolerance = deg(5);
  const SampleRenderer renderer = renderer_of("[sim]\n", square);
  double least = 1e9;
  double most = -1e9;
  for (int i = 0; i < 20; ++i) {
    const double angle_deg = renderer.draw(i).truth.angle.in_deg();
    least = std::min(least, angle_deg);
    most = std::max(most, angle_deg);
  }
  EXPECT_GE(least, 5);
  EXPECT_LE(most, 15);
  EXPECT_GT(most - least, 4);
}

TEST(SamplePictures, EveryShapeIsDrawn) {
  for (const Shape shape : {Shape::Disc,
                            Shape::Hole,
                            Shape::Ring,
                            Shape::Square,
                            Shape::Diamond,
                            Shape::Cross,
                            Shape::Slot,
                            Shape::Dots,
                            Shape::AprilTag}) {
    Target target = target_of(shape, mm(0.4));
    if (shape == Shape::Cross) target.width = mm(0.1);
    if (shape == Shape::Dots) target.dots = {{0, 0}, {0.6, 0}, {0, 0.6}};
    const Image image = renderer_of("[sim]\n", target).draw(0).image;
    const auto [least, most] = std::ranges::minmax_element(image.pixels());
    EXPECT_NEAR(*most - *least, 0.4 * 255, 6) << name(shape);
  }
}

TEST(SamplePictures, TruthSaysWhereARingHasItsHole) {
  Target ring = target_of(Shape::Ring, mm(0.8));
  ring.inner_size = mm(0.3);
  const SampleRenderer renderer =
      renderer_of("[sim]\nring_offset_sigma_um = 40\nbit_depth = 16\n", ring);
  double squares = 0;
  for (int i = 0; i < 5; ++i) {
    const Sample sample = renderer.draw(i);
    ASSERT_TRUE(sample.truth.hole_offset_px);
    squares += sample.truth.hole_offset_px->squaredNorm();
    const Detection detection = locate_in(sample.image, ring);
    ASSERT_EQ(detection.status, DetectionStatus::Found) << detection.reason;
    EXPECT_LT((detection.best->hole_offset_px - *sample.truth.hole_offset_px).norm(), kSeen_px);
  }
  EXPECT_GT(squares, 5);  // 4 px a coordinate: they are not all in the middle
  EXPECT_FALSE(
      renderer_of("[sim]\n", target_of(Shape::Disc, mm(0.4))).draw(0).truth.hole_offset_px);
}

/// A mark drawn dark is found as dark, and not as bright.
TEST(SamplePictures, PolarityIsTheOneThatLocateLooksFor) {
  const auto mark = std::make_shared<TemplatePicture>();
  mark->image = Image(60, 60, 255);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 60; ++x)
      mark->image.at(x, y) = x > 12 && x < 40 && y > 20 && y < 48 ? 190 : 80;
  }
  mark->reference_px = {26, 34};
  for (const Shape shape : {Shape::Disc, Shape::Square, Shape::Template, Shape::AprilTag}) {
    Target target = target_of(shape, mm(0.8));
    if (shape == Shape::Template) target.picture = mark;
    for (const Polarity polarity : {Polarity::Bright, Polarity::Dark}) {
      target.polarity = polarity;
      const Sample sample = renderer_of("[sim]\nbackground = 0.4\nnoise = 2\n", target).draw(1);
      const Detection detection = locate_in(sample.image, target);
      ASSERT_EQ(detection.status, DetectionStatus::Found)
          << name(shape) << " " << name(polarity) << ": " << detection.reason;
      const Eigen::Vector2d seen_px = detection.best->center.position.in_px();
      EXPECT_LT((seen_px - sample.truth.center_px).norm(), kSeen_px) << name(shape);
      target.polarity = polarity == Polarity::Bright ? Polarity::Dark : Polarity::Bright;
      EXPECT_NE(locate_in(sample.image, target).status, DetectionStatus::Found)
          << name(shape) << " " << name(polarity);
    }
  }
}

TEST(SamplePictures, DebrisIsCounted) {
  const SampleRenderer renderer =
      renderer_of("[sim]\n[sim.debris]\nrim_share = 0.2\n", target_of(Shape::Disc, mm(0.6)));
  EXPECT_NEAR(renderer.draw(0).truth.visible, 0.8, 2e-3);
}

TEST(SamplePictures, WritesPicturesAndTruth) {
  const test::TemporaryFolder folder;
  const SampleRenderer renderer =
      renderer_of("[sim]\nnoise = 2\n", target_of(Shape::Disc, mm(0.6)));
  const auto set = write_samples(renderer, 3, folder.path() / "new");
  ASSERT_TRUE(set) << set.error().text();
  std::ifstream file(folder.path() / "new" / "truth.json");
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json["kind"], "sample-truth");
  EXPECT_EQ(json["version"], 1);
  EXPECT_EQ(json["size_mm"], 0.6);
  EXPECT_EQ(json["noise"], 2);
  ASSERT_EQ(json["pictures"].size(), 3u);
  for (int i = 0; i < 3; ++i) {
    const Sample sample = renderer.draw(i);
    const auto& row = json["pictures"][static_cast<std::size_t>(i)];
    EXPECT_EQ(row["center_px"][0], sample.truth.center_px.x());
    EXPECT_EQ(row["center_px"][1], sample.truth.center_px.y());
    const auto image = read_image(folder.path() / "new" / row["file"].get<std::string>());
    ASSERT_TRUE(image) << image.error().text();
    EXPECT_EQ(*image, sample.image);
  }
}

TEST(SamplePictures, RefusesWhatCannotBeDrawn) {
  EXPECT_EQ(refusal("", target_of(Shape::Disc, mm(0.5))), "machine.toml: error[config-value]");
  EXPECT_EQ(refusal("[sim]\n", target_of(Shape::Disc, mm(0.5)), 2),
            "machine.toml: error[vision-tool-undefined]");
  EXPECT_EQ(refusal("[sim]\n", target_of(Shape::Disc, mm(2.5))),
            "machine.toml: error[config-value]");
  Target tag = target_of(Shape::AprilTag, mm(0.8));
  tag.tag_id = 1'000'000;
  EXPECT_EQ(refusal("[sim]\n", tag), "machine.toml: error[config-value]");
}

}  // namespace
}  // namespace panelcal
