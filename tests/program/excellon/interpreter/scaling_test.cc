// SPDX-License-Identifier: Apache-2.0
// Reference scaling: CNC-7 manual, Reference Scaling enable, Reference Scaling disable; the
// semantics page says about which point, and what is not scaled.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FunctionSource;
using test::Hole;
using test::IsNearMatrix;
using test::metric;
using test::ProgramRun;
using test::run_program;
using test::says;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr double kRounding_mm = 1e-9;

/// 1.001 and 0.999 about (10, 20).
WalkOptions scaling() {
  WalkOptions options;
  options.scaling = ReferenceScaling{.x = 1.001,
                                     .y = 0.999,
                                     .about = position_mm<frame::Nominal>(10, 20),
                                     .starts_enabled = false};
  return options;
}

Vector2d scaled(const Vector2d& p_mm) {
  return {10 + 1.001 * (p_mm.x() - 10), 20 + 0.999 * (p_mm.y() - 20)};
}

/// `body` behind T1 in line 6.
ProgramRun run_clean(const std::string& body, const WalkOptions& options) {
  ProgramRun run = run_program(metric("T1\n" + body + "M30\n"), options);
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  return run;
}

/// For each hole: true at its scaled place, false at its nominal one.
std::vector<bool> are_scaled(const ProgramRun& run) {
  std::vector<bool> out;
  for (const Hole& hole : run.holes()) {
    const bool is_scaled = (hole.corrected_mm() - scaled(hole.nominal_mm())).norm() < kRounding_mm;
    if (!is_scaled) {
      EXPECT_EQ(hole.corrected_mm(), hole.nominal_mm());
    }
    out.push_back(is_scaled);
  }
  return out;
}

TEST(ReferenceScaling, IsAboutAPointAndLeavesTheNominalPlace) {
  const ProgramRun run = run_clean("M60\nX110.Y120.\n", scaling());
  ASSERT_EQ(run.holes().size(), 1U);
  EXPECT_EQ(run.holes()[0].nominal_mm(), Vector2d(110, 120));
  EXPECT_THAT(run.holes()[0].corrected_mm(), IsNearMatrix(Vector2d(110.1, 119.9), kRounding_mm));
  EXPECT_THAT(run.holes()[0].actual_mm(), IsNearMatrix(Vector2d(110.1, 119.9), kRounding_mm));
}

TEST(ReferenceScaling, HoldsFromM60ToM61) {
  EXPECT_EQ(are_scaled(run_clean("X50.Y50.\nM60\nX60.Y60.\nX70.Y70.\nM61\nX80.Y80.\n", scaling())),
            (std::vector<bool>{false, true, true, false}));
}

TEST(ReferenceScaling, MayBeOnBeforeTheProgramStarts) {
  WalkOptions options = scaling();
  options.scaling->starts_enabled = true;
  EXPECT_EQ(are_scaled(run_clean("X50.Y50.\nM61\nX60.Y60.\nM60\nX70.Y70.\n", options)),
            (std::vector<bool>{true, false, true}));
}

TEST(ReferenceScaling, ScalesRepeatedHoles) {
  EXPECT_EQ(are_scaled(run_clean("M60\nX50.Y50.\nR2X10.\n", scaling())),
            (std::vector<bool>{true, true, true}));
}

TEST(ReferenceScaling, DoesNotScaleRouts) {
  const ProgramRun run =
      run_clean("M60\nG00X50.Y50.\nM15\nG01X60.Y50.\nG02X80.Y70.A20.\nM17\n", scaling());
  EXPECT_THAT(run.executed.lines(),
              AllOf(Contains("8 position (50, 50)"),
                    Contains("10 rout 1 line (60, 50)"),
                    Contains("11 rout 1 cw (80, 70) about (80, 50)")));
}

TEST(ReferenceScaling, DoesNotScaleStops) {
  EXPECT_THAT(run_clean("M60\nM09X50.Y50.\n", scaling()).executed.lines(),
              Contains("8 inspection (50, 50)"));
}

TEST(ReferenceScaling, DoesNotScaleTargetsNorTheHolesDrilledAtThem) {
  FunctionSource panel = test::shifted_by(0.1, 0.2);
  const ProgramRun run =
      run_program(metric("G34,1\nT1\nM60\nG38X110.Y120.\nG35X60.Y70.\nM30\n"), scaling(), panel);
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  ASSERT_EQ(panel.requests().size(), 2U);
  for (const MeasurementRequest& request : panel.requests()) {
    EXPECT_EQ(request.expected.in_mm(), request.nominal.in_mm());
  }
  EXPECT_EQ(panel.requests()[0].nominal.in_mm(), Vector2d(110, 120));
  ASSERT_EQ(run.holes().size(), 1U);
  EXPECT_THAT(run.holes()[0].corrected_mm(), IsNearMatrix(Vector2d(110.1, 120.2), kRounding_mm));
}

TEST(ReferenceScaling, ActsBeforeTheBaseCorrection) {
  WalkOptions options = scaling();
  options.series_size = 2;
  options.model = PanelModel::Similarity;
  FunctionSource panel(
      [](const MeasurementRequest& request) -> Vector2d { return 1.01 * request.nominal.in_mm(); });
  const ProgramRun run = run_program(
      metric("G34,1\nT1\nM60\nG36X0.Y0.\nG36X100.Y0.\nX110.Y120.\nM30\n"), options, panel);
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  ASSERT_EQ(run.holes().size(), 1U);
  EXPECT_EQ(run.holes()[0].nominal_mm(), Vector2d(110, 120));
  EXPECT_THAT(run.holes()[0].corrected_mm(),
              IsNearMatrix(Vector2d(1.01 * 110.1, 1.01 * 119.9), kRounding_mm));
}

TEST(ReferenceScaling, ActsBehindThePlacementOfACopy) {
  const ProgramRun run = run_clean("M60\nM25\nX20.Y30.\nM01\nM02X200.M80\nM08\n", scaling());
  ASSERT_EQ(run.holes().size(), 2U);
  EXPECT_EQ(run.holes()[1].nominal_mm(), Vector2d(180, 30));
  EXPECT_THAT(run.holes()[1].corrected_mm(), IsNearMatrix(scaled({180, 30}), kRounding_mm));
}

TEST(ReferenceScaling, ItsStateCarriesOnIntoCopies) {
  EXPECT_EQ(are_scaled(run_clean("M25\nX50.Y50.\nM60\nX60.Y60.\nM01\nM02X100.\nM08\nX80.Y80.\n",
                                 scaling())),
            (std::vector<bool>{false, true, true, true, true}));
}

TEST(ReferenceScaling, WithoutItsPageIsPassedOnWithAWarning) {
  const ProgramRun run = run_clean("X50.Y50.\nM60\nX60.Y60.\nM61\nX70.Y70.\n", {});
  EXPECT_THAT(run.diagnostics, Contains(says(8, "warning[scaling-unknown]")));
  EXPECT_THAT(
      run.executed.lines(),
      AllOf(Contains("8 function scaling_on M60"), Contains("10 function scaling_off M61")));
  for (const Hole& hole : run.holes()) EXPECT_EQ(hole.corrected_mm(), hole.nominal_mm());
}

TEST(ReferenceScaling, WithItsPageIsNotWarnedOf) {
  EXPECT_THAT(run_clean("M60\nX60.Y60.\nM61\n", scaling()).diagnostics,
              Each(Not(HasSubstr("scaling-unknown"))));
}

}  // namespace
}  // namespace panelcal
