// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "tools/report/html.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/report/markup.h"
#include "tests/tools/report/report_job.h"

namespace panelcal {
namespace {

using test::kProgram;
using test::markup_problem;
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

/// The predicted sigmas are a few micrometres.
TEST(ReportHtml, ShowsHowSureTheToleranceIs) {
  Tolerances tolerances;
  tolerances.position = um(1000);
  const auto sure = run(kProgram, {}, false, tolerances);
  const std::string html = report_html(sure->input);
  EXPECT_THAT(html, HasSubstr("<h2 id=\"tolerance\">Tolerance</h2>"));
  EXPECT_LT(html.find("id=\"tolerance\""), html.find("<h2>Panel</h2>"));
  EXPECT_THAT(html, HasSubstr("Drill: no place is more likely than 0.0001"));
  EXPECT_THAT(html, HasSubstr("of 5; <a href=\"#tolerance\">"));
  EXPECT_THAT(html, Not(HasSubstr("WARNING")));
  EXPECT_EQ(markup_problem(html), "");

  const auto unsure = run(kProgram, {}, false, warning());
  EXPECT_EQ(unsure->verdict->decision(), JobDecision::DrillWithWarning);
  const std::string warned = report_html(unsure->input);
  EXPECT_THAT(warned, HasSubstr("DRILL, WITH A WARNING"));
  EXPECT_THAT(warned, HasSubstr("run --explain L"));
  EXPECT_EQ(markup_problem(warned), "");

  EXPECT_THAT(report_html(run(kProgram)->input), Not(HasSubstr("id=\"tolerance\"")));
}

/// One hole without a correction, one with a tool of no tolerance, and no gates at all.
TEST(ReportHtml, ClaimsNoMoreThanWasJudged) {
  Tolerances tolerances;
  tolerances.position = um(1000);
  const auto all = run(kProgram, {}, false, tolerances);
  EXPECT_THAT(report_html(all->input),
              HasSubstr("Every target was found, every fit is inside its limits, and all 5 places "
                        "are as sure to keep the tolerance as the machine&#39;s file asks."));

  Tolerances only_first;
  only_first.tools.push_back({.number = 1, .position = um(1000)});
  const auto part = run(kProgram, {}, false, only_first);
  EXPECT_THAT(report_html(part->input),
              HasSubstr("and 4 of 5 places (not judged: 1 without a tolerance) are as sure"));
  Drill uncorrected;
  uncorrected.tool = 2;
  part->verdict->put({40, {}, uncorrected, {}, nullptr});
  for (SeriesResult& series : part->survey.series) series.gates.clear();
  EXPECT_THAT(report_html(part->input),
              HasSubstr("Every target was found, no fit was held against any limit, since "
                        "machine.toml turns them off, and 4 of 6 places (not judged: 1 without a "
                        "correction and 1 without a tolerance) are as sure"));

  const auto warned = run(kProgram, {}, false, warning());
  for (SeriesResult& series : warned->survey.series) series.gates.clear();
  const std::string html = report_html(warned->input);
  EXPECT_THAT(html, HasSubstr("DRILL, WITH A WARNING"));
  EXPECT_THAT(html,
              HasSubstr("Every target was found, and no fit was held against any limit, since "
                        "machine.toml turns them off; but the tolerance is not as sure"));
  EXPECT_THAT(html, Not(testing::ContainsRegex("fits? (are|is) inside")));
}

/// --explain takes lines of the program alone.
TEST(ReportHtml, NamesThePlaceToExplainSoThatItIsFound) {
  const auto job = run(kProgram, {}, false, warning());
  ASSERT_EQ(job->verdict->decision(), JobDecision::DrillWithWarning);
  const int line = job->verdict->worst_tool()->worst.line;
  EXPECT_THAT(report_html(job->input), HasSubstr("run --explain L" + std::to_string(line) + " ("));
  job->input.worst_number = 500;
  EXPECT_THAT(report_html(job->input), HasSubstr("run --explain 500 ("));
  job->input.worst_number.reset();
  Drill worst;
  worst.cov_mm2 = Eigen::Matrix2d::Identity();
  worst.tool = 2;
  worst.risk = worst.judged_risk = 0.999;
  JobVerdict of_a_pattern(warning());
  of_a_pattern.put({3, {}, worst, "PINS", nullptr});
  job->input.verdict = &of_a_pattern;
  const std::string html = report_html(job->input);
  EXPECT_THAT(html,
              HasSubstr("see what the worst place&#39;s error is made of, below (drill, with"));
  EXPECT_THAT(html, Not(HasSubstr("run --explain")));
}

/// 9.96 is 10.0 in two digits, which is 1.0 of the next power.
TEST(ReportHtml, RoundsARiskBeforeItSplitsIt) {
  const auto job = run(kProgram);
  Tolerances tolerances;
  tolerances.position = um(10);
  for (const auto& [risk, text] : {std::pair(9.96e-5, "1.0 &#215; 10<sup>-4</sup>"),
                                   std::pair(6.34e-5, "6.3 &#215; 10<sup>-5</sup>")}) {
    JobVerdict verdict(tolerances);
    Drill drill;
    drill.tool = 1;
    drill.cov_mm2 = Eigen::Matrix2d::Identity();
    drill.risk = drill.judged_risk = risk;
    verdict.put({3, {}, drill, {}, nullptr});
    job->input.verdict = &verdict;
    EXPECT_THAT(report_html(job->input), HasSubstr(text));
  }
}

}  // namespace
}  // namespace panelcal
