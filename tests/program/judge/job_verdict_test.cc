// SPDX-License-Identifier: Apache-2.0
#include "program/judge/job_verdict.h"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"

#include "tests/program/operations.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using namespace test;
using ::testing::HasSubstr;

Tolerances within(Length position) {
  Tolerances tolerances;
  tolerances.position = position;
  return tolerances;
}

PlacedPoint uncertain(double sigma_x_um, double sigma_y_um, std::optional<double> risk) {
  PlacedPoint point = place(1, 2);
  const Eigen::Vector2d sigma_mm(sigma_x_um * 1e-3, sigma_y_um * 1e-3);
  point.cov_mm2 = sigma_mm.cwiseAbs2().asDiagonal();
  point.risk = point.judged_risk = risk;
  return point;
}

Drill risky(double risk, int tool = 1, double sigma_um = 2) {
  return {uncertain(sigma_um, sigma_um, risk), tool};
}

JobDecision decision_of(const std::vector<What>& operations) {
  JobVerdict verdict(within(um(10)));
  verdict.begin(metric_info());
  put_all(verdict, operations);
  return verdict.decision();
}

TEST(JobVerdict, DecidesByTheWorstPlace) {
  EXPECT_EQ(decision_of({}), JobDecision::NotJudged);
  EXPECT_EQ(decision_of({risky(1e-7), risky(1e-4)}), JobDecision::Drill);
  EXPECT_EQ(decision_of({risky(1e-7), risky(1.01e-4)}), JobDecision::DrillWithWarning);
  EXPECT_EQ(decision_of({risky(1e-2), risky(1e-7)}), JobDecision::DrillWithWarning);
  EXPECT_EQ(decision_of({risky(1.01e-2), risky(1e-7)}), JobDecision::Hold);
}

TEST(JobVerdict, WarnsAndHoldsWhereSmallRisksAddUp) {
  const auto decide = [](std::size_t n, double risk) {
    return decision_of(std::vector<What>(n, risky(risk)));
  };
  EXPECT_EQ(decide(999, 1e-4), JobDecision::Drill);
  EXPECT_EQ(decide(1001, 1e-4), JobDecision::DrillWithWarning);
  EXPECT_EQ(decide(9999, 1e-4), JobDecision::DrillWithWarning);
  EXPECT_EQ(decide(10'001, 1e-4), JobDecision::Hold);
  EXPECT_EQ(decide(111, 9e-3), JobDecision::DrillWithWarning);
  EXPECT_EQ(decide(112, 9e-3), JobDecision::Hold);
}

TEST(JobVerdict, SaysThatSmallRisksAddUp) {
  JobVerdict verdict(within(um(10)));
  for (int i = 0; i < 2000; ++i) verdict.put({7, {}, risky(1e-4), {}, nullptr});
  EXPECT_NEAR(verdict.expected_broken(), 0.2, 1e-9);
  DiagnosticLog log;
  verdict.report("p.exc", log);
  ASSERT_EQ(log.kept().size(), 1U);
  EXPECT_THAT(log.kept()[0].text(),
              Reports("p.exc: warning[tolerance-warning]", "0.2 of 2000", "0.1"));
  for (int i = 0; i < 8001; ++i) verdict.put({7, {}, risky(1e-4), {}, nullptr});
  DiagnosticLog held;
  verdict.report("p.exc", held);
  ASSERT_EQ(held.kept().size(), 1U);
  EXPECT_EQ(held.kept()[0].code, Code::ToleranceHold);
}

TEST(JobVerdict, WarnsOfPlacesThatNothingIsKnownOf) {
  Drill exact = risky(0, 2);
  exact.cov_mm2.setZero();
  exact.risk.reset();
  exact.judged_risk.reset();
  JobVerdict verdict(within(um(10)));
  verdict.begin(metric_info());
  put_all(verdict, {risky(1e-9), exact});
  EXPECT_EQ(verdict.n_unjudged(), 1);
  EXPECT_EQ(verdict.decision(), JobDecision::DrillWithWarning);
  DiagnosticLog log;
  verdict.report("p.exc", log);
  ASSERT_EQ(log.kept().size(), 1U);
  EXPECT_THAT(log.kept()[0].text(), Reports("p.exc: warning[tolerance-warning]", "1 place"));

  Tolerances only_first;
  only_first.tools.push_back({.number = 1, .position = um(10)});
  JobVerdict others(only_first);
  others.begin(metric_info());
  put_all(others, {risky(1e-9), exact});
  EXPECT_EQ(others.decision(), JobDecision::Drill);
}

TEST(JobVerdict, DoesNotJudgeWhatHasNoCorrection) {
  Drill exact = risky(0);
  exact.cov_mm2.setZero();
  exact.risk.reset();
  exact.judged_risk.reset();
  JobVerdict verdict(within(um(10)));
  verdict.begin(metric_info());
  put_all(verdict, {exact, exact});
  EXPECT_EQ(verdict.decision(), JobDecision::NotJudged);
  EXPECT_EQ(verdict.n_uncorrected(), 2);
  put_all(verdict, {risky(0.3)});
  EXPECT_EQ(verdict.decision(), JobDecision::Hold);
  EXPECT_THAT(verdict.sentence(), HasSubstr("; 2 places without a correction are not judged"));
}

TEST(JobVerdict, CountsSlotsAndRoutsByTheirEnds) {
  Slot slot{1, uncertain(2, 2, 0.5), uncertain(2, 2, 0.25), {}};
  RapidMove start{uncertain(2, 2, 0.125)};
  Rout rout{uncertain(2, 2, 1e-3)};
  rout.tool = 2;
  JobVerdict verdict(within(um(10)));
  verdict.begin(metric_info());
  // Only the move behind which the tool goes down counts.
  put_all(verdict, {slot, start, start, Plunge{2}, rout, rout, Retract{}, start});
  EXPECT_EQ(verdict.by_tool().at(1).n_judged, 2);
  EXPECT_EQ(verdict.by_tool().at(1).expected_broken, 0.75);
  EXPECT_EQ(verdict.by_tool().at(2).n_judged, 3);
  // A circle's: exp(-r^2 / (2 sigma^2)); what the move said was of another tool.
  EXPECT_NEAR(verdict.by_tool().at(2).expected_broken, 0.002 + std::exp(-12.5), 1e-12);
  EXPECT_EQ(verdict.n_held(), 2);
  EXPECT_EQ(verdict.n_warned(), 4);
}

TEST(JobVerdict, JudgesAPlungeByTheToolThatGoesDown) {
  Tolerances tolerances;
  tolerances.tools.push_back({.number = 1, .position = um(100)});
  tolerances.tools.push_back({.number = 2, .position = um(4)});
  JobVerdict verdict(tolerances);
  verdict.begin(metric_info());
  put_all(verdict, {RapidMove{uncertain(2, 2, 0)}, Plunge{2}});
  EXPECT_NEAR(verdict.by_tool().at(2).expected_broken, std::exp(-2.0), 1e-9);
}

TEST(JobVerdict, NamesTheWorstPlaceOfEachTool) {
  JobVerdict verdict(within(um(10)));
  verdict.begin(metric_info());
  const std::array<int, 2> path = {0, 3};
  verdict.put({5, {}, risky(2e-3), {}, nullptr});
  verdict.put({6, path, risky(0.04), {}, nullptr});
  verdict.put({7, {}, risky(0.04), {}, nullptr});
  verdict.put({8, {}, risky(3e-4, 2), "holes.drl", nullptr});
  DiagnosticLog log;
  verdict.report("p.exc", log);
  ASSERT_EQ(log.kept().size(), 2U);
  EXPECT_THAT(log.kept()[0].text(),
              Reports("p.exc:6:1: error[tolerance-hold]",
                      "2 of 3",
                      "tool 1",
                      "10 um",
                      "(0.750, 1.500) mm",
                      "[0,3]",
                      "0.04",
                      "0.01"));
  EXPECT_THAT(log.kept()[1].text(),
              Reports("holes.drl:8:1: warning[tolerance-warning]",
                      "1 of 1",
                      "tool 2",
                      "(0.750, 1.500) mm",
                      "0.0003",
                      "0.0001"));
}

TEST(JobVerdict, KnowsTheToleranceOfADiameterThatTheProgramChanges) {
  Tolerances tolerances;
  tolerances.tools.push_back({.drill = mm(1), .ring = AnnularRing{mm(1.2), um(50)}});
  tolerances.tools.push_back({.drill = mm(1.1), .ring = AnnularRing{mm(1.2), um(20)}});
  JobVerdict verdict(tolerances);
  verdict.begin(metric_info());
  put_all(verdict, {risky(0)});
  EXPECT_NEAR(verdict.by_tool().at(1).tolerance->in_um(), 50, 1e-9);
  put_all(verdict, {ToolChange{{.number = 1, .diameter = mm(1.1)}, {}}, risky(0)});
  EXPECT_NEAR(verdict.by_tool().at(1).tolerance->in_um(), 30, 1e-9);
}

TEST(JobVerdict, SortsRisksByDecade) {
  JobVerdict verdict(within(um(10)));
  put_all(
      verdict,
      {risky(0), risky(0.9e-12), risky(1.1e-12), risky(2e-5), risky(5e-4), risky(0.5), risky(1)});
  const auto& decades = verdict.decades();
  EXPECT_EQ(decades[0].n(), 2);
  EXPECT_EQ(decades[1].n(), 1);
  EXPECT_EQ(decades[8].n_good, 1);    // 1e-5 to 1e-4
  EXPECT_EQ(decades[9].n_warned, 1);  // 1e-4 to 1e-3
  EXPECT_EQ(decades[12].n_held, 2);
}

/// The predicted figures are those of the mixture of all holes' errors: draws of it agree.
TEST(JobVerdict, PredictsWhatDrawsGive) {
  constexpr std::uint64_t kSeed = 20260702;
  constexpr int kDraws = 40'000;  // of each hole
  const std::vector<std::array<double, 2>> sigmas_um = {{3, 3}, {9, 2}, {1, 12}, {5, 0}};
  Random random(kSeed);
  JobVerdict verdict(within(um(30)));
  RadialFigures drawn;
  double broken = 0;
  std::vector<double> lengths_um;
  for (const auto& [x_um, y_um] : sigmas_um) {
    const Drill hole{uncertain(x_um, y_um, std::nullopt), 1};
    Drill judged = hole;
    judged.risk = judged.judged_risk = breaking_probability(hole.cov_mm2, um(30));
    verdict.put({5, {}, judged, {}, nullptr});
    for (int i = 0; i < kDraws; ++i) {
      const double length_um = std::hypot(x_um * random.normal(), y_um * random.normal());
      ++drawn.n;
      drawn.sum_mm += length_um * 1e-3;
      drawn.sum_squares_mm2 += length_um * length_um * 1e-6;
      if (length_um > 30) ++broken;
    }
  }
  const JobVerdict::ToolFigures& tool = verdict.by_tool().at(1);
  // Of the mean: sigma / sqrt(N); of the deviation about the same.
  const double limit_um = 4 * tool.predicted.deviation().in_um() / std::sqrt(4.0 * kDraws);
  EXPECT_NEAR(tool.predicted.mean().in_um(), drawn.mean().in_um(), limit_um);
  EXPECT_NEAR(tool.predicted.deviation().in_um(), drawn.deviation().in_um(), 2 * limit_um);
  EXPECT_NEAR(*tool.predicted.cpk(um(30)), *drawn.cpk(um(30)), 0.02);
  const double expected = tool.expected_broken * kDraws;
  EXPECT_NEAR(broken, expected, 4 * std::sqrt(expected));
  EXPECT_NEAR(tool.largest_sigma.in_um(), 12, 1e-9);
  EXPECT_NEAR(
      tool.largest_radius_95.in_um(), radius_exceeded({um(12), um(1)}, 0.05).in_um(), 12 * 2e-4);
}

TEST(JobVerdict, RadiiOf95PercentAreCloseBetweenTheNodes) {
  for (const double small_um : {0.0, 0.03, 0.08, 0.3, 1.2, 2.5, 3.9, 5.55, 7.7, 9.1, 9.93, 10.0}) {
    JobVerdict verdict(within(um(30)));
    verdict.put({5, {}, Drill{uncertain(10, small_um, 0), 1}, {}, nullptr});
    const double exact_um = radius_exceeded({um(10), um(small_um)}, 0.05).in_um();
    EXPECT_NEAR(verdict.by_tool().at(1).largest_radius_95.in_um() / exact_um, 1, 1e-4) << small_um;
  }
}

/// Limits hold what is judged, whatever may be stated of it.
TEST(JobVerdict, HoldsByRisksThatAreNotStated) {
  Drill unknown = risky(0.5);
  unknown.risk.reset();
  JobVerdict verdict(within(um(10)));
  verdict.put({7, {}, unknown, {}, nullptr});
  EXPECT_EQ(verdict.decision(), JobDecision::Hold);
  EXPECT_EQ(verdict.n_told(), 0);
  verdict.set_basis({RiskBasis::Kind::Unknown, "no risk figure: drill wander not stated", true});
  EXPECT_EQ(verdict.sentence(),
            "hold: 1 place is more likely than 0.01 to break the tolerance by sigma alone, the "
            "worst in line 7; no risk figure: drill wander not stated");
  DiagnosticLog log;
  verdict.report("p.exc", log);
  ASSERT_EQ(log.kept().size(), 1U);
  EXPECT_THAT(log.kept()[0].text(), HasSubstr("drill wander not stated"));
  EXPECT_THAT(log.kept()[0].text(), testing::Not(HasSubstr("0.5")));
}

TEST(JobVerdict, KnowsThePlaceThatAnUnnoticedErrorMovesFurthest) {
  JobVerdict verdict(within(um(10)));
  verdict.put({5, {}, risky(1e-7), {}, nullptr});
  EXPECT_EQ(verdict.worst_unseen(), nullptr);
  for (const auto& [line, unseen_um] : {std::pair(6, 20), std::pair(7, 30), std::pair(8, 25)}) {
    Drill bounded = risky(1e-7);
    bounded.risk = kMinStatedRisk;
    bounded.unseen = um(unseen_um);
    verdict.put({line, {}, bounded, {}, nullptr});
  }
  ASSERT_NE(verdict.worst_unseen(), nullptr);
  EXPECT_EQ(verdict.worst_unseen()->line, 7);
  EXPECT_EQ(verdict.by_tool().at(1).stated_risk, kMinStatedRisk);
  // The limits are not held against what cannot be told: that would warn of every small panel.
  EXPECT_EQ(verdict.decision(), JobDecision::Drill);
}

TEST(RadialFigures, CpkIsOneSided) {
  // Two holes 10 and 14 um off: mean 12, deviation 2.
  const RadialFigures figures{.n = 2, .sum_mm = 0.024, .sum_squares_mm2 = 296e-6};
  EXPECT_NEAR(figures.mean().in_um(), 12, 1e-9);
  EXPECT_NEAR(figures.deviation().in_um(), 2, 1e-6);
  EXPECT_NEAR(figures.mean_plus_3_sigma().in_um(), 18, 1e-6);
  EXPECT_NEAR(*figures.cpk(um(24)), 2, 1e-6);
  EXPECT_NEAR(*figures.cpk(um(9)), -0.5, 1e-6);
  EXPECT_FALSE(RadialFigures{}.cpk(um(9)));
}

}  // namespace
}  // namespace panelcal
