// SPDX-License-Identifier: Apache-2.0
// What a panel is told of holes that are drilled between measurements.
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/program/sieb_meyer/manual_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::format_5000;
using test::metric;
using testing::ElementsAre;

using Lines = std::vector<std::string>;

/// Sees every target (0.5, 0.25) mm from its nominal place, and notes in their order what is
/// drilled and what is looked at.
class NotedPanel final : public MeasurementSource, public DrilledPanel {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    lines.push_back(fmt::format("{} {}", request.command, text(request.nominal.in_mm())));
    Measurement m{.request = request, .status = MeasurementStatus::Found};
    m.measured.position = position_mm<frame::Actual>(request.nominal.in_mm() + kShift_mm);
    m.measured.cov = 1e-6 * Eigen::Matrix2d::Identity();
    return m;
  }
  DrilledPanel* drilled_panel() override { return this; }
  void drill(const DrilledHole& hole) override {
    lines.push_back(
        fmt::format("drill {} at {}", text(hole.nominal.in_mm()), text(hole.place.in_mm())));
  }

  Lines lines;

 private:
  static std::string text(const Eigen::Vector2d& p_mm) {
    return fmt::format("({:g}, {:g})", p_mm.x(), p_mm.y());
  }
  static inline const Eigen::Vector2d kShift_mm{0.5, 0.25};
};

Lines lines_of(const std::string& text) {
  DiagnosticLog log;
  const Program program = load_program({"p.exc", text}, log);
  NotedPanel panel;
  survey(program, {}, panel, log);
  EXPECT_FALSE(log.has_errors()) << testing::PrintToString(test::briefs(log));
  return panel.lines;
}

TEST(DrilledPanel, IsToldOfHolesInTheOrderOfTheProgram) {
  EXPECT_THAT(lines_of(format_5000("X1.Y1.T1\nX2.Y1.\nX3.Y1.\nX2.Y1.G32\nG31\nX4.Y1.\nX5.Y1.\n"
                                   "G30\nX6.Y1.\nX1.Y1.G32\nG31\nG30\n")),
              ElementsAre("drill (1, 1) at (1, 1)",
                          "drill (2, 1) at (2, 1)",
                          "drill (3, 1) at (3, 1)",
                          "G32 (2, 1)",
                          "drill (4, 1) at (4.5, 1.25)",
                          "drill (5, 1) at (5.5, 1.25)",
                          "drill (6, 1) at (6, 1)",
                          "G32 (1, 1)"));
}

TEST(DrilledPanel, IsToldOfEveryHoleOfRowsAndCopies) {
  EXPECT_THAT(lines_of(format_5000("X1.Y1.V2T1\nX7.Y1.W3\nX1.Y1.G32\nG31\nG30\n")),
              ElementsAre("drill (1, 1) at (1, 1)",
                          "drill (4, 1) at (4, 1)",
                          "drill (7, 1) at (7, 1)",
                          "G32 (1, 1)"));
  EXPECT_THAT(lines_of(format_5000("X1.Y1.T1M31\nXYM50V2\nX30.YM50W4M30\nX21.Y1.G32\nG31\nG30\n")),
              ElementsAre("drill (1, 1) at (1, 1)",
                          "drill (11, 1) at (11, 1)",
                          "drill (21, 1) at (21, 1)",
                          "drill (31, 1) at (31, 1)",
                          "G32 (21, 1)"));
}

/// G36 under NOCAMA drills where it has seen its target, whatever the correction.
TEST(DrilledPanel, IsToldOfHolesAtTheirTargets) {
  EXPECT_THAT(
      lines_of(format_5000("X1.Y1.T1\nX2.Y2.G36\nX2.Y2.G32\nG31\nG30\n")),
      ElementsAre(
          "drill (1, 1) at (1, 1)", "G36 (2, 2)", "drill (2, 2) at (2.5, 2.25)", "G32 (2, 2)"));
}

/// "Vision runs in two passes": the control has measured everything before it drills.
TEST(DrilledPanel, IsToldOfNoHoleOfExcellon) {
  EXPECT_THAT(lines_of(metric("G34,1\nT1\nX1.0Y1.0\nG38X2.0Y2.0\nX3.0Y3.0\nG38X1.0Y1.0\nM30\n")),
              ElementsAre("G38 (2, 2)", "G38 (1, 1)"));
}

}  // namespace
}  // namespace panelcal
