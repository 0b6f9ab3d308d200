// SPDX-License-Identifier: Apache-2.0
#include "machine/job/summary/verdict_summary.h"

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Two holes with a sigma of 4 um in each axis; the panel lies as programmed.
struct Job {
  explicit Job(const Tolerances& tolerances) : verdict(tolerances) {
    for (const double off_mm : {0.010, 0.014}) {
      Drill drill;
      drill.tool = 3;
      drill.corrected = position_mm<frame::Actual>(off_mm, 0);
      drill.commanded = displacement_mm<frame::Machine>(off_mm, 0);
      drill.cov_mm2 = 16e-6 * Eigen::Matrix2d::Identity();
      drill.risk = drill.judged_risk = std::exp(-0.5 * 36);
      const Operation operation{12, {}, drill, {}, nullptr};
      verdict.put(operation);
      comparison.put(operation);
    }
  }
  Truth truth;
  JobVerdict verdict;
  TruthComparison comparison{truth};
};

Tolerances of_24_um() {
  Tolerances tolerances;
  tolerances.position = um(24);
  return tolerances;
}

TEST(VerdictSummary, HasOneRowForEachTool) {
  const Job job(of_24_um());
  const std::string text = verdict_summary(job.verdict, nullptr);
  // Rayleigh's mean 4 sqrt(pi / 2) = 5.01, deviation 4 sqrt(2 - pi / 2) = 2.62 um.
  EXPECT_THAT(text,
              HasSubstr("    T3        2      24.0     4.00     9.79     12.87   2.42      0      "
                        "0   1.5e-08\n"));
  EXPECT_THAT(text,
              HasSubstr("verdict: drill: no place is more likely than 0.0001 to break the "
                        "tolerance; 3e-08 of 2 expected to break; the worst is line 12, "
                        "risk 1.5e-08"));
  EXPECT_THAT(text, Not(HasSubstr("truth")));
}

TEST(VerdictSummary, HasWordsWhereRiskIsNotKnown) {
  Job job(of_24_um());
  job.verdict.set_basis(
      {RiskBasis::Kind::Unknown, "no risk figure: drill wander not stated", true});
  const std::string text = verdict_summary(job.verdict, nullptr);
  EXPECT_THAT(text, HasSubstr("(lengths in um, sigma of the fit only)\n"));
  EXPECT_THAT(text, HasSubstr("     4.00     9.79     12.87   none      0      0 no figure\n"));
  EXPECT_THAT(text, HasSubstr("verdict: drill: no risk figure: drill wander not stated"));
  EXPECT_THAT(text, Not(HasSubstr("e-08")));
}

TEST(VerdictSummary, SetsTheTruthBeside) {
  const Job job(of_24_um());
  // 10 and 14 um off: mean 12, deviation 2, Cpk (24 - 12) / 6.
  EXPECT_THAT(verdict_summary(job.verdict, &job.comparison),
              HasSubstr("1.5e-08 |   14.00    18.00   2.00\n"));
}

TEST(VerdictSummary, ShowsADashWhereNothingIsAsked) {
  Tolerances other;
  other.tools.push_back({.number = 1, .position = um(5)});
  const Job job(other);
  EXPECT_EQ(cpk_text(job.verdict.by_tool().at(3).predicted, std::nullopt), "-");
  EXPECT_THAT(verdict_summary(job.verdict, nullptr), HasSubstr("T3        2         -"));
}

}  // namespace
}  // namespace panelcal
