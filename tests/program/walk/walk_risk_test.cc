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

/// Nothing but what the targets' pictures state.
WalkOptions exact_machine(Length position) {
  WalkOptions options = with_tolerance(position);
  options.uncertainty.states_stage = true;
  options.uncertainty.states_table = true;
  options.uncertainty.states_wander = true;
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
  ASSERT_TRUE(run.holes()[1].drill.judged_risk);
  EXPECT_GT(*run.holes()[1].drill.judged_risk, 0);
  EXPECT_EQ(*run.holes()[1].drill.judged_risk, expected_risk(run.holes()[1].drill, radius));
  EXPECT_FALSE(run.holes()[2].drill.risk);
}

TEST(WalkRisk, AHoleAtItsOwnTargetHasIt) {
  const auto run =
      test::run_program(metric("G34,1\nT1\nG38X5.0Y5.0\nM30\n"), with_tolerance(um(3)));
  ASSERT_EQ(run.holes().size(), 1U) << run.diagnostics.front();
  EXPECT_EQ(run.holes()[0].drill.judged_risk, expected_risk(run.holes()[0].drill, um(3)));
}

/// The body of a panel with n targets at the corners of 100 x 100 mm and a hole in the middle.
std::string corners(int n) {
  constexpr const char* kTargets[] = {
      "G36X0.0Y0.0\n", "G36X100.0Y0.0\n", "G36X0.0Y100.0\n", "G36X100.0Y100.0\n"};
  std::string body = "G34,1\nT1\n";
  for (int i = 0; i < n; ++i) body += kTargets[i];
  return metric(body + "X50.0Y50.0\nM30\n");
}

TEST(WalkRisk, IsNotStatedWhileTheMachineIsNot) {
  WalkOptions options = exact_machine(um(30));
  options.series_size = 4;
  const auto told = test::run_program(corners(4), options);
  ASSERT_EQ(told.holes().size(), 1U) << told.diagnostics.front();
  EXPECT_EQ(told.holes()[0].drill.risk, told.holes()[0].drill.judged_risk);
  options.uncertainty.states_wander = false;
  const auto run = test::run_program(corners(4), options);
  EXPECT_FALSE(run.holes()[0].drill.risk);
  EXPECT_TRUE(run.holes()[0].drill.judged_risk);
}

TEST(WalkRisk, IsNotToldBelowAThousandthWhereTargetsDoNotCheckEachOther) {
  for (const int n_targets : {1, 2, 3, 4}) {
    // Of 1 um: 30 um are never broken by chance, and no error that four targets hide breaks them.
    WalkOptions options = exact_machine(um(30));
    options.series_size = n_targets;
    const auto run = test::run_program(corners(n_targets), options);
    ASSERT_EQ(run.holes().size(), 1U) << run.diagnostics.front();
    const Drill& drill = run.holes()[0].drill;
    ASSERT_TRUE(drill.risk);
    EXPECT_LT(*drill.judged_risk, 1e-12);
    if (n_targets < 4) {
      EXPECT_EQ(*drill.risk, kMinStatedRisk) << n_targets;
      EXPECT_GT(drill.unseen, um(30)) << n_targets;
    } else {
      EXPECT_EQ(*drill.risk, *drill.judged_risk);
      EXPECT_LT(drill.unseen, um(10));
    }
  }
}

TEST(WalkRisk, IsNotToldWhereAnUnnoticedErrorMayBreakTheTolerance) {
  WalkOptions options = exact_machine(um(3));
  options.series_size = 4;
  const auto run = test::run_program(corners(4), options);
  ASSERT_EQ(run.holes().size(), 1U) << run.diagnostics.front();
  EXPECT_LT(*run.holes()[0].drill.judged_risk, kMinStatedRisk);
  EXPECT_EQ(*run.holes()[0].drill.risk, kMinStatedRisk);
}

TEST(WalkRisk, IsNotStatedOfTargetsThatChiSquareRefuses) {
  WalkOptions options = exact_machine(um(30));
  options.series_size = 4;
  test::FunctionSource source([](const MeasurementRequest& request) -> Eigen::Vector2d {
    const double wrong_mm = request.seq == 3 ? 0.05 : 0;
    return request.nominal.in_mm() + Eigen::Vector2d(wrong_mm, 0);
  });
  const auto run = test::run_program(corners(4), options, source);
  ASSERT_EQ(run.holes().size(), 1U) << run.diagnostics.front();
  EXPECT_FALSE(run.holes()[0].drill.risk);
  EXPECT_GT(*run.holes()[0].drill.judged_risk, 0);
}

TEST(WalkRisk, OfAHoleAtItsOwnTargetIsNotToldBelowAThousandth) {
  const auto run =
      test::run_program(metric("G34,1\nT1\nG38X5.0Y5.0\nM30\n"), exact_machine(um(30)));
  ASSERT_EQ(run.holes().size(), 1U) << run.diagnostics.front();
  EXPECT_EQ(*run.holes()[0].drill.risk, kMinStatedRisk);
}

TEST(WalkRisk, IsThatOfTheToolInUse) {
  WalkOptions options = with_tolerance(um(3));
  options.tolerances.tools.push_back({.number = 2, .position = um(4)});
  const auto run = test::run_program(
      metric("G34,1\nT1\nG35X0.0Y0.0\nX1.0Y1.0\nT2\nX1.0Y1.0\nT1\nX1.0Y1.0\nM30\n"), options);
  ASSERT_EQ(run.holes().size(), 3U) << run.diagnostics.front();
  EXPECT_EQ(run.holes()[0].drill.judged_risk, expected_risk(run.holes()[0].drill, um(3)));
  EXPECT_EQ(run.holes()[1].drill.judged_risk, expected_risk(run.holes()[1].drill, um(4)));
  EXPECT_LT(*run.holes()[1].drill.judged_risk, *run.holes()[0].drill.judged_risk);
  EXPECT_EQ(run.holes()[2].drill.judged_risk, run.holes()[0].drill.judged_risk);
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
  for (const PlacedPoint& end : slots.ends) EXPECT_EQ(end.judged_risk, expected_risk(end, um(3)));
  ASSERT_EQ(run.executed.routs().size(), 1U);
  EXPECT_EQ(run.executed.routs()[0].judged_risk, expected_risk(run.executed.routs()[0], um(3)));
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
