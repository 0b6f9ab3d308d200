// SPDX-License-Identifier: Apache-2.0
#include "tools/synth/sweep/sweep_file.h"

#include <ostream>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::synth {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kHead =
    "machine = \"machine.toml\"\nprogram = \"panel.exc\"\ndesign = \"grid\"\n";

Expected<Sweep> parsed(const std::string& text) {
  return parse_sweep(text, "folder/sweep.toml");
}

std::string factor(const std::string& key, const std::string& rest) {
  return "[[factor]]\nkey = \"" + key + "\"\n" + rest + "\n";
}

TEST(SweepFile, GridOfValuesAndLevels) {
  const auto sweep = parsed(kHead + factor("noise", "values = [1, 12]") +
                            factor("blur_px", "from = 0.5\nto = 8\nlevels = 3\nscale = \"log\"") +
                            factor("neighbors", "from = 0\nto = 4\nlevels = 3"));
  ASSERT_TRUE(sweep) << sweep.error().text();
  EXPECT_EQ(sweep->machine, "folder/machine.toml");
  EXPECT_EQ(sweep->program, "folder/panel.exc");
  EXPECT_EQ(sweep->n_points(), 18);
  EXPECT_EQ(point_of(*sweep, 0).id, "000001");
  EXPECT_THAT(point_of(*sweep, 0).values, ElementsAre(1, 0.5, 0));
  EXPECT_THAT(point_of(*sweep, 5).values, ElementsAre(1, 2, 4)) << "2 is 0.5 * sqrt(8 / 0.5)";
  EXPECT_THAT(point_of(*sweep, 17).values, ElementsAre(12, 8, 4));
}

TEST(SweepFile, RepeatsHaveTheValuesAndOtherSeeds) {
  const auto sweep =
      parsed(std::string("repeats = 3\n") + kHead + factor("noise", "values = [1, 12]"));
  ASSERT_TRUE(sweep) << sweep.error().text();
  std::multiset<double> values;
  std::set<std::uint64_t> seeds;
  for (std::size_t i = 0; i < sweep->n_points(); ++i) {
    values.insert(point_of(*sweep, i).values.front());
    seeds.insert(point_of(*sweep, i).seed);
  }
  EXPECT_THAT(values, ElementsAre(1, 1, 1, 12, 12, 12));
  EXPECT_EQ(seeds.size(), 6);
}

TEST(SweepFile, WholeNumbersOfARangeComeEquallyOften) {
  const auto sweep =
      parsed("machine = \"machine.toml\"\ntool = 1\ndesign = \"latin-hypercube\"\npoints = 60\n" +
             factor("neighbors", "from = 2\nto = 4"));
  ASSERT_TRUE(sweep) << sweep.error().text();
  std::multiset<double> values;
  for (std::size_t i = 0; i < 60; ++i) values.insert(point_of(*sweep, i).values.front());
  for (const double value : {2., 3., 4.}) EXPECT_EQ(values.count(value), 20) << value;
}

TEST(SweepFile, PutsValuesWhereMachineTomlHasThem) {
  const auto sweep = parsed(kHead + factor("noise", "values = [3.0000000000000004]") +
                            factor("debris.scratches", "values = [2]") +
                            factor("panel_offset_mm.y", "values = [-0.25]"));
  ASSERT_TRUE(sweep) << sweep.error().text();
  const std::string machine =
      "[[vision.tool]]\nnumber = 1\nshape = \"disc\"\nsize_px = 80\npolarity = \"bright\"\n"
      "[sim]\nblur_px = 1.5\npanel_offset_mm = [0.5, 1]\n";
  const Point point = point_of(*sweep, 0);
  const auto config = machine_of(*sweep, point, machine);
  ASSERT_TRUE(config) << config.error().text();
  ASSERT_TRUE(config->sim);
  EXPECT_EQ(config->sim->noise, 3.0000000000000004) << "to the last bit";
  EXPECT_EQ(config->sim->blur_px, 1.5);
  EXPECT_EQ(config->sim->debris.scratches, 2);
  EXPECT_EQ(config->sim->panel_offset.in_mm().x(), 0.5);
  EXPECT_EQ(config->sim->panel_offset.in_mm().y(), -0.25);
  EXPECT_EQ(config->sim->seed, point.seed);
}

TEST(SweepFile, ASeedMayBeAFactor) {
  const auto sweep =
      parsed(kHead + factor("seed", "values = [7]") + factor("noise", "values = [1, 2]"));
  ASSERT_TRUE(sweep) << sweep.error().text();
  for (const std::size_t i : {0U, 1U}) {
    const auto config = machine_of(*sweep, point_of(*sweep, i), "[sim]\n");
    ASSERT_TRUE(config) << config.error().text();
    EXPECT_EQ(config->sim->seed, 7);
  }
}

TEST(SweepFile, RefusesAPairThatMachineTomlDoesNotState) {
  const auto sweep = parsed(kHead + factor("panel_offset_mm.x", "values = [1]"));
  ASSERT_TRUE(sweep) << sweep.error().text();
  const auto config = machine_of(*sweep, point_of(*sweep, 0), "[sim]\n");
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().code, Code::ConfigValue);
  EXPECT_THAT(config.error().what, HasSubstr("point 000001 (panel_offset_mm.x = 1)"));
}

struct Refusal {
  const char* name;
  std::string text;
  int line;
  std::string expected;
};

/// Instead of its bytes, which differ from run to run.
void PrintTo(const Refusal& refusal, std::ostream* out) {
  *out << refusal.name;
}

class SweepRefusal : public testing::TestWithParam<Refusal> {};

TEST_P(SweepRefusal, HasItsPlace) {
  const auto sweep = parsed(GetParam().text);
  ASSERT_FALSE(sweep);
  EXPECT_EQ(sweep.error().place.line, GetParam().line) << sweep.error().text();
  EXPECT_THAT(sweep.error().text(), HasSubstr(GetParam().expected));
}

const std::string kSobol = "machine = \"m.toml\"\nprogram = \"p.exc\"\ndesign = \"sobol\"\n";

INSTANTIATE_TEST_SUITE_P(
    All,
    SweepRefusal,
    testing::Values(
        Refusal{"Unknown", kHead + factor("noize", "values = [1]"), 5, "did you mean \"noise\"?"},
        Refusal{"OutOfRange", kHead + factor("noise", "values = [1, 256]"), 6, "from 0 to 255"},
        Refusal{"NoWhole", kHead + factor("neighbors", "values = [0.5]"), 6, "a whole number"},
        Refusal{"Upside", kHead + factor("noise", "from = 3\nto = 3\nlevels = 2"), 7, "above from"},
        Refusal{"NoRatio",
                kHead + factor("noise", "from = 0\nto = 3\nlevels = 2\nscale = \"log\""),
                6,
                "above 0"},
        Refusal{"Both", kHead + factor("noise", "values = [1]\nto = 3"), 7, "a range, or values"},
        Refusal{"NoLevels", kHead + factor("noise", "from = 1\nto = 3"), 1, "levels = 5"},
        Refusal{"PointsOfGrid",
                std::string("points = 3\n") + kHead + factor("noise", "values = [1]"),
                1,
                "none of a grid"},
        Refusal{"NoPoints", kSobol + factor("noise", "values = [1]"), 1, "points = 100"},
        Refusal{"NoFactor", kHead, 1, "[[factor]]"},
        Refusal{"Twice",
                kHead + factor("noise", "values = [1]") + factor("noise", "values = [2]"),
                8,
                "another factor has it"},
        Refusal{"TwoSubjects",
                std::string("tool = 1\n") + kHead + factor("noise", "values = [1]"),
                1,
                "there is a program already"},
        Refusal{"TooMany",
                kHead + factor("noise", "from = 1\nto = 3\nlevels = 1000") +
                    factor("blur_px", "from = 1\nto = 3\nlevels = 1000") +
                    factor("neighbors", "values = [1, 2]"),
                3,
                "too many points"},
        Refusal{"Column",
                kHead + factor("noise", "values = [1]\ncolumn = \"a b\""),
                7,
                "letters, digits and _"}),
    [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace panelcal::synth
