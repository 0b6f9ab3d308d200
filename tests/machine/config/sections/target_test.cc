// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sections/target.h"

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "machine/config/machine_config.h"
#include "vision/picture/files/image_io.h"
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

/// The diagnostic of a file with one vision tool, without its wording; line 3 is its shape.
std::string refusal(std::string_view tool, const std::filesystem::path& folder = {}) {
  const std::string toml = "[[vision.tool]]\nnumber = 1\n" + std::string(tool);
  const auto config = parse_machine_config(toml, folder / "machine.toml");
  if (config) return "accepted";
  const std::string text = test::brief(config.error());
  return text.substr(text.find("machine.toml"));
}

TEST(TargetConfig, WhatIsWrongWithDotsHasAPlace) {
  EXPECT_EQ(refusal("shape = \"dots\"\nsize_px = 20\ndots_px = [0, 0]\n"),
            "machine.toml:5:11: error[config-value]");
  EXPECT_EQ(refusal("shape = \"dots\"\nsize_px = 20\ndots_px = [0, 0, 50, 0, 60, 9]\n"),
            "machine.toml:5:11: error[config-value]");
}

TEST(TargetConfig, ADotCodeMustNotLookTheSameWhenTurned) {
  const std::string square =
      "shape = \"dots\"\nsize_px = 10\ndots_px = [0, 0, 50, 0, 50, 50, 0, 50]\n";
  EXPECT_EQ(refusal(square), "accepted");
  EXPECT_EQ(refusal(square + "angle_tolerance_deg = 40\n"), "accepted");
  EXPECT_EQ(refusal(square + "angle_tolerance_deg = 60\n"),
            "machine.toml:6:23: error[config-value]");
  EXPECT_EQ(refusal("shape = \"dots\"\nsize_px = 10\ndots_px = [0, 0, 50, 0, 80, 50, 0, 90]\n"
                    "angle_tolerance_deg = 180\n"),
            "accepted");
}

TEST(TargetConfig, TagsLieInAnyWay) {
  const std::string tag = "shape = \"apriltag\"\nsize_px = 80\n";
  EXPECT_EQ(refusal(tag), "accepted");
  EXPECT_EQ(refusal(tag + "angle_deg = 10\n"), "machine.toml:5:13: error[config-value]");
  EXPECT_EQ(refusal(tag + "angle_tolerance_deg = 10\n"), "machine.toml:5:23: error[config-value]");
  EXPECT_EQ(refusal(tag + "id = 587\n"), "machine.toml:5:6: error[config-value]");
  EXPECT_EQ(refusal(tag + "id = -1\n"), "machine.toml:5:6: error[config-value]");
  EXPECT_EQ(refusal(tag + "family = \"tag99\"\n"), "machine.toml:5:10: error[config-value]");
}

/// 9e18 mm kept the search for a hole busy for minutes.
TEST(TargetConfig, LengthsHaveBounds) {
  const std::string ring = "shape = \"ring\"\n";
  EXPECT_EQ(refusal(ring + "size_px = 1e5\ninner_px = 9e4\n"), "accepted");
  EXPECT_EQ(refusal(ring + "size_px = 1.001e5\n"), "machine.toml:4:11: error[config-value]");
  EXPECT_EQ(refusal(ring + "size_mm = 1000.5\n"), "machine.toml:4:11: error[config-value]");
  EXPECT_EQ(refusal(ring + "size_mm = 9e18\n"), "machine.toml:4:11: error[config-value]");
  EXPECT_EQ(refusal(ring + "size_px = 0\n"), "machine.toml:4:11: error[config-value]");
  EXPECT_EQ(refusal(ring + "size_px = 80\ninner_px = 1.001e5\n"),
            "machine.toml:5:12: error[config-value]");
}

/// A template of 60 x 60 px with levels given by a function of the place from its middle.
std::string template_refusal(const std::function<bool(double, double)>& is_mark,
                             std::string_view more = "") {
  const test::TemporaryFolder folder;
  Image image(60, 60, 255);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 60; ++x) image.at(x, y) = is_mark(x - 29.5, y - 29.5) ? 200 : 60;
  }
  EXPECT_TRUE(write_png(folder.path() / "mark.png", image));
  return refusal("shape = \"template\"\nsize_px = 60\npicture = \"mark.png\"\n" + std::string(more),
                 folder.path());
}

bool is_square(double x, double y) {
  return std::abs(x) < 12 && std::abs(y) < 12;
}

TEST(TargetConfig, TemplatesThatDoNotTellThePlaceAreRefused) {
  EXPECT_EQ(template_refusal([](double, double) { return false; }),
            "machine.toml:5:11: error[config-value]");
  EXPECT_EQ(template_refusal([](double x, double) { return std::abs(x) < 10; }),
            "machine.toml:5:11: error[config-value]");
  EXPECT_EQ(template_refusal(is_square), "accepted");
}

TEST(TargetConfig, TemplatesThatMayBeTurnedMustNotLookTheSame) {
  EXPECT_EQ(template_refusal(is_square, "angle_tolerance_deg = 40\n"), "accepted");
  EXPECT_EQ(template_refusal(is_square, "angle_tolerance_deg = 50\n"),
            "machine.toml:6:23: error[config-value]");
  const auto keyed = [](double x, double y) { return is_square(x, y) && !(x > 6 && y > 6); };
  EXPECT_EQ(template_refusal(keyed, "angle_tolerance_deg = 180\n"), "accepted");
}

}  // namespace
}  // namespace panelcal
