// SPDX-License-Identifier: Apache-2.0
#include "program/judge/depth_verdict.h"

#include <cmath>
#include <vector>

#include "program/judge/probed_surface.h"

#include "tests/program/operations.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using namespace test;
using ::testing::HasSubstr;

constexpr double kSlope = 1e-3;  // 0.01 mm in 10 mm

/// Probes on a lattice of 100 mm about (50, 50) of a board that rises along x.
Survey probed(Length sigma, int n_side = 6) {
  Survey survey;
  for (int j = 0; j < n_side; ++j) {
    for (int i = 0; i < n_side; ++i) {
      const Eigen::Vector2d p_mm = 100.0 / (n_side - 1) * Eigen::Vector2d(i, j);
      ProbeReading reading;
      reading.request.line = 3;
      reading.request.command = "G79";
      reading.request.seq = static_cast<std::int64_t>(survey.probes.size());
      reading.request.nominal = position_mm<frame::Nominal>(p_mm);
      reading.status = ProbeStatus::Found;
      reading.heights = {{mm(1.6 + kSlope * p_mm.x()), sigma}};
      survey.probes.push_back(reading);
    }
  }
  return survey;
}

Expected<ZonedMap> map_of(const Survey& survey) {
  return probed_surface(survey, mm(5));
}

Tolerances within(std::optional<Length> shallow, std::optional<Length> deep) {
  Tolerances tolerances;
  tolerances.depth = {shallow, deep};
  return tolerances;
}

/// A hole 0.2 mm deep where the machine counts on the surface at this height.
Drill counted_on(double x_mm, double y_mm, Length surface, int tool = 1) {
  Drill hole;
  hole.nominal = position_mm<frame::Nominal>(x_mm, y_mm);
  hole.tool = tool;
  hole.cut = {std::nullopt, mm(0.2), surface};
  return hole;
}

const DepthVerdict::ToolFigures& only_tool(const DepthVerdict& verdict) {
  EXPECT_EQ(verdict.by_tool().size(), 1U);
  return verdict.by_tool().begin()->second;
}

TEST(DepthRisk, IsTheTailOnEitherSide) {
  const DepthRisk even = depth_risk({{}, um(10)}, {um(20), um(30)});
  EXPECT_NEAR(even.too_shallow, 0.0227501, 1e-7);
  EXPECT_NEAR(even.too_deep, 0.0013499, 1e-7);
  EXPECT_NEAR(even.either(), 0.0241, 1e-6);
  // 10 um deeper as it is: 30 um to the one side, 20 to the other.
  const DepthRisk deeper = depth_risk({um(10), um(10)}, {um(20), um(30)});
  EXPECT_NEAR(deeper.too_shallow, 0.0013499, 1e-7);
  EXPECT_NEAR(deeper.too_deep, 0.0227501, 1e-7);
}

TEST(DepthRisk, AsksNothingOfAnAbsentSide) {
  EXPECT_EQ(depth_risk({um(100), um(10)}, {um(20), std::nullopt}).too_deep, 0);
  EXPECT_EQ(depth_risk({um(-100), um(10)}, {std::nullopt, um(20)}).too_shallow, 0);
}

TEST(DepthRisk, OfAnExactDepthIsAllOrNothing) {
  EXPECT_EQ(depth_risk({um(20), {}}, {um(5), um(20)}).either(), 0);
  EXPECT_EQ(depth_risk({um(20.1), {}}, {um(5), um(20)}).too_deep, 1);
  EXPECT_EQ(depth_risk({um(-6), {}}, {um(5), um(20)}).too_shallow, 1);
}

TEST(DepthVerdict, HoldsAnOldProbeAgainstTheMapOfAll) {
  // One probe at x = 0 for a stroke at x = 50, where the board is 50 um higher.
  DepthVerdict verdict(within(um(30), um(40)), um(3), map_of(probed(um(2))));
  put_all(verdict, {counted_on(50, 50, mm(1.6))});
  const auto& tool = only_tool(verdict);
  EXPECT_NEAR(tool.largest_mean.in_um(), 50, 0.5);
  // 36 probes of 2 um hold a plane to 2 / sqrt(36) in its middle, what may bend is known no better
  // than by one of them, and the tool has 3 um.
  EXPECT_GT(tool.largest_sigma.in_um(), std::hypot(2.0 / 6, 3) - 0.01);
  EXPECT_LT(tool.largest_sigma.in_um(), std::hypot(2, 3));
  EXPECT_GT(tool.worst.risk.too_deep, 0.99);
  EXPECT_LT(tool.worst.risk.too_shallow, 1e-12);
  EXPECT_EQ(verdict.decision(), JobDecision::Hold);
  DiagnosticLog log;
  verdict.report("p.s5", log);
  ASSERT_EQ(log.kept().size(), 1U);
  EXPECT_EQ(log.kept()[0].code, Code::ToleranceHold);
  EXPECT_THAT(log.kept()[0].text(),
              Reports("p.s5:10:1: error[tolerance-hold]", "40 um", "probability 1 "));
}

TEST(DepthVerdict, LetsDrillWhereTheSurfaceIsWhereItWasProbed) {
  DepthVerdict verdict(within(um(30), um(40)), um(3), map_of(probed(um(2))));
  put_all(verdict, {counted_on(50, 50, mm(1.65)), counted_on(20, 80, mm(1.62))});
  EXPECT_EQ(verdict.decision(), JobDecision::Drill);
  EXPECT_EQ(verdict.places().n_judged, 2);
  EXPECT_THAT(verdict.sentence(), HasSubstr("drill: no depth is more likely than 0.0001"));
  DiagnosticLog log;
  verdict.report("p.s5", log);
  EXPECT_TRUE(log.kept().empty());
}

TEST(DepthVerdict, TakesTheMachinesWordWhereItFindsTheSurfaceItself) {
  Drill hole = counted_on(500, 500, {});
  hole.cut.surface.reset();
  DepthVerdict verdict(within(um(20), um(20)), um(10), map_of(probed(um(2))));
  put_all(verdict, {hole});
  EXPECT_EQ(only_tool(verdict).largest_sigma, um(10));
  EXPECT_NEAR(only_tool(verdict).worst.risk.either(), 0.0455, 1e-4);

  DepthVerdict unknown(within(um(20), um(20)), {}, map_of(probed(um(2))));
  put_all(unknown, {hole});
  EXPECT_EQ(unknown.places().n_unjudged, 1);
  EXPECT_EQ(unknown.decision(), JobDecision::NotJudged);
}

TEST(DepthVerdict, SaysWhatNobodyKnows) {
  // 1 m off the map; and without a map.
  DepthVerdict far(within(um(20), um(20)), um(3), map_of(probed(um(2))));
  put_all(far, {counted_on(50, 50, mm(1.65)), counted_on(1000, 50, mm(1.65))});
  EXPECT_EQ(far.places().n_judged, 1);
  EXPECT_EQ(far.places().n_unjudged, 1);
  EXPECT_EQ(far.decision(), JobDecision::DrillWithWarning);

  DepthVerdict blind(within(um(20), um(20)), um(3), map_of({}));
  put_all(blind, {counted_on(50, 50, mm(1.65))});
  EXPECT_EQ(blind.decision(), JobDecision::NotJudged);
  DiagnosticLog log;
  blind.report("p.s5", log);
  ASSERT_EQ(log.kept().size(), 1U);
  EXPECT_EQ(log.kept()[0].code, Code::ToleranceWarning);
  EXPECT_THAT(log.kept()[0].text(), Reports("p.s5: warning[tolerance-warning]", " 1 "));
}

TEST(DepthVerdict, JudgesNoPlaneAboveTheTable) {
  Drill through = counted_on(50, 50, {});
  through.cut = {mm(-0.3), std::nullopt, std::nullopt};
  DepthVerdict verdict(within(um(20), um(20)), um(3), map_of(probed(um(2))));
  put_all(verdict, {through});
  EXPECT_TRUE(verdict.by_tool().empty());
}

/// Probes of a dome of 0.3 mm on 100 mm about (50, 50).
Survey probed_dome() {
  Survey survey = probed(um(2), 7);
  for (ProbeReading& reading : survey.probes) {
    const Eigen::Vector2d p_mm = reading.request.nominal.in_mm() - Eigen::Vector2d(50, 50);
    reading.heights[0].height = mm(1.9 - 0.3 * p_mm.squaredNorm() / 5000);
  }
  return survey;
}

TEST(DepthVerdict, LooksAtContoursAllAlongTheirWay) {
  // The contour counts on the surface at its start, (0, 50), where the dome is 1.75 mm high; in the
  // middle it is 150 um higher. Both ends are right.
  const Drill start = counted_on(0, 50, mm(1.75)), end = counted_on(100, 50, mm(1.75));
  Rout line{end};
  line.tool = 1;
  line.cut = end.cut;
  DepthVerdict verdict(within(um(30), um(25)), um(3), map_of(probed_dome()));
  put_all(verdict, {RapidMove{start}, Plunge{.tool = 1, .cut = start.cut}, line, Retract{}});
  const auto& tool = only_tool(verdict);
  EXPECT_NEAR(tool.largest_mean.in_um(), 150, 3);
  EXPECT_EQ(tool.places.n_judged, 1);
  EXPECT_EQ(tool.places.n_held, 1);
  EXPECT_NEAR(tool.places.expected_broken, 1, 1e-6);
  EXPECT_NEAR(tool.worst.nominal.in_mm().x(), 50, 5);
}

TEST(DepthVerdict, FollowsArcsAndNotTheirChords) {
  // Half round (50, 50) from (20, 50) to (80, 50): the dome is as high all the way, 1.846 mm.
  const Length surface = mm(1.9 - 0.3 * 900 / 5000);
  const auto at = [&](double x_mm, double y_mm) {
    Drill hole = counted_on(x_mm, y_mm, surface);
    hole.corrected = position_mm<frame::Actual>(7 + x_mm, 3 + y_mm);  // the panel is shifted
    return hole;
  };
  for (const RoutKind kind : {RoutKind::Clockwise, RoutKind::Counterclockwise}) {
    Rout arc{at(80, 50)};
    arc.tool = 1;
    arc.kind = kind;
    arc.corrected_center = position_mm<frame::Actual>(57, 53);
    arc.cut = at(80, 50).cut;
    DepthVerdict verdict(within(um(30), um(25)), um(3), map_of(probed_dome()));
    put_all(verdict, {RapidMove{at(20, 50)}, Plunge{.tool = 1, .cut = arc.cut}, arc});
    EXPECT_NEAR(only_tool(verdict).largest_mean.in_um(), 0, 5);
    EXPECT_EQ(verdict.decision(), JobDecision::Drill);
  }
}

TEST(DepthVerdict, CountsSlotsAndContoursOnce) {
  const Drill at = counted_on(50, 50, mm(1.65)), far = counted_on(50, 90, mm(1.65));
  Rout rout{far};
  rout.tool = 2;
  rout.cut = far.cut;
  Rout back{at};
  back.tool = 2;
  back.cut = at.cut;
  const Plunge plunge{.tool = 2, .cut = at.cut};
  const Slot slot{.tool = 1, .start = at, .end = far, .cut = at.cut};
  DepthVerdict verdict(within(um(30), um(30)), um(3), map_of(probed(um(2))));
  verdict.begin(metric_info());
  put_all(verdict, {RapidMove{at}, plunge, rout, back, RapidMove{far}, plunge, back, slot});
  EXPECT_EQ(verdict.by_tool().at(1).places.n_judged, 1);
  EXPECT_EQ(verdict.by_tool().at(2).places.n_judged, 2);
}

TEST(DepthVerdict, TakesOffWhatAReferenceIsWrong) {
  // The reading at (20, 20) is 80 um too high, so planes are moved by 80 um too little.
  Drill hole = counted_on(50, 50, mm(1.65));
  hole.cut = {mm(1.4),
              std::nullopt,
              mm(1.65),
              PlaneReference{position_mm<frame::Nominal>(20, 20), mm(1.70)}};
  DepthVerdict verdict(within(um(30), um(30)), um(3), map_of(probed(um(2))));
  put_all(verdict, {hole});
  EXPECT_NEAR(only_tool(verdict).largest_mean.in_um(), 80, 1);
  EXPECT_EQ(verdict.decision(), JobDecision::Hold);
}

TEST(DepthVerdict, AsksOfEachToolWhatItsRowSays) {
  Tolerances tolerances = within(um(30), std::nullopt);
  tolerances.tools.push_back({.number = 2, .depth = {std::nullopt, um(5)}});
  tolerances.tools.push_back({.number = 3, .position = um(50)});
  DepthVerdict verdict(tolerances, um(3), map_of(probed(um(2))));
  for (const int tool : {1, 2, 3}) verdict.put({9, {}, counted_on(50, 50, mm(1.65), tool), {}});
  EXPECT_EQ(verdict.by_tool().at(1).tolerance.too_shallow, um(30));
  EXPECT_FALSE(verdict.by_tool().at(2).tolerance.too_shallow);
  EXPECT_EQ(verdict.by_tool().at(2).tolerance.too_deep, um(5));
  EXPECT_EQ(verdict.by_tool().at(3).tolerance.too_shallow, um(30));
  EXPECT_EQ(verdict.worst_tool(), &verdict.by_tool().at(2));
}

TEST(DepthVerdict, WarnsAndHoldsWhereSmallRisksAddUp) {
  // 3.72 sigma to one side: 1e-4 each.
  const auto decide = [](int n) {
    DepthVerdict verdict(within(um(37.2), std::nullopt), um(10), map_of({}));
    Drill hole = counted_on(0, 0, {});
    hole.cut.surface.reset();
    for (int i = 0; i < n; ++i) verdict.put({7, {}, hole, {}});
    return verdict.decision();
  };
  EXPECT_EQ(decide(900), JobDecision::Drill);
  EXPECT_EQ(decide(1100), JobDecision::DrillWithWarning);
  EXPECT_EQ(decide(11'000), JobDecision::Hold);
}

TEST(ProbedSurface, LeavesOutWildProbesThatTheGridCountsOn) {
  Survey survey = probed(um(2));
  ProbeReading& wild = survey.probes[14];  // at (40, 40)
  wild.heights[0].height = wild.heights[0].height + um(80);
  const auto map = map_of(survey);
  ASSERT_TRUE(map) << map.error().text();
  ASSERT_EQ(map->map(0).outliers().size(), 1U);
  EXPECT_EQ(map->map(0).outliers()[0].name, "G79 probe 14 (line 3)");
  // A hole that counts on it goes 80 um too shallow.
  DepthVerdict verdict(within(um(30), um(30)), um(3), map);
  put_all(verdict, {counted_on(40, 40, wild.heights[0].height)});
  EXPECT_NEAR(only_tool(verdict).largest_mean.in_um(), -80, 2);
  EXPECT_EQ(verdict.decision(), JobDecision::Hold);
}

TEST(ProbedSurface, NeedsProbesThatSayHowTheyScatter) {
  const auto exact = map_of(probed({}));
  ASSERT_FALSE(exact);
  EXPECT_EQ(exact.error().code, Code::MeasurementInvalid);
  EXPECT_THAT(exact.error().text(), HasSubstr("G79 probe 0 (line 3)"));
}

TEST(ProbedSurface, NeedsProbesEnoughToSeeABow) {
  // Through four corners goes a plane, and in the middle the board may be anywhere.
  EXPECT_TRUE(map_of(probed(um(2), 4)));
  Survey missed = probed(um(2), 4);
  for (std::size_t i = 0; i < 5; ++i) missed.probes[i].status = ProbeStatus::NotFound;
  ASSERT_FALSE(map_of(missed));
  EXPECT_EQ(map_of(missed).error().code, Code::GridInvalid);
  EXPECT_THAT(map_of(missed).error().text(), HasSubstr("11 probes"));
}

}  // namespace
}  // namespace panelcal
