// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <string_view>
#include <utility>

#include "machine/config/machine_config.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

Expected<MachineConfig> parse(std::string_view toml) {
  return parse_machine_config(toml, "shop/machine.toml");
}

std::string refusal(std::string_view toml) {
  const auto config = parse(toml);
  return config ? "accepted" : test::brief(config.error());
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

TEST(ProgramConfig, ReadsTheNumbersOfTheControl) {
  EXPECT_FALSE(parse("[program]\n")->reading.inch_rates);
  EXPECT_EQ(parse("[program]\nrates = \"m/min\"\n")->reading.inch_rates, RateUnit::MetersPerMinute);
  const auto config =
      parse("[program]\nunits = \"inch\"\ndigits = \"2.3\"\nrates = \"inch/min\"\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->reading.last_format.unit, LengthUnit::Inch);
  EXPECT_EQ(config->reading.last_format.digits, std::pair(2, 3));
  EXPECT_EQ(config->reading.inch_rates, RateUnit::InchesPerMinute);
  EXPECT_NE(refusal("[program]\nrates = \"mm/s\"\n"), "accepted");
  EXPECT_NE(refusal("[program]\nzeros = \"TZ\"\ndigits = \"2.3\"\n"), "accepted");
}

TEST(ProgramConfig, ReadsWhatASiebMeyerControlKnows) {
  const auto config = parse(R"(
[program]
breakage_counter = 3
character_set = "4x6"
module = "M2"
obeys_areas = false
operator_id = "NIGHT SHIFT"
run = 12
spindle = 5
)");
  ASSERT_TRUE(config) << config.error().text();
  const sieb_meyer::Settings& settings = config->walk.sieb_meyer;
  EXPECT_EQ(settings.characters, CharacterSet::Dots4x6);
  EXPECT_EQ(settings.obeys_areas, false);
  EXPECT_EQ(settings.text.module, "M2");
  EXPECT_EQ(settings.text.breakage_counter, 3);
  EXPECT_EQ(settings.text.run, 12);
  EXPECT_EQ(settings.text.spindle, 5);
  EXPECT_EQ(settings.text.operator_text, "NIGHT SHIFT");
}

TEST(ProgramConfig, KnowsEveryCharacterSet) {
  const struct {
    std::string_view name;
    CharacterSet set;
  } cases[] = {
      {"3x5", CharacterSet::Dots3x5},
      {"4x6", CharacterSet::Dots4x6},
      {"5x7", CharacterSet::Dots5x7},
      {"excellon", CharacterSet::Excellon4x7},
      {"hitachi", CharacterSet::Hitachi},
  };
  for (const auto& [name, set] : cases) {
    const auto config = parse("[program]\ncharacter_set = \"" + std::string(name) + "\"\n");
    ASSERT_TRUE(config) << config.error().text();
    EXPECT_EQ(config->walk.sieb_meyer.characters, set) << name;
  }
}

TEST(ProgramConfig, NothingSaidAboutAreasIsNotNo) {
  const auto config = parse("[program]\nspindle = 1\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_FALSE(config->walk.sieb_meyer.obeys_areas.has_value());
}

TEST(ProgramConfig, ReadsTheSurface) {
  const auto config = parse(R"(
[surface]
average = "T"
fill_gaps = true
grid_hold_mm = 4
height_mm = 1.6
height_tolerance_um = 25
max_sigma_um = 12
tolerance_mm = 0.15
)");
  ASSERT_TRUE(config) << config.error().text();
  const sieb_meyer::Settings& settings = config->walk.sieb_meyer;
  EXPECT_EQ(settings.average, AverageKind::TrimmedMean);
  EXPECT_EQ(settings.grid_hold, mm(4));
  EXPECT_EQ(settings.surface_height, mm(1.6));
  EXPECT_TRUE(settings.fills_gaps);
  EXPECT_EQ(config->walk.board.height_tolerance, um(25));
  EXPECT_EQ(config->walk.board.max_sigma, um(12));
  EXPECT_EQ(settings.surface_tolerance, mm(0.15));
}

/// The letters are SPAV's (SIEB & MEYER, G74).
TEST(ProgramConfig, AveragesHaveTheLettersOfSpav) {
  const struct {
    std::string_view letter;
    AverageKind kind;
  } cases[] = {
      {"A", AverageKind::Mean},
      {"M", AverageKind::Median},
      {"O", AverageKind::MidRange},
      {"T", AverageKind::TrimmedMean},
  };
  for (const auto& [letter, kind] : cases) {
    const auto config = parse("[surface]\naverage = \"" + std::string(letter) + "\"\n");
    ASSERT_TRUE(config) << config.error().text();
    EXPECT_EQ(config->walk.sieb_meyer.average, kind) << letter;
  }
}

TEST(ProgramConfig, RefusesWhatNoControlKnows) {
  EXPECT_EQ(refusal("[program]\ncharacter_set = \"6x9\"\n"),
            "shop/machine.toml:2:17: error[config-value]");
  EXPECT_EQ(refusal("[program]\nspindle = 65\n"), "shop/machine.toml:2:11: error[config-value]");
  EXPECT_EQ(refusal("[program]\nobey_areas = true\n"),
            "shop/machine.toml:2:1: error[config-key-unknown]");
  EXPECT_EQ(refusal("[surface]\naverage = \"mean\"\n"),
            "shop/machine.toml:2:11: error[config-value]");
  EXPECT_EQ(refusal("[surface]\ntolerance_mm = 0\n"),
            "shop/machine.toml:2:16: error[config-value]");
  EXPECT_EQ(refusal("[surface]\ngrid_hold = 1\n"),
            "shop/machine.toml:2:1: error[config-key-unknown]");
}

TEST(ProgramConfig, ReadsHowDeepToolsWork) {
  const auto config = parse(R"(
[[depth]]
drill_mm = 0.8
depth_mm = 0.6
[[depth]]
number = 3
depth_mm = 0.3
)");
  ASSERT_TRUE(config) << config.error().text();
  const BoardDepths& board = config->walk.board;
  EXPECT_EQ(board.map, nullptr);
  EXPECT_EQ(board.depth_of(1, mm(0.8003)), mm(0.6));
  EXPECT_EQ(board.depth_of(3, mm(0.8)), mm(0.3));
  EXPECT_EQ(board.depth_of(3, std::nullopt), mm(0.3));
  EXPECT_FALSE(board.depth_of(1, std::nullopt));
  EXPECT_FALSE(board.depth_of(1, mm(0.81)));
}

TEST(ProgramConfig, RefusesDepthsOfNoToolOrOfOneTwice) {
  EXPECT_EQ(refusal("[[depth]]\ndepth_mm = 1\n"), "shop/machine.toml:1:1: error[config-value]");
  EXPECT_EQ(refusal("[[depth]]\nnumber = 1\ndrill_mm = 1\ndepth_mm = 1\n"),
            "shop/machine.toml:3:12: error[config-value]");
  EXPECT_EQ(refusal("[[depth]]\nnumber = 1\n"), "shop/machine.toml:1:1: error[config-value]");
  EXPECT_EQ(refusal("[[depth]]\nnumber = 1\ndepth_mm = 0\n"),
            "shop/machine.toml:3:12: error[config-value]");
  EXPECT_EQ(refusal("[[depth]]\nnumber = 1\ndepth_mm = 1\n[[depth]]\nnumber = 1\ndepth_mm = 2\n"),
            "shop/machine.toml:5:10: error[config-value]");
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
            "shop/machine.toml:2:5: error[config-value]");
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

/// C# takes a row within 0.5 um: of two such rows, one would never count.
TEST(ProgramConfig, ADiameterHasOneRowOfTheDiameterPage) {
  const auto page = [](std::string_view other) {
    return "[[diameter_page]]\ndiameter_mm = 0.8\n[[diameter_page]]\ndiameter_mm = " +
           std::string(other) + "\n";
  };
  EXPECT_EQ(refusal(page("0.8002")), "shop/machine.toml:4:15: error[config-value]");
  EXPECT_EQ(refusal(page("0.7996")), "shop/machine.toml:4:15: error[config-value]");
  EXPECT_TRUE(parse(page("0.8006")));
}

TEST(ProgramConfig, ADiameterPageRowNeedsItsDiameter) {
  EXPECT_EQ(refusal("[[diameter_page]]\nmax_hits = 3\n"),
            "shop/machine.toml:1:1: error[config-value]");
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
            "shop/machine.toml:1:1: error[config-value]");
  EXPECT_EQ(refusal("[machine]\ntravel_low_mm = [0, 9]\ntravel_high_mm = [5, 9]\n"),
            "shop/machine.toml:3:18: error[config-value]");
}

TEST(ProgramConfig, RefusesWrongTypes) {
  EXPECT_EQ(refusal("[program]\nblock_delete = \"on\"\n"),
            "shop/machine.toml:2:16: error[config-value]");
  EXPECT_EQ(refusal("[program]\nsearch_path = \"here\"\n"),
            "shop/machine.toml:2:15: error[config-value]");
  EXPECT_EQ(refusal("[program]\nsearch_path = [\"here\", 3]\n"),
            "shop/machine.toml:2:24: error[config-value]");
  EXPECT_EQ(refusal("[program]\naxis_version = 9\n"),
            "shop/machine.toml:2:16: error[config-value]");
  EXPECT_EQ(refusal("[program]\noperator_id = \"ABCDEFGHIJKLMNOPQRSTU\"\n"),
            "shop/machine.toml:2:15: error[config-value]");
}

}  // namespace
}  // namespace panelcal
