// SPDX-License-Identifier: Apache-2.0
#include "machine/job/summary/worst_hole.h"

#include <gtest/gtest.h>

namespace panelcal {
namespace {

/// A hole in a line, with another sigma in x and in y, in um.
void put(OperationSink& sink, const Origin& origin, int line, double x_um, double y_um) {
  Drill drill;
  drill.tool = 2;
  drill.nominal = position_mm<frame::Nominal>(line, 0);
  drill.cov_mm2 = 1e-6 * Eigen::Vector2d(x_um * x_um, y_um * y_um).asDiagonal().toDenseMatrix();
  sink.put({line, {}, drill, {}, &origin});
}

TEST(WorstHole, IsTheLeastCertainInItsWorstDirection) {
  const Origin origin;
  WorstHole worst;
  put(worst, origin, 7, 4, 4);
  put(worst, origin, 8, 1, 5);
  put(worst, origin, 9, 4.5, 4.5);
  const auto hole = worst.budget(Survey(), MachineUncertainty());
  ASSERT_TRUE(hole);
  EXPECT_EQ(hole->line, 8);
  EXPECT_EQ(hole->tool, 2);
  EXPECT_EQ(hole->nominal, position_mm<frame::Nominal>(8, 0));
  EXPECT_FALSE(hole->is_likeliest_to_break);
  EXPECT_FALSE(hole->risk);
}

TEST(WorstHole, OfEqualOnesIsTheFirst) {
  const Origin origin;
  WorstHole worst;
  put(worst, origin, 7, 3, 3);
  put(worst, origin, 8, 5, 2);
  put(worst, origin, 9, 2, 5);
  const auto hole = worst.budget(Survey(), MachineUncertainty());
  ASSERT_TRUE(hole);
  EXPECT_EQ(hole->line, 8);
}

TEST(WorstHole, IsMissingWhereNothingWasCorrected) {
  const Origin origin;
  WorstHole worst;
  put(worst, origin, 7, 0, 0);
  EXPECT_FALSE(worst.budget(Survey(), MachineUncertainty()));
}

/// The verdict on two holes of tool 4, the second of them the likelier to break its tolerance.
struct Judged {
  Judged() {
    for (const auto& [line, risk] : {std::pair(11, 2e-8), std::pair(12, 3e-5)}) {
      Drill drill;
      drill.tool = 4;
      drill.nominal = position_mm<frame::Nominal>(line, 0);
      drill.cov_mm2 = 16e-6 * Eigen::Matrix2d::Identity();
      drill.risk = drill.judged_risk = risk;
      verdict.put({line, {}, drill, {}, &origin});
    }
  }

  static Tolerances of_24_um() {
    Tolerances tolerances;
    tolerances.position = um(24);
    return tolerances;
  }

  Origin origin;
  JobVerdict verdict{of_24_um()};
};

TEST(LikeliestToBreak, IsThePlaceThatTheVerdictNames) {
  const Judged judged;
  const auto hole = likeliest_to_break(judged.verdict, Survey(), MachineUncertainty());
  ASSERT_TRUE(hole);
  EXPECT_EQ(hole->line, 12);
  EXPECT_EQ(hole->tool, 4);
  EXPECT_TRUE(hole->is_likeliest_to_break);
  EXPECT_EQ(hole->risk, 3e-5);
}

TEST(LikeliestToBreak, HasARiskOnlyWhereOneCanBeStated) {
  Judged judged;
  judged.verdict.set_basis({RiskBasis::Kind::Unknown, "no risk figure", true});
  EXPECT_FALSE(likeliest_to_break(judged.verdict, Survey(), MachineUncertainty())->risk);
  judged.verdict.set_basis({RiskBasis::Kind::Bounded, "no risk below 0.001 can be stated", true});
  EXPECT_FALSE(likeliest_to_break(judged.verdict, Survey(), MachineUncertainty())->risk);
}

TEST(LikeliestToBreak, IsMissingWhereNothingWasJudged) {
  const JobVerdict verdict(Judged::of_24_um());
  EXPECT_FALSE(likeliest_to_break(verdict, Survey(), MachineUncertainty()));
}

}  // namespace
}  // namespace panelcal
