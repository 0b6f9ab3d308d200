// SPDX-License-Identifier: Apache-2.0
#include "machine/check/vision_rules.h"

#include <string>
#include <vector>

#include "machine/config/machine_config.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::Reports;
using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::string> texts_of(const DiagnosticLog& log) {
  std::vector<std::string> texts;
  for (const Diagnostic& diagnostic : log.kept()) texts.push_back(diagnostic.text());
  return texts;
}

/// Of a machine whose camera has 320 x 240 px of 0.01 mm.
std::vector<std::string> problems(const std::string& text) {
  auto config = parse_machine_config(text, "machine.toml");
  if (!config) return {config.error().text()};
  CameraCalibration& camera = config->camera.emplace();
  camera.parameters.scale_mm_per_px = 0.01;
  camera.picture_width_px = 320;
  camera.picture_height_px = 240;
  DiagnosticLog log;
  const StatedKeys keys = StatedKeys::of_text(text, "machine.toml");
  check_vision_rules(*config, keys, log);
  check_stated_series(*config, keys, log);
  return texts_of(log);
}

std::string tool(const std::string& size, const std::string& shape = "disc") {
  return "[[vision.tool]]\nnumber = 4\nshape = \"" + shape + "\"\n" + size + "\n";
}

TEST(VisionRules, AMarkIsWithinThePicture) {
  EXPECT_THAT(problems(tool("size_px = 320")), IsEmpty());
  EXPECT_THAT(
      problems(tool("size_px = 321")),
      ElementsAre(Reports("machine.toml:4:11: error[config-value]", "is 321", "320 px (3.2 mm)")));
}

/// vision/round measures radii from 3 px on; a disc may be 4 % larger than stated.
TEST(VisionRules, AMarkHasThePixelsThatDetectorsMeasure) {
  EXPECT_THAT(problems(tool("size_px = 5.8")), IsEmpty());
  EXPECT_THAT(problems(tool("size_px = 5.7")),
              ElementsAre(Reports(
                  "machine.toml:4:11: error[config-value]", "is 5.7", "too small", "6 px")));
}

TEST(VisionRules, OfZoomsTheFinestAndTheWidestPictureCount) {
  const std::string text = tool("size_px = 80");
  auto config = parse_machine_config(text, "machine.toml");
  ASSERT_TRUE(config) << config.error().text();
  const auto camera = [](double scale_mm_per_px) {
    CameraCalibration made;
    made.parameters.scale_mm_per_px = scale_mm_per_px;
    made.picture_width_px = made.picture_height_px = 320;
    return made;
  };
  Target& target = config->vision_tools.at(4);
  target.size_px.reset();
  config->camera = camera(0.01);
  const auto checked = [&](double size_mm) {
    target.size = mm(size_mm);
    DiagnosticLog log;
    check_vision_rules(*config, StatedKeys::of_text(text, "machine.toml"), log);
    return texts_of(log).size();
  };
  EXPECT_EQ(checked(0.05), 1);
  EXPECT_EQ(checked(5), 1);
  config->zooms[2] = camera(0.005);
  config->zooms[0.5] = camera(0.02);
  EXPECT_EQ(checked(0.05), 0);
  EXPECT_EQ(checked(5), 0);
  EXPECT_EQ(checked(0.02), 1);
  EXPECT_EQ(checked(7), 1);
}

TEST(VisionRules, TheSearchReachesAPixel) {
  EXPECT_THAT(problems("[vision]\nsearch_radius_mm = 0.01\n"), IsEmpty());
  EXPECT_THAT(problems("[vision]\nsearch_radius_mm = 0.009\n"),
              ElementsAre(Reports("machine.toml:2:20: error[config-value]", "0.009", "0.01 mm")));
}

TEST(VisionRules, SeriesHaveTheTargetsThatTheModelNeeds) {
  const std::string place = "machine.toml:2:10: error[config-value]";
  const auto of = [](int rotate, const std::string& model) {
    return problems("[vision]\nrotate = " + std::to_string(rotate) + "\nmodel = \"" + model +
                    "\"\n");
  };
  EXPECT_THAT(of(3, "affine"), IsEmpty());
  EXPECT_THAT(of(2, "affine"), ElementsAre(Reports(place, "is 2", "affine")));
  // At most that: a series of two is rigid.
  EXPECT_THAT(of(2, "stretch"), IsEmpty());
  EXPECT_THAT(of(1, "rigid"), IsEmpty());
  EXPECT_THAT(of(6, "smooth"), IsEmpty());
  EXPECT_THAT(of(128, "smooth"), IsEmpty());
  EXPECT_THAT(of(5, "smooth"), ElementsAre(Reports(place, "is 5", "6 to 128")));
  EXPECT_THAT(of(129, "smooth"), ElementsAre(Reports(place, "is 129", "6 to 128")));
  // A program may set the size of its series: without `rotate` nothing contradicts the model.
  EXPECT_THAT(problems("[vision]\nmodel = \"smooth\"\n"), IsEmpty());
}

}  // namespace
}  // namespace panelcal
