// SPDX-License-Identifier: Apache-2.0
#include "machine/check/coupon_rules.h"

#include <string>
#include <string_view>
#include <vector>

#include "machine/config/machine_config.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::Reports;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// Holes of 0.8 mm (80 px of 0.01 mm), nine a night, at x = 300, 302, 304 and y = 100 to 158 mm.
constexpr std::string_view kCoupon =
    "[[vision.tool]]\n"
    "number = 1\n"
    "shape = \"hole\"\n"
    "size_px = 80\n"
    "[coupon]\n"
    "origin_mm = [300, 100]\n"
    "rows = 30\n";

std::vector<std::string> problems(const std::string& rest) {
  const std::string text = std::string(kCoupon) + rest;
  auto config = parse_machine_config(text, "machine.toml");
  if (!config) return {config.error().text()};
  config->camera.emplace().parameters.scale_mm_per_px = 0.01;
  DiagnosticLog log;
  check_coupon_rules(*config, StatedKeys::of_text(text, "machine.toml"), log);
  std::vector<std::string> texts;
  for (const Diagnostic& diagnostic : log.kept()) texts.push_back(diagnostic.text());
  return texts;
}

std::string night(const std::string& rest, const std::string& calibrate = "spindle-camera") {
  return "pitch_mm = 2\n[nightly]\ncamera = \"folder:p\"\ncalibrate = [\"" + calibrate + "\"]\n" +
         rest;
}

TEST(CouponRules, HolesDoNotOverlap) {
  EXPECT_THAT(problems("pitch_mm = 0.81\n"), IsEmpty());
  EXPECT_THAT(
      problems("pitch_mm = 0.8\n"),
      ElementsAre(Reports("machine.toml:8:12: error[config-value]", "0.8 mm wide", "overlap")));
}

TEST(CouponRules, ANightHasAsManyHolesAsItHasToSee) {
  EXPECT_THAT(problems(night("gates.min_holes = 9\n")), IsEmpty());
  EXPECT_THAT(problems(night("gates.min_holes = 10\n")),
              ElementsAre(Reports(
                  "machine.toml:12:19: error[config-value]", "is 10", "drills 9", "at most 9")));
}

TEST(CouponRules, TheMarkIsNotDrilled) {
  // The rim of the last hole is 0.4 mm to the right of x = 304 mm.
  EXPECT_THAT(problems(night("mark_mm = [304.41, 158]\n")), IsEmpty());
  EXPECT_THAT(problems(night("mark_mm = [304.39, 158]\n")),
              ElementsAre(Reports(
                  "machine.toml:12:11: error[config-value]", "(304.390, 158.000)", "[coupon]")));
}

TEST(CouponRules, TheSurfaceIsProbedBesideTheCoupon) {
  const auto probed = [](const std::string& low_mm) {
    return problems(night("[nightly.surface]\nfile = \"s.json\"\nlow_mm = " + low_mm +
                              "\nhigh_mm = [400, 300]\ncolumns = 5\nrows = 5\n",
                          "surface"));
  };
  EXPECT_THAT(probed("[304.41, 90]"), IsEmpty());
  // Rows are 52.5 mm apart: the second one at y = 142.5 mm.
  EXPECT_THAT(
      probed("[304.39, 90]"),
      ElementsAre(Reports(
          "machine.toml:14:10: error[config-value]", "[coupon]", "probes (304.390, 142.500)")));
  // Columns to the left and to the right of the coupon, at x = 280 and 310 mm, and none on it.
  EXPECT_THAT(probed("[280, 90]"), IsEmpty());
}

TEST(CouponRules, RowsThatNoRunTakesAreNotDrilled) {
  // Runs of 7 rows leave two of 30: the last hole is at y = 154 mm.
  EXPECT_THAT(problems("rows_per_run = 7\n" + night("mark_mm = [304, 154.39]\n")), SizeIs(1));
  EXPECT_THAT(problems("rows_per_run = 7\n" + night("mark_mm = [304, 154.41]\n")), IsEmpty());
}

TEST(CouponRules, AskNothingOfAMachineWithoutACoupon) {
  DiagnosticLog log;
  check_coupon_rules(MachineConfig(), StatedKeys::of_text("", "machine.toml"), log);
  EXPECT_THAT(log.kept(), IsEmpty());
}

}  // namespace
}  // namespace panelcal
