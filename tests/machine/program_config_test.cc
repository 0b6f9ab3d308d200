// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/program_config.h"

#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

Expected<MachineConfig> parse(std::string_view toml) {
  return parse_machine_config(toml, "shop/machine.toml");
}

std::string refusal(std::string_view toml) {
  const auto config = parse(toml);
  return config ? "accepted" : config.error().text();
}

TEST(ProgramConfig, DefaultsDecideNothing) {
  const auto config = parse("[program]\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->reading.axis_version, 1);
  EXPECT_FALSE(config->reading.block_delete);
  EXPECT_TRUE(config->reading.pattern_folders.empty());
  EXPECT_TRUE(config->reading.diameter_page.empty());
  EXPECT_FALSE(config->walk.scaling);
  EXPECT_FALSE(config->travel);
  EXPECT_EQ(config->walk.arc_tolerance, um(1));
}

TEST(ProgramConfig, ReadsHowProgramsAreRead) {
  const auto config = parse(R"(
[program]
arc_tolerance_um = 2.5
axis_version = 3
block_delete = false
operator_id = "NIGHT SHIFT"
search_path = ["patterns", "/usr/share/patterns"]
)");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->walk.arc_tolerance, um(2.5));
  EXPECT_EQ(config->reading.axis_version, 3);
  EXPECT_EQ(config->reading.block_delete, false);
  EXPECT_EQ(config->reading.operator_id, "NIGHT SHIFT");
  ASSERT_EQ(config->reading.pattern_folders.size(), 2U);
  EXPECT_EQ(config->reading.pattern_folders[0], "shop/patterns");
  EXPECT_EQ(config->reading.pattern_folders[1], "/usr/share/patterns");
}

TEST(ProgramConfig, ReadsReferenceScaling) {
  const auto config =
      parse("[reference_scaling]\nx = 1.0003\ny = 0.9998\nabout_mm = [10, 20]\nenabled = true\n");
  ASSERT_TRUE(config) << config.error().text();
  ASSERT_TRUE(config->walk.scaling);
  EXPECT_EQ(config->walk.scaling->x, 1.0003);
  EXPECT_EQ(config->walk.scaling->y, 0.9998);
  EXPECT_EQ(config->walk.scaling->about, position_mm<frame::Nominal>(10, 20));
  EXPECT_TRUE(config->walk.scaling->starts_enabled);
}

TEST(ProgramConfig, AFactorIsNoShareInPpm) {
  EXPECT_EQ(refusal("[reference_scaling]\nx = 300\n"),
            "shop/machine.toml:2:5: error[config-value]: x in [reference_scaling] is 300, expected "
            "a number from 0.9 to 1.1");
}

TEST(ProgramConfig, ReadsTheDiameterPage) {
  const auto config = parse(R"(
[[diameter_page]]
diameter_mm = 1.016
infeed_mm_s = 85
retract_mm_s = 400
speed_rpm = 65000
max_hits = 2000
depth_offset_mm = -0.1
[[diameter_page]]
diameter_mm = 3.2
)");
  ASSERT_TRUE(config) << config.error().text();
  const auto& page = config->reading.diameter_page;
  ASSERT_EQ(page.size(), 2U);
  EXPECT_EQ(page[0].diameter, mm(1.016));
  EXPECT_EQ(page[0].infeed, mm_per_s(85));
  EXPECT_EQ(page[0].retract, mm_per_s(400));
  EXPECT_EQ(page[0].speed, rpm(65'000));
  EXPECT_EQ(page[0].max_hits, 2000);
  EXPECT_EQ(page[0].depth_offset, mm(-0.1));
  EXPECT_EQ(page[1], (Tool{.diameter = mm(3.2)}));
}

TEST(ProgramConfig, ADiameterPageRowNeedsItsDiameter) {
  EXPECT_EQ(refusal("[[diameter_page]]\nmax_hits = 3\n"),
            "shop/machine.toml:1:1: error[config-value]: [[diameter_page]] has no diameter_mm, "
            "expected diameter_mm = 1.016");
}

TEST(ProgramConfig, ReadsTravel) {
  const auto config = parse("[machine]\ntravel_low_mm = [-1, -2]\ntravel_high_mm = [600, 700]\n");
  ASSERT_TRUE(config) << config.error().text();
  ASSERT_TRUE(config->travel);
  EXPECT_EQ(config->travel->low, position_mm<frame::Machine>(-1, -2));
  EXPECT_EQ(config->travel->high, position_mm<frame::Machine>(600, 700));
}

TEST(ProgramConfig, TravelHasTwoCornersInOrder) {
  EXPECT_EQ(refusal("[machine]\ntravel_low_mm = [0, 0]\n"),
            "shop/machine.toml:1:1: error[config-value]: [machine] has no travel_high_mm, expected "
            "both corners of the travel");
  EXPECT_EQ(refusal("[machine]\ntravel_low_mm = [0, 9]\ntravel_high_mm = [5, 9]\n"),
            "shop/machine.toml:3:18: error[config-value]: travel_high_mm in [machine] is [5, 9], "
            "expected more than travel_low_mm in x and y");
}

TEST(ProgramConfig, RefusesWrongTypes) {
  EXPECT_EQ(refusal("[program]\nblock_delete = \"on\"\n"),
            "shop/machine.toml:2:16: error[config-value]: block_delete in [program] is \"on\", "
            "expected true or false");
  EXPECT_EQ(refusal("[program]\nsearch_path = \"here\"\n"),
            "shop/machine.toml:2:15: error[config-value]: search_path in [program] is \"here\", "
            "expected a list of texts, [\"a\", \"b\"]");
  EXPECT_EQ(refusal("[program]\nsearch_path = [\"here\", 3]\n"),
            "shop/machine.toml:2:24: error[config-value]: search_path in [program] is 3, expected "
            "a text in quotes");
  EXPECT_EQ(refusal("[program]\naxis_version = 9\n"),
            "shop/machine.toml:2:16: error[config-value]: axis_version in [program] is 9, expected "
            "a whole number from 1 to 8");
  EXPECT_EQ(refusal("[program]\noperator_id = \"ABCDEFGHIJKLMNOPQRSTU\"\n"),
            "shop/machine.toml:2:15: error[config-value]: operator_id in [program] is "
            "\"ABCDEFGHIJKLMNOPQRSTU\", expected at most 20 characters (OPID)");
}

}  // namespace
}  // namespace panelcal
