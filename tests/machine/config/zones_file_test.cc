// SPDX-License-Identifier: Apache-2.0
#include "machine/config/zones_file.h"

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

Expected<ZonesFile> parsed(std::string_view text) {
  return parse_zones_file(text, "zones.toml", {.max_extrapolation = mm(7)});
}

Position<frame::Nominal> at(double x_mm, double y_mm) {
  return position_mm<frame::Nominal>(x_mm, y_mm);
}

TEST(ZonesFile, SaysZonesVoidsAndTheEdge) {
  const auto file = parsed(R"(
probe_tip_mm = 1.5

[panel]
rectangle_mm = [0, 0, 300, 200]

[[zone]]
name = "coupon"
center_mm = [20, 30]
diameter_mm = 10
model = "plane"
max_extrapolation_mm = 2

[[zone]]
name = "board"
polygon_mm = [0, 0, 300, 0, 300, 200]

[[void]]
name = "clamp"
rectangle_mm = [290, 0, 300, 15]

[[void]]
name = "slit"
track_mm = [50, 50, 60, 50]
width_mm = 2
)");
  ASSERT_TRUE(file) << file.error().text();
  EXPECT_EQ(file->probe_tip, mm(1.5));
  ASSERT_EQ(file->zones.size(), 2U);
  EXPECT_EQ(file->zones[0].name, "coupon");
  EXPECT_EQ(file->zones[0].from.line, 8);
  EXPECT_EQ(file->zones[0].options.model, SurfaceModel::Plane);
  EXPECT_EQ(file->zones[0].options.max_extrapolation, mm(2));
  EXPECT_TRUE(is_within(file->zones[0].area, at(24.9, 30)));
  EXPECT_FALSE(is_within(file->zones[0].area, at(25.1, 30)));
  EXPECT_EQ(file->zones[1].options.model, std::nullopt);
  EXPECT_EQ(file->zones[1].options.max_extrapolation, mm(7));
  EXPECT_TRUE(is_within(file->zones[1].area, at(299, 100)));
  ASSERT_EQ(file->voids.size(), 3U);
  EXPECT_EQ(text_of(file->voids[0]), "\"clamp\" (zones.toml:19)");
  EXPECT_TRUE(is_within(file->voids[0].area, at(295, 14)));
  EXPECT_TRUE(is_within(file->voids[1].area, at(55, 50.9)));
  EXPECT_FALSE(is_within(file->voids[1].area, at(55, 51.1)));
  EXPECT_EQ(file->voids[2].name, "beyond the panel's edge");
  EXPECT_TRUE(is_within(file->voids[2].area, at(-1, 10)));
  EXPECT_FALSE(is_within(file->voids[2].area, at(1, 10)));
}

TEST(ZonesFile, MayBeEmpty) {
  const auto file = parsed("");
  ASSERT_TRUE(file) << file.error().text();
  EXPECT_TRUE(file->zones.empty() && file->voids.empty() && !file->probe_tip);
}

TEST(ZonesFile, RefusesWithLineAndColumn) {
  const auto refused = [](std::string_view text, Code code, std::string_view words) {
    EXPECT_THAT(parsed(text), FailsWith(code, std::string(words)));
  };
  const std::string zone = "[[zone]]\nname = \"left\"\n";
  refused(zone + "rectangel_mm = [0, 0, 1, 1]\n",
          Code::ConfigKeyUnknown,
          "zones.toml:3:1: error[config-key-unknown]");
  refused("[[zones]]\n", Code::ConfigKeyUnknown, "\"zone\"");
  refused(zone, Code::ConfigValue, "zones.toml:1:1: error[config-value]");
  refused(zone + "rectangle_mm = [0, 0, 0, 1]\n", Code::ConfigValue, "zones.toml:3:");
  refused(zone + "rectangle_mm = [0, 0, 1]\n", Code::ConfigValue, "zones.toml:3:");
  refused(zone + "center_mm = [0, 0]\n", Code::ConfigValue, "diameter_mm");
  refused(zone + "rectangle_mm = [0, 0, 1, 1]\ncenter_mm = [0, 0]\n",
          Code::ConfigValue,
          "rectangle_mm");
  refused(zone + "rectangle_mm = [0, 0, 1, 1]\ndiameter_mm = 3\n", Code::ConfigValue, "center_mm");
  refused(zone + "polygon_mm = [0, 0, 2, 2, 2, 0, 0, 3]\n",
          Code::ConfigValue,
          "zones.toml:3:14: error[config-value]");
  refused(zone + "polygon_mm = [0, 0, 2, 2, 3]\n", Code::ConfigValue, "zones.toml:3:");
  refused(zone + "polygon_mm = [0, 0, nan, 2]\n", Code::ConfigValue, "polygon_mm");
  refused(zone + "rectangle_mm = [0, 0, 1, 1]\nmodel = \"spline\"\n",
          Code::ConfigValue,
          "zones.toml:4:9");
  refused(zone + "rectangle_mm = [0, 0, 1, 1]\n" + zone + "rectangle_mm = [0, 0, 1, 1]\n",
          Code::ConfigValue,
          "zones.toml:5:8");
  refused("[[zone]]\nrectangle_mm = [0, 0, 1, 1]\n", Code::ConfigValue, "name");
  refused("[[void]]\nname = \"slit\"\ntrack_mm = [0, 0]\n", Code::ConfigValue, "width_mm");
  refused("[panel]\n", Code::ConfigValue, "[panel]");
  refused("probe_tip_mm = 0\n", Code::ConfigValue, "zones.toml:1:16");
  refused("[[zone]\n", Code::TomlSyntax, "zones.toml:1");
}

}  // namespace
}  // namespace panelcal
