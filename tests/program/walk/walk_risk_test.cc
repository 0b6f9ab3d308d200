// SPDX-License-Identifier: Apache-2.0
// Operations that get the probability of breaking their tolerance.
#include <cmath>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "calib/correction/breaking_probability.h"

#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using test::metric;
using test::says;

/// The ends of kept slots, with the tool in use.
class SlotEnds final : public OperationSink {
 public:
  void put(const Operation& operation) override {
    if (const auto* slot = std::get_if<Slot>(&operation.what)) {
      ends.push_back(slot->start);
      ends.push_back(slot->end);
    }
  }
  std::vector<PlacedPoint> ends;
};

WalkOptions with_tolerance(Length position) {
  WalkOptions options;
  options.tolerances.position = position;
  return options;
}

double expected_risk(const PlacedPoint& point, Length radius) {
  return breaking_probability(point.cov_mm2, radius);
}

TEST(WalkRisk, HolesHaveItWhileACorrectionIsInForce) {
  const Length radius = um(3);
  const auto run = test::run_program(
      metric("G34,1\nT1\nX1.0Y1.0\nG35X0.0Y0.0\nX10.0Y20.0\nG37\nX10.0Y20.0\nM30\n"),
      with_tolerance(radius));
  ASSERT_TRUE(run.diagnostics.empty()) << run.diagnostics.front();
  ASSERT_EQ(run.holes().size(), 3U);
  EXPECT_FALSE(run.holes()[0].drill.risk);
  ASSERT_TRUE(run.holes()[1].drill.risk);
  EXPECT_GT(*run.holes()[1].drill.risk, 0);
  EXPECT_EQ(*run.holes()[1].drill.risk, expected_risk(run.holes()[1].drill, radius));
  EXPECT_FALSE(run.holes()[2].drill.risk);
}

TEST(WalkRisk, AHoleAtItsOwnTargetHasIt) {
  const auto run =
      test::run_program(metric("G34,1\nT1\nG38X5.0Y5.0\nM30\n"), with_tolerance(um(3)));
  ASSERT_EQ(run.holes().size(), 1U) << run.diagnostics.front();
  EXPECT_EQ(run.holes()[0].drill.risk, expected_risk(run.holes()[0].drill, um(3)));
}

TEST(WalkRisk, IsThatOfTheToolInUse) {
  WalkOptions options = with_tolerance(um(3));
  options.tolerances.tools.push_back({.number = 2, .position = um(4)});
  const auto run = test::run_program(
      metric("G34,1\nT1\nG35X0.0Y0.0\nX1.0Y1.0\nT2\nX1.0Y1.0\nT1\nX1.0Y1.0\nM30\n"), options);
  ASSERT_EQ(run.holes().size(), 3U) << run.diagnostics.front();
  EXPECT_EQ(run.holes()[0].drill.risk, expected_risk(run.holes()[0].drill, um(3)));
  EXPECT_EQ(run.holes()[1].drill.risk, expected_risk(run.holes()[1].drill, um(4)));
  EXPECT_LT(*run.holes()[1].drill.risk, *run.holes()[0].drill.risk);
  EXPECT_EQ(run.holes()[2].drill.risk, run.holes()[0].drill.risk);
}

TEST(WalkRisk, SlotsAndRoutsHaveItAtTheirEnds) {
  WalkOptions options = with_tolerance(um(3));
  options.slots = Cycles::Kept;
  const auto run = test::run_program(metric("G34,1\nT1\nG35X0.0Y0.0\nX1.0Y1.0G85X9.0Y1.0\n"
                                            "G00X0.0Y0.0\nM15\nG01X5.0Y0.0\nM16\nG05\nM30\n"),
                                     options);
  ASSERT_FALSE(run.has_errors) << run.diagnostics.front();
  SlotEnds slots;
  DiagnosticLog log;
  execute(run.program, options, run.survey, slots, log);
  ASSERT_EQ(slots.ends.size(), 2U);
  for (const PlacedPoint& end : slots.ends) EXPECT_EQ(end.risk, expected_risk(end, um(3)));
  ASSERT_EQ(run.executed.routs().size(), 1U);
  EXPECT_EQ(run.executed.routs()[0].risk, expected_risk(run.executed.routs()[0], um(3)));
}

TEST(WalkRisk, AToolWithoutRoomIsAnErrorWhereItIsTaken) {
  WalkOptions options;
  options.tolerances.tools.push_back({.number = 2, .ring = AnnularRing{um(10), um(0)}});
  const auto run =
      test::run_program(metric("T1\nX1.0Y1.0\nT2\nX1.0Y1.0\nT2\nX2.0Y1.0\nM30\n"), options);
  EXPECT_TRUE(run.has_errors);
  ASSERT_FALSE(run.diagnostics.empty());
  EXPECT_THAT(run.diagnostics.front(), says(8, "tolerance-invalid"));
}

}  // namespace
}  // namespace panelcal
