// SPDX-License-Identifier: Apache-2.0
// Commands to a machine whose table errs ([table]).
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "calib/base/files/byte_sink.h"
#include "calib/correction/error_budget.h"
#include "program/writers/excellon/writer.h"
#include "program/writers/sieb_meyer/writer.h"
#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include "tests/calib/table/table_of.h"
#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::metric;
using test::ProgramRun;
using test::run_program;
using testing::ElementsAre;
using testing::HasSubstr;

const Vector2d kWorkZero_mm(100, 50);
/// Of what iterations and samples leave.
constexpr double kRounding_mm = 1e-7;

/// 200 ppm in x and a bow of `bow_mm` over 300 mm of the x axis.
std::shared_ptr<const TableCorrection> table(double bow_mm, Length hold = {}) {
  const TableGrid grid{Vector2d(0, 0), Vector2d(500, 400), 10, 8};
  const auto error_mm = [bow_mm](const Vector2d& c_mm) {
    const double part = (c_mm.x() - 250) / 150;
    return Vector2d(2e-4 * c_mm.x(), bow_mm * part * part);
  };
  return std::make_shared<const TableCorrection>(test::table_of(grid, error_mm), hold);
}

WalkOptions on_table(double bow_mm, Length hold = {}) {
  WalkOptions options;
  options.work_zero = position_mm<frame::Machine>(kWorkZero_mm);
  options.table = table(bow_mm, hold);
  options.uncertainty.table_map = um(0.8);
  options.slots = Cycles::Expanded;
  return options;
}

/// Place of a stage with this error.
Vector2d stands_mm(const WalkOptions& options, const Position<frame::Machine>& told) {
  return options.table->nearest_place_of(told).in_mm();
}

TEST(WalkTable, TellsTheCommandThatLeadsToTheHole) {
  const WalkOptions options = on_table(0.03);
  const ProgramRun run = run_program(metric("T1\nX10.Y20.\nX300.Y200.\nM30\n"), options);
  ASSERT_TRUE(run.diagnostics.empty()) << run.diagnostics.front();
  ASSERT_EQ(run.holes().size(), 2u);
  for (const test::Hole& hole : run.holes()) {
    EXPECT_EQ(hole.corrected_mm(), hole.nominal_mm());
    const Vector2d right_mm = kWorkZero_mm + hole.corrected_mm();
    EXPECT_LT((stands_mm(options, hole.drill.actual) - right_mm).norm(), kRounding_mm);
    EXPECT_GT((hole.actual_mm() - right_mm).norm(), 0.02);
    EXPECT_EQ(hole.drill.actual, options.work_zero + hole.drill.commanded);
  }
}

/// As far as what drives as told is beside the line or circle of the program, by dense samples.
double worst_beside_mm(const WalkOptions& options,
                       const std::vector<Rout>& routs,
                       const Vector2d& begin_mm,
                       const std::function<double(const Vector2d&)>& beside_mm) {
  double worst_mm = 0;
  Vector2d from_mm =
      options.table
          ->nearest_command_for(position_mm<frame::Machine>((kWorkZero_mm + begin_mm).eval()))
          .in_mm();
  for (const Rout& rout : routs) {
    const Vector2d to_mm = rout.actual.in_mm();
    for (int i = 0; i <= 200; ++i) {
      Vector2d commanded_mm = from_mm + i / 200.0 * (to_mm - from_mm);
      if (rout.kind != RoutKind::Line) {
        const Vector2d center_mm = rout.center.in_mm();
        const Vector2d a = from_mm - center_mm;
        const Vector2d b = to_mm - center_mm;
        const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
        EXPECT_EQ(turn < 0, rout.kind == RoutKind::Clockwise);
        commanded_mm = center_mm + Eigen::Rotation2Dd(i / 200.0 * turn) * a;
      }
      const Vector2d at_mm = stands_mm(options, position_mm<frame::Machine>(commanded_mm));
      worst_mm = std::max(worst_mm, beside_mm(at_mm - kWorkZero_mm));
    }
    from_mm = to_mm;
  }
  return worst_mm;
}

TEST(WalkTable, CutsALineUntilItIsStraightOnTheTable) {
  const WalkOptions options = on_table(0.03);
  const ProgramRun run =
      run_program(metric("T1\nG00X10.Y20.\nM15\nG01X310.Y120.\nM17\nM30\n"), options);
  ASSERT_TRUE(run.diagnostics.empty()) << run.diagnostics.front();
  const auto& routs = run.executed.routs();
  EXPECT_GT(routs.size(), 2u);
  EXPECT_LT(routs.size(), 12u);
  const Vector2d along = Vector2d(300, 100).normalized();
  const double worst_mm =
      worst_beside_mm(options, routs, Vector2d(10, 20), [&](const Vector2d& p_mm) {
        const Vector2d from_start = p_mm - Vector2d(10, 20);
        return std::abs(along.x() * from_start.y() - along.y() * from_start.x());
      });
  EXPECT_LT(worst_mm, options.arc_tolerance.in_mm() * 1.01);
  EXPECT_GT(worst_mm, 0.1 * options.arc_tolerance.in_mm());
}

TEST(WalkTable, LeavesALineWholeWhereTheErrorIsLinear) {
  const ProgramRun run =
      run_program(metric("T1\nG00X10.Y20.\nM15\nG01X310.Y120.\nM17\nM30\n"), on_table(0));
  ASSERT_TRUE(run.diagnostics.empty()) << run.diagnostics.front();
  ASSERT_EQ(run.executed.routs().size(), 1u);
  EXPECT_EQ(run.executed.routs()[0].kind, RoutKind::Line);
}

TEST(WalkTable, CutsAnArcUntilItIsRoundOnTheTable) {
  const WalkOptions options = on_table(0.03);
  const ProgramRun run =
      run_program(metric("T1\nG00X50.Y100.\nM15\nG02X250.Y100.A100.\nM17\nM30\n"), options);
  ASSERT_TRUE(run.diagnostics.empty()) << run.diagnostics.front();
  const auto& routs = run.executed.routs();
  ASSERT_GT(routs.size(), 1u);
  const double worst_mm =
      worst_beside_mm(options, routs, Vector2d(50, 100), [](const Vector2d& p_mm) {
        return std::abs((p_mm - Vector2d(150, 100)).norm() - 100);
      });
  EXPECT_LT(worst_mm, options.arc_tolerance.in_mm() * 1.01);
  // For pictures of the job the centre is where it is on the table, as near as they need it.
  EXPECT_LT((routs[0].corrected_center.in_mm() - Vector2d(150, 100)).norm(), 0.1);
}

TEST(WalkTable, RefusesAPlaceThatTheMapDoesNotReach) {
  const std::string program = metric("T1\nX10.Y20.\nX401.Y20.\nX402.Y20.\nM30\n");
  const ProgramRun run = run_program(program, on_table(0.03));
  EXPECT_TRUE(run.has_errors);
  EXPECT_THAT(run.texts, ElementsAre(test::says(8, "(501.000, 70.000) mm")));
  EXPECT_THAT(run.diagnostics[0], HasSubstr("travel-exceeded"));
  const ProgramRun held = run_program(program, on_table(0.03, mm(5)));
  EXPECT_FALSE(held.has_errors);
}

TEST(WalkTable, RefusesAnArcThatLeavesTheMapBetweenItsEnds) {
  const ProgramRun run =
      run_program(metric("T1\nG00X390.Y20.\nM15\nG03X390.Y120.A50.\nM17\nM30\n"), on_table(0.03));
  EXPECT_TRUE(run.has_errors);
  EXPECT_THAT(run.diagnostics, ElementsAre(test::says(9, "error[travel-exceeded]")));
}

TEST(WalkTable, ParksBeyondTheMapByTheErrorOfItsEdge) {
  const ProgramRun run = run_program(metric("T1\nX10.Y20.\nM30X600.Y70.\n"), on_table(0));
  ASSERT_TRUE(run.diagnostics.empty()) << run.diagnostics.front();
  // 0.1 mm at the edge at 500 mm.
  EXPECT_THAT(run.executed.lines().back(), HasSubstr("(599.9"));
}

/// Lines of a writer's program that are its body's coordinates.
template <class Writer>
std::string table_written(const std::string& program, const WalkOptions& options) {
  DiagnosticLog log;
  const Program read = load_program({"p.exc", program}, log);
  NominalSource nominal;
  const Survey found = survey(read, options, nominal, log);
  StringSink bytes;
  Writer writer(bytes, ProgramWriterOptions{.allow_losses = true, .work_zero = options.work_zero});
  execute(read, options, found, writer, log);
  EXPECT_FALSE(log.has_errors());
  EXPECT_TRUE(writer.finish());
  return bytes.text();
}

TEST(WalkTable, ProgramsForTheMachineSayTheCommand) {
  // Sent to 400 / 1.0002 the stage stands at 400.
  const std::string program = metric("T1\nX300.Y200.\nM30\n");
  EXPECT_THAT(table_written<ExcellonWriter>(program, on_table(0)), HasSubstr("X299.92Y200.0"));
  EXPECT_THAT(table_written<SiebMeyerWriter>(program, on_table(0)), HasSubstr("X299.92Y200."));
}

TEST(WalkTable, CountsTheMapAtTargetsAndAtHoles) {
  WalkOptions options = on_table(0.03);
  options.series_size = 2;
  test::FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() + Vector2d(0.1, -0.2);
  });
  const ProgramRun run =
      run_program(metric("G34,1\nG36X0.Y0.\nG36X200.Y0.\nT1\nX100.Y0.\nM30\n"), options, source);
  ASSERT_TRUE(run.diagnostics.empty()) << run.diagnostics.front();
  // Measured is where the target is on the table: only the command has the map in it.
  EXPECT_LT((run.holes().at(0).corrected_mm() - Vector2d(100.1, -0.2)).norm(), 1e-9);
  WalkOptions without = options;
  without.uncertainty.table_map = {};
  const ProgramRun exact =
      run_program(metric("G34,1\nG36X0.Y0.\nG36X200.Y0.\nT1\nX100.Y0.\nM30\n"), without, source);
  // Between two targets half the variance of one, and all of the hole's own.
  const Eigen::Matrix2d more_mm2 = run.holes()[0].drill.cov_mm2 - exact.holes().at(0).drill.cov_mm2;
  EXPECT_NEAR(more_mm2(0, 0), 1.5 * 0.64e-6, 1e-12);
  EXPECT_NEAR(more_mm2(1, 1), 1.5 * 0.64e-6, 1e-12);
}

}  // namespace
}  // namespace panelcal
