// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/tolerance.h"

#include <string>
#include <string_view>

#include "machine/config/machine_config.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

Tolerances tolerances_of(std::string_view toml) {
  const auto config = parse_machine_config(toml, "machine.toml");
  EXPECT_TRUE(config) << config.error().text();
  return config ? config->walk.tolerances : Tolerances();
}

std::string refusal(std::string_view toml) {
  const auto config = parse_machine_config(toml, "machine.toml");
  return config ? "accepted" : test::brief(config.error());
}

TEST(ToleranceConfig, AsksNothingWithoutTheTable) {
  EXPECT_FALSE(tolerances_of("[gates]\n").asks_positions());
  EXPECT_FALSE(tolerances_of("[gates]\n").asks_depths());
  EXPECT_FALSE(tolerances_of("").radius(1, mm(1)));
}

TEST(ToleranceConfig, ReadsEveryKey) {
  const Tolerances tolerances = tolerances_of(R"(
[tolerance]
position_um = 75
warn_probability = 1e-3
hold_probability = 0.05
[[tolerance.tool]]
number = 3
position_um = 40
[[tolerance.tool]]
drill_mm = 0.3
pad_mm = 0.5
min_ring_um = 50
[[tolerance.tool]]
number = 7
drill_mm = 0.8
pad_mm = 1.0
)");
  EXPECT_EQ(tolerances.warn_above, 1e-3);
  EXPECT_EQ(tolerances.hold_above, 0.05);
  EXPECT_EQ(tolerances.radius(1, mm(1.5)), um(75));
  EXPECT_EQ(tolerances.radius(1, std::nullopt), um(75));
  // A number goes before a diameter.
  EXPECT_EQ(tolerances.radius(3, mm(0.3)), um(40));
  // (0.5 - 0.3) / 2 - 0.05 mm
  EXPECT_NEAR(tolerances.radius(4, mm(0.3))->in_um(), 50, 1e-9);
  EXPECT_NEAR(tolerances.radius(4, mm(0.3004))->in_um(), 49.8, 1e-9);
  EXPECT_EQ(tolerances.radius(4, mm(0.301)), um(75));
  // The diameter that the program leaves out.
  EXPECT_NEAR(tolerances.radius(7, std::nullopt)->in_um(), 100, 1e-9);
  EXPECT_NEAR(tolerances.radius(7, mm(0.8))->in_um(), 100, 1e-9);
}

TEST(ToleranceConfig, ReadsDepths) {
  const Tolerances tolerances = tolerances_of(R"(
[tolerance]
too_shallow_um = 30
too_deep_um = 20
[[tolerance.tool]]
number = 3
too_deep_um = 5
[[tolerance.tool]]
drill_mm = 0.3
position_um = 40
)");
  EXPECT_TRUE(tolerances.asks_depths());
  EXPECT_EQ(tolerances.depth_of(1, std::nullopt).too_shallow, um(30));
  EXPECT_EQ(tolerances.depth_of(1, std::nullopt).too_deep, um(20));
  EXPECT_FALSE(tolerances.depth_of(3, std::nullopt).too_shallow);
  EXPECT_EQ(tolerances.depth_of(3, std::nullopt).too_deep, um(5));
  EXPECT_EQ(tolerances.depth_of(4, mm(0.3)).too_deep, um(20));
  // A row of depths asks nothing of positions.
  EXPECT_FALSE(tolerances.radius(3, std::nullopt));
  EXPECT_EQ(tolerances.problem(3, std::nullopt), "");
  EXPECT_EQ(tolerances.radius(4, mm(0.3)), um(40));
  // A row of the one kind does not hide a row of the other.
  EXPECT_EQ(tolerances.radius(3, mm(0.3)), um(40));
}

TEST(ToleranceConfig, OfDepthsAloneAsksNoPositions) {
  EXPECT_FALSE(tolerances_of("[tolerance]\ntoo_deep_um = 20\n").asks_positions());
  EXPECT_TRUE(tolerances_of("[tolerance]\nposition_um = 20\n").asks_positions());
  EXPECT_FALSE(tolerances_of("[tolerance]\nposition_um = 20\n").asks_depths());
}

TEST(ToleranceConfig, SaysWhyAToolHasNone) {
  const Tolerances tolerances = tolerances_of(R"(
[tolerance]
position_um = 75
[[tolerance.tool]]
number = 3
pad_mm = 0.5
min_ring_um = 50
[[tolerance.tool]]
number = 4
drill_mm = 0.3
pad_mm = 0.5
)");
  EXPECT_FALSE(tolerances.radius(3, std::nullopt));
  EXPECT_THAT(tolerances.problem(3, std::nullopt), testing::HasSubstr("tool 3"));
  EXPECT_FALSE(tolerances.radius(3, mm(0.4)));
  EXPECT_EQ(tolerances.problem(3, mm(0.4)),
            "a 0.4 mm hole in a 0.5 mm pad has no room beside a ring of 50 um");
  EXPECT_FALSE(tolerances.radius(4, mm(0.35)));
  EXPECT_EQ(tolerances.problem(4, mm(0.35)),
            "tool 4 has 0.35 mm in the program and 0.3 mm in [[tolerance.tool]]");
  EXPECT_EQ(tolerances.problem(3, mm(0.3)), "");
  EXPECT_EQ(tolerances.problem(9, std::nullopt), "");
}

TEST(ToleranceConfig, RefusesWhatItDoesNotKnow) {
  EXPECT_EQ(refusal("[tolerance]\npositon_um = 3\n"),
            "machine.toml:2:1: error[config-key-unknown]");
  EXPECT_EQ(refusal("[[tolerance.tool]]\nnumber = 1\nmin_ring_mm = 3\n"),
            "machine.toml:3:1: error[config-key-unknown]");
  EXPECT_EQ(refusal("[tolerance]\nposition_um = 0\n"), "machine.toml:2:15: error[config-value]");
}

TEST(ToleranceConfig, RefusesWhatMakesNoSense) {
  const auto expects = [](std::string_view toml, std::string_view part) {
    const auto config = parse_machine_config(toml, "machine.toml");
    ASSERT_FALSE(config) << toml;
    EXPECT_NE(config.error().text().find(part), std::string::npos) << config.error().text();
  };
  expects("[tolerance]\n", "[tolerance]: missing key \"position_um\"");
  expects("[[tolerance.tool]]\nposition_um = 5\n", "[[tolerance.tool]]: missing key \"number\"");
  expects("[[tolerance.tool]]\nnumber = 5\n", "[[tolerance.tool]]: missing key \"position_um\"");
  expects("[[tolerance.tool]]\nnumber = 5\nposition_um = 5\npad_mm = 1\n", "there are both");
  expects("[[tolerance.tool]]\nnumber = 5\nposition_um = 5\nmin_ring_um = 1\n",
          "min_ring_um in [[tolerance.tool]] is 1; expected pad_mm beside it");
  expects(
      "[[tolerance.tool]]\nnumber = 5\nposition_um = 5\n"
      "[[tolerance.tool]]\nnumber = 5\nposition_um = 6\n",
      "another row names it");
  expects(
      "[[tolerance.tool]]\ndrill_mm = 0.3\nposition_um = 5\n"
      "[[tolerance.tool]]\ndrill_mm = 0.3005\nposition_um = 6\n",
      "another row names it");
  expects("[tolerance]\nposition_um = 5\nwarn_probability = 0.1\n",
          "expected warn_probability at most hold_probability");
  expects("[tolerance]\nposition_um = 5\nhold_probability = 2\n", "expected a number from 0 to 1");
}

}  // namespace
}  // namespace panelcal
