// SPDX-License-Identifier: Apache-2.0
#include "machine/job/facts/survey_facts.h"

#include <cmath>

#include "calib/base/json/facts.h"
#include "machine/job/facts/job_facts.h"
#include "machine/job/summary/depth_summary.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using facts::Json;
using ::testing::HasSubstr;

Operation hole(int line, std::string_view file) {
  Drill drill;
  drill.tool = 1;
  drill.cut.depth = mm(0.2);
  return {.line = line, .path = {}, .what = drill, .file = file, .origin = nullptr};
}

/// Holes of which the machine finds the surface itself, to 10 um.
void judge(DepthVerdict& verdict, std::string_view file = {}) {
  verdict.put(hole(7, file));
  verdict.put(hole(8, file));
}

Expected<ZonedMap> no_map() {
  return failure({Code::GridInvalid, {}, "there are 0 probes", "3 or more"});
}

Tolerances within(Length shallow, Length deep) {
  Tolerances tolerances;
  tolerances.depth = {shallow, deep};
  return tolerances;
}

Json depth_facts(const DepthVerdict& verdict) {
  JobFactsInput input;
  input.depth = &verdict;
  return Json::parse(job_facts(input))["depth"];
}

Json facts_of(const Survey& survey, const std::string& use = {}) {
  JobFactsInput input;
  input.survey = &survey;
  input.surface_use = use;
  return Json::parse(job_facts(input));
}

/// P(N(0, 1) > 2) = 0.02275, P(> 6) = 9.87e-10 (Abramowitz and Stegun, table 26.1).
TEST(DepthFacts, SayWhichSideIsAtRisk) {
  // 2 sigma to the one side, 6 to the other.
  DepthVerdict verdict(within(um(20), um(60)), um(10), no_map());
  judge(verdict, "<b>.sm");
  const Json depth = depth_facts(verdict);
  EXPECT_EQ(depth["decision"], "hold");
  EXPECT_THAT(depth["sentence"].get<std::string>(), HasSubstr("hold: 2 depths are more likely"));
  const Json& worst = depth["tools"][0]["worst"];
  EXPECT_NEAR(worst["risk_too_shallow"], 0.02275, 1e-5);
  EXPECT_NEAR(worst["risk_too_deep"], 9.87e-10, 1e-12);
  EXPECT_EQ(worst["file"], "<b>.sm");
  EXPECT_NEAR(depth["expected_broken"], 0.0455, 1e-4);
  EXPECT_EQ(depth["maps"], Json::array());
  EXPECT_THAT(depth["surface_lines"][0].get<std::string>(), HasSubstr("there are 0 probes"));
}

/// A board that rises 20 um in 100 mm along x.
HeightMap sloping() {
  std::vector<ProbePoint> points;
  for (int i = 0; i < 36; ++i) {
    const Eigen::Vector2d p_mm = 20.0 * Eigen::Vector2d(i % 6, i / 6);
    const double wobble_mm = i % 2 == 0 ? 0.001 : -0.001;
    points.push_back({position_mm<frame::Nominal>(p_mm),
                      {mm(1.6 + 2e-4 * p_mm.x() + wobble_mm), um(2)},
                      "probe",
                      {}});
  }
  HeightMapOptions options;
  options.model = SurfaceModel::Plane;
  return HeightMap::of_probes(points, options).value();
}

TEST(DepthFacts, HaveTheSurfaceOfEveryAxis) {
  Drill drill;
  drill.nominal = position_mm<frame::Nominal>(80, 50);
  drill.tool = 3;
  drill.cut.depth = mm(0.2);
  drill.cut.surface = mm(1.6);
  drill.cut.other_surfaces = {mm(1.7)};
  DepthVerdict verdict(within(um(20), um(20)),
                       DepthErrors(um(3), {ZonedMap(sloping()), ZonedMap(sloping())}));
  verdict.put({.line = 7, .path = {}, .what = drill, .file = {}, .origin = nullptr});
  const Json depth = depth_facts(verdict);
  // The second axis counts on a height that is 84 um too high there: much too shallow.
  EXPECT_EQ(depth["tools"][0]["worst"]["axis"], 1);
  ASSERT_EQ(depth["maps"].size(), 2);
  const Json& map = depth["maps"][1];
  const auto n = map["n_x"].get<std::size_t>() * map["n_y"].get<std::size_t>();
  ASSERT_EQ(map["height_mm"].size(), n);
  ASSERT_EQ(map["sigma_um"].size(), n);
  EXPECT_NEAR(map["height_mm"][0], 1.6, 2e-3);
  EXPECT_NEAR(map["height_mm"][n - 1], 1.62, 2e-3);
}

TEST(SurveyFacts, HaveEveryProbedSurface) {
  Survey survey;
  ProbeRequest request;
  request.seq = 3;
  request.line = 12;
  request.command = "G73";
  request.nominal = position_mm<frame::Nominal>(20, 30);
  request.memory = 7;
  request.reference = mm(1.6);
  survey.probes.push_back(
      {request, ProbeStatus::Found, {{mm(1.6125), um(2)}, {mm(1.5), um(2)}}, ""});
  request.seq = 4;
  request.memory.reset();
  survey.probes.push_back({request, ProbeStatus::NotFound, {}, "no <contact>"});
  const Json probes = facts_of(survey)["surface"]["probes"];
  EXPECT_EQ(probes[0]["memory"], 7);
  EXPECT_EQ(probes[0]["axes"][1]["height_mm"], 1.5);
  EXPECT_EQ(probes[0]["is_found"], true);
  EXPECT_EQ(probes[1]["is_found"], false);
  EXPECT_EQ(probes[1]["reason"], "no <contact>");
  EXPECT_TRUE(facts_of(Survey())["surface"].is_null());
  EXPECT_EQ(facts_of(Survey(), "2 depths count from the map")["surface"]["use"],
            "2 depths count from the map");
}

TEST(SurveyFacts, HaveEveryFocusWithItsCurve) {
  FocusResult focus;
  focus.request.line = 9;
  focus.is_found = true;
  focus.z = mm(0.7371);
  focus.sigma = um(1.2);
  for (int i = 0; i < 5; ++i) focus.curve.push_back({mm(0.2 * i), 0.001 * (5 - i)});
  Survey survey;
  survey.focus = {focus, focus};
  survey.focus[1].is_found = false;
  survey.focus[1].reason = "nothing <to> be seen";
  const Json rows = facts_of(survey)["focus"];
  EXPECT_EQ(rows[0]["z_mm"], 0.7371);
  EXPECT_EQ(rows[0]["curve"].size(), 5);
  EXPECT_TRUE(rows[1]["z_mm"].is_null());
  EXPECT_EQ(rows[1]["reason"], "nothing <to> be seen");
}

TEST(SurveyFacts, HaveEveryCalibration) {
  Survey survey;
  CalibrationAnswer answer;
  answer.order.line = 7;
  answer.order.command = "G39";
  answer.text = "found <it>";
  survey.calibrations.push_back(answer);
  EXPECT_EQ(facts_of(survey)["calibrations"],
            Json::array({{{"line", 7}, {"command", "G39"}, {"text", "found <it>"}}}));
}

Survey survey_with(SeriesResult series) {
  Survey survey;
  survey.measurements.resize(2);
  survey.measurements[1].request.seq = 1;
  survey.series.push_back(std::move(series));
  return survey;
}

TEST(SeriesFacts, ListCausesThatCannotBeToldApart) {
  SeriesResult series;
  series.points = {0, 1};
  series.fault.emplace();
  series.fault->p_value = 1e-7;
  series.fault->degrees_of_freedom = 3;
  series.fault->suspicions = {{FaultCause::TurnedHalf, {}, 0.6, "turned <so>"},
                              {FaultCause::DamagedMark, 1, 0.4, "off"}};
  const Json fault = facts_of(survey_with(series))["series"][0]["fault"];
  EXPECT_EQ(fault["is_named"], false);
  EXPECT_EQ(fault["causes"][0]["cause"], "turned by 180 degrees");
  EXPECT_EQ(fault["causes"][0]["text"], "turned <so>");
  EXPECT_EQ(fault["causes"][1]["target"], 1);
  EXPECT_TRUE(facts_of(survey_with({}))["series"][0]["fault"].is_null());
}

/// P(chi square of 1 > 3.84) = 0.05, > 6.63: 0.01; of 5 degrees > 0.0: 1 (Abramowitz and Stegun).
TEST(SeriesFacts, ClaimNoMoreOfAChiSquareThanItTells) {
  EXPECT_EQ(facts::chi_square_meaning(0, 0), "unchecked");
  EXPECT_EQ(facts::chi_square_meaning(1, 1), "weak");
  EXPECT_EQ(facts::chi_square_meaning(5, 1), "rather_large");
  EXPECT_EQ(facts::chi_square_meaning(7, 1), "too_large_weak");
  EXPECT_EQ(facts::chi_square_meaning(5, 5), "as_expected");
  EXPECT_EQ(facts::chi_square_meaning(50, 5), "too_large");
  EXPECT_EQ(facts::chi_square_meaning(0.01, 5), "too_small");
  EXPECT_EQ(facts::chi_square_meaning(std::nan(""), 5), "too_large");
}

/// Rigid is what the targets speak for, stretch in force.
TEST(SeriesFacts, CompareModels) {
  SeriesResult series;
  series.model = PanelModel::Stretch;
  for (const PanelModel model : {PanelModel::Rigid, PanelModel::Stretch}) {
    ModelScore score;
    score.model = model;
    score.is_chosen = model == PanelModel::Rigid;
    if (score.is_chosen) score.left_out_mm = 0.0065;
    series.compared.push_back(score);
  }
  const Json models = facts_of(survey_with(series))["series"][0]["models"];
  EXPECT_EQ(models[0]["name"], "rigid");
  EXPECT_EQ(models[0]["is_chosen"], true);
  EXPECT_EQ(models[0]["is_in_force"], false);
  EXPECT_EQ(models[0]["left_out_um"], 6.5);
  EXPECT_EQ(models[1]["is_in_force"], true);
  EXPECT_TRUE(models[1]["left_out_um"].is_null());
}

TEST(DepthSummary, HasARowForEachTool) {
  DepthVerdict verdict(within(um(20), um(60)), um(10), no_map());
  judge(verdict);
  EXPECT_THAT(depth_summary(verdict),
              HasSubstr("    T1        2     20.0 / 60.0    +0.00    10.00      2      2   2.3e-02 "
                        "  9.9e-10\n"));
  EXPECT_THAT(depth_summary(verdict), HasSubstr("depth verdict: hold: 2 depths are"));
}

}  // namespace
}  // namespace panelcal
