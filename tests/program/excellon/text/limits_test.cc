// SPDX-License-Identifier: Apache-2.0
// Small programs that ask for more than any machine could do end soon, and say why.
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::metric;
using test::ProgramRun;
using test::Reports;
using test::run_program;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using Texts = std::vector<std::string>;

std::string nested_repeats(const std::string& pattern) {
  std::string body = "G34,1\nT1\nM25\n" + pattern;
  for (int level = 0; level < 5; ++level) body += "M01\nR9999M02X.001\n";
  return metric(body + "M08\nM30\n");
}

WalkOptions limited() {
  WalkOptions options;
  options.max_operations = 20'000;
  options.max_measurements = 2'000;
  return options;
}

TEST(Limits, HolesOfNestedRepeatsEndAtMaxOperations) {
  const ProgramRun run = run_program(nested_repeats("X0.Y0.\n"), limited());
  // Found by multiplying, before any copy is walked.
  EXPECT_THAT(run.texts, ElementsAre(Reports("p.exc:8: error[too-many-operations]", " 20000 ")));
  EXPECT_TRUE(run.executed.lines().empty());
}

TEST(Limits, RepeatedHolesCountToo) {
  const ProgramRun run =
      run_program(metric("T1\nX0.Y0.\nR9999X.001\nR9999X.001\nR9999Y.001\nM30\n"), limited());
  EXPECT_EQ(run.diagnostics, Texts{"p.exc:9: error[too-many-operations]"});
}

TEST(Limits, TargetsOfNestedRepeatsEndAtMaxMeasurements) {
  const ProgramRun run = run_program(nested_repeats("G35X0.Y0.\n"), limited());
  EXPECT_THAT(run.texts, ElementsAre(Reports("p.exc:9: error[too-many-operations]", " 2000 ")));
  EXPECT_EQ(run.survey.measurements.size(), 2'000U);
}

TEST(Limits, CopiesWithAnotherToolCountOnce) {
  const std::string program = metric("T1\nM25\nX0.Y0.\nM01\nM02X1.Y0.T2\nM08\nM30\n");
  WalkOptions options;
  options.max_operations = 6;  // the ends of header and program, two tools, two holes
  const auto too_many = HasSubstr("error[too-many-operations]");
  EXPECT_THAT(run_program(program, options).diagnostics, Not(Contains(too_many)));
  options.max_operations = 5;
  EXPECT_THAT(run_program(program, options).diagnostics, Contains(too_many));
}

TEST(Limits, LinesThatDoNothingCountToo) {
  // A rewind in a pattern makes the survey walk every copy.
  const std::string store = "M50,1\nM25\nG35X0.Y0.\nM01\nM08\n";
  for (const char* pattern : {"M51,1\n", "M51,1\n; comment\n\n", "M51,1\nG90\n"}) {
    std::string body = nested_repeats(pattern);
    body.insert(body.find("M25"), store);
    const ProgramRun run = run_program(body, limited());
    ASSERT_EQ(run.texts.size(), 1U) << pattern;
    EXPECT_THAT(run.texts[0], AllOf(HasSubstr("error[too-many-operations]"), HasSubstr(" 20000 ")));
  }
}

TEST(Limits, IdleLinesHaveALimitOfTheirOwn) {
  WalkOptions options = limited();
  options.max_operations = 100;
  std::string body = nested_repeats("M51,1\n");
  body.insert(body.find("M25"), "M50,1\nM25\nG35X0.Y0.\nM01\nM08\n");
  const ProgramRun run = run_program(body, options);
  ASSERT_EQ(run.texts.size(), 1U);
  EXPECT_THAT(run.texts[0], HasSubstr("limit exceeded: more than 10000 idle lines"));
}

TEST(Limits, HolesWithoutAToolCountToo) {
  std::string body = nested_repeats("$uvis,lamp,1\nX0.Y0.\nR9999X.001\n");
  body.erase(body.find("T1\nM25"), 3);
  const ProgramRun run = run_program(body, limited());
  ASSERT_EQ(run.diagnostics.size(), 2U);
  EXPECT_NE(run.diagnostics[0].find("tool-missing"), std::string::npos);
  EXPECT_NE(run.diagnostics[1].find("too-many-operations"), std::string::npos);
}

TEST(Limits, AMistakeInAPatternIsReportedOnce) {
  const ProgramRun run =
      run_program(metric("G34,1\nT1\nM25\nG45X0.Y0.\nG99\nX1.Y1.Q\nM01\nR5M02X9.\nM08\nM30\n"));
  EXPECT_EQ(run.diagnostics.size(), 2U);
}

TEST(Limits, NothingFollowsTheErrorThatEndsAWalk) {
  const ProgramRun run = run_program(metric("T1\nM25\nX0.Y0.\nX1.Y1.\nM30\n"));
  EXPECT_EQ(run.diagnostics, Texts{"p.exc:7:1: error[repeat-unclosed]"});
}

TEST(Limits, SixtyFourLevelsAreTheMost) {
  std::string levels;
  for (int level = 0; level < 64; ++level) levels += "M01\n";
  EXPECT_EQ(run_program(metric("T1\nM25\nX0.Y0.\n" + levels + "M08\nM30\n")).diagnostics, Texts{});
  EXPECT_EQ(run_program(metric("T1\nM25\nX0.Y0.\n" + levels + "M01\nM08\nM30\n")).diagnostics,
            Texts{"p.exc:73:1: error[nesting-too-deep]"});
}

TEST(Limits, MemoryForDiagnosticsIsBounded) {
  std::string body;
  for (int i = 0; i < 1000; ++i) body += "G99\n";
  DiagnosticLog log;
  const Program program = load_program({"p.exc", metric(body + "M30\n")}, log);
  NominalSource source;
  survey(program, {}, source, log);
  EXPECT_EQ(log.kept().size(), DiagnosticLog::kKept);
  EXPECT_EQ(log.n_errors(), 1000U);
}

}  // namespace
}  // namespace panelcal
