// SPDX-License-Identifier: Apache-2.0
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/job/facts/facts_job.h"

namespace panelcal {
namespace {

using facts::Json;
using test::facts_of;
using test::kProgram;
using test::run;
using ::testing::HasSubstr;
using ::testing::Not;

/// One place, likely to break its tolerance but less than certain to.
Tolerances warning() {
  Tolerances tolerances;
  tolerances.tools.push_back({.number = 2, .position = um(1)});
  tolerances.hold_above = 1;
  return tolerances;
}

std::string grounds_of(const Json& facts) {
  return facts["verdict"]["grounds"];
}

std::string next_step_of(const Json& facts) {
  return facts["verdict"]["next"];
}

/// The predicted sigmas are a few micrometres.
TEST(ToleranceFacts, SayHowSureItIs) {
  Tolerances tolerances;
  tolerances.position = um(1000);
  const Json sure = facts_of(*run(kProgram, {}, false, tolerances));
  EXPECT_EQ(sure["verdict"]["word"], "drill");
  EXPECT_EQ(sure["tolerance"]["decision"], "drill");
  EXPECT_EQ(sure["tolerance"]["n_judged"], 5);
  ASSERT_EQ(sure["tolerance"]["tools"].size(), 2);
  EXPECT_EQ(sure["tolerance"]["tools"][0]["tolerance_um"], 1000);
  EXPECT_EQ(sure["tolerance"]["tools"][0]["n_places"], 4);

  const Json unsure = facts_of(*run(kProgram, {}, false, warning()));
  EXPECT_EQ(unsure["verdict"]["word"], "warned");
  EXPECT_THAT(next_step_of(unsure), HasSubstr("run --explain L"));
  EXPECT_TRUE(facts_of(*run(kProgram))["tolerance"].is_null());
}

/// One hole without a correction, one with a tool of no tolerance, and no gates at all.
TEST(ToleranceFacts, ClaimNoMoreThanWasJudged) {
  Tolerances tolerances;
  tolerances.position = um(1000);
  EXPECT_THAT(grounds_of(facts_of(*run(kProgram, {}, false, tolerances))),
              HasSubstr("Every target was found, every fit is inside its limits, and all 5 places "
                        "are as sure to keep the tolerance as the machine's file asks."));

  Tolerances only_first;
  only_first.tools.push_back({.number = 1, .position = um(1000)});
  const auto part = run(kProgram, {}, false, only_first);
  EXPECT_THAT(grounds_of(facts_of(*part)),
              HasSubstr("and 4 of 5 places (not judged: 1 without a tolerance) are as sure"));
  Drill uncorrected;
  uncorrected.tool = 2;
  part->verdict->put({40, {}, uncorrected, {}, nullptr});
  for (SeriesResult& series : part->survey.series) series.gates.clear();
  EXPECT_THAT(grounds_of(facts_of(*part)),
              HasSubstr("Every target was found, no fit was held against any limit, since "
                        "machine.toml turns them off, and 4 of 6 places (not judged: 1 without a "
                        "correction and 1 without a tolerance) are as sure"));

  const auto warned = run(kProgram, {}, false, warning());
  for (SeriesResult& series : warned->survey.series) series.gates.clear();
  const std::string words = grounds_of(facts_of(*warned));
  EXPECT_THAT(words,
              HasSubstr("Every target was found, and no fit was held against any limit, since "
                        "machine.toml turns them off; but the tolerance is not as sure"));
  EXPECT_THAT(words, Not(testing::ContainsRegex("fits? (are|is) inside")));
}

/// --explain takes lines of the program alone.
TEST(ToleranceFacts, NameThePlaceToExplainSoThatItIsFound) {
  const auto job = run(kProgram, {}, false, warning());
  ASSERT_EQ(job->verdict->decision(), JobDecision::DrillWithWarning);
  const int line = job->verdict->worst_tool()->worst.line;
  EXPECT_THAT(next_step_of(facts_of(*job)),
              HasSubstr("run --explain L" + std::to_string(line) + " ("));
  job->input.worst_number = 500;
  EXPECT_THAT(next_step_of(facts_of(*job)), HasSubstr("run --explain 500 ("));
  job->input.worst_number.reset();
  Drill worst;
  worst.cov_mm2 = Eigen::Matrix2d::Identity();
  worst.tool = 2;
  worst.risk = worst.judged_risk = 0.999;
  JobVerdict of_a_pattern(warning());
  of_a_pattern.put({3, {}, worst, "PINS", nullptr});
  job->input.verdict = &of_a_pattern;
  const Json facts = facts_of(*job);
  EXPECT_THAT(next_step_of(facts),
              HasSubstr("see what the worst place's error is made of, below (drill, with"));
  EXPECT_THAT(next_step_of(facts), Not(HasSubstr("run --explain")));
  EXPECT_EQ(facts["tolerance"]["tools"][0]["worst"]["file"], "PINS");
}

constexpr double kUm2 = 1e-6;  // in mm^2

/// Sigmas of 4 and 3 um make 5; 16 and 9 are 64 and 36 percent of 25.
TEST(BudgetFacts, AddUpToTheHolesOwnCovariance) {
  MachineUncertainty machine;
  machine.spindle_camera_mm2 = 16 * kUm2 * Eigen::Matrix2d::Identity();
  JobFactsInput input;
  input.worst_hole =
      HoleBudget{.line = 13,
                 .file = "A<B",
                 .path = {0, 2},
                 .tool = 3,
                 .nominal = position_mm<frame::Nominal>(1., 2.),
                 .risk = std::nullopt,
                 .budget = error_budget_at_target(
                     machine, 9 * kUm2 * Eigen::Matrix2d::Identity(), CameraJacobian::Zero(), 0)};
  const Json budget = Json::parse(job_facts(input))["budget"];
  EXPECT_EQ(budget["file"], "A<B");
  EXPECT_EQ(budget["board"], Json::array({0, 2}));
  EXPECT_NEAR(budget["covariance_um2"][0].get<double>(), 25, 1e-9);
  double sum_um2 = 0;
  for (const Json& term : budget["terms"]) {
    sum_um2 += term["covariance_um2"][0].get<double>();
    const std::string source = term["source"];
    if (source == "detector") {
      EXPECT_NEAR(term["covariance_um2"][0], 9, 1e-9);
    }
    EXPECT_EQ(term["common_to"] == "all holes",
              source == "spindle-camera offset" || source == "its drift")
        << source;
    EXPECT_EQ(term["counts"] == true, source == "detector" || source == "spindle-camera offset")
        << source;
  }
  EXPECT_NEAR(sum_um2, 25, 1e-9);
}

}  // namespace
}  // namespace panelcal
