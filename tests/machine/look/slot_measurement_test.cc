// SPDX-License-Identifier: Apache-2.0
// Slots (SIEB & MEYER, measurement mode 5) on the simulated machine: one coordinate each.
#include <cmath>
#include <string>
#include <vector>

#include "machine/look/vision_procedure.h"
#include "machine/sim/sim_machine.h"
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

constexpr double kShift_mm[] = {0.15, -0.11};
constexpr double kTurn_rad = 2e-3;
/// Ten sigmas of an edge that is seen over the whole picture.
constexpr double kLocated_mm = 0.5e-3;

/// Slots along y for G33, whose x counts, and along x for G32.
constexpr std::string_view kProgram =
    "%%5000\nG35,1\nX20.Y15.G33\nX20.Y95.G33\nG35,2\nX60.Y15.G32\nG31\nX20.Y20.T1\nG30\n"
    "$\nT1D0.8\n$\n";

Target slot(int number, double angle_deg) {
  Target target;
  target.number = number;
  target.shape = Shape::Slot;
  target.size = mm(0.4);
  target.angle = deg(angle_deg);
  return target;
}

class SlotMeasurement : public ::testing::Test {
 protected:
  SlotMeasurement() {
    const auto config = test::config_with_camera(folder_.path(), test::test_camera(320, 280), R"(
[vision]
mode = 5
search_radius_mm = 0.6
[camera]
calibration = "camera.cal.json"
[sim]
seed = 5
noise = 3
panel_offset_mm = [0.15, -0.11]
panel_rotation_mrad = 2
background = 0.4
target_level = 0.75
)");
    EXPECT_TRUE(config) << config.error().text();
    if (!config) return;
    config_ = *config;
    config_.vision_tools = {{1, slot(1, 90)}, {2, slot(2, 0)}};
  }

  test::TemporaryFolder folder_;
  MachineConfig config_;
  Program program_ = test::program_of(std::string(kProgram));
};

/// Point at which a slot's middle line, turned with the panel, meets the expected other coordinate.
double line_at(const MeasurementRequest& request) {
  const Eigen::Vector2d& nominal_mm = request.nominal.in_mm();
  const Eigen::Vector2d middle_mm(
      std::cos(kTurn_rad) * nominal_mm.x() - std::sin(kTurn_rad) * nominal_mm.y() + kShift_mm[0],
      std::sin(kTurn_rad) * nominal_mm.x() + std::cos(kTurn_rad) * nominal_mm.y() + kShift_mm[1]);
  const Eigen::Vector2d way_mm = request.expected.in_mm() - middle_mm;
  const double slope = std::tan(kTurn_rad);
  return request.axes == ObservedAxes::X ? middle_mm.x() - slope * way_mm.y()
                                         : middle_mm.y() + slope * way_mm.x();
}

TEST_F(SlotMeasurement, GivesTheCoordinateThatCountsAndLeavesTheOther) {
  auto machine = SimMachine::create(config_, program_);
  ASSERT_TRUE(machine) << machine.error().text();
  DiagnosticLog log;
  const Survey survey = panelcal::survey(program_, config_.walk, *machine, log);
  ASSERT_FALSE(log.has_errors()) << test::all_text(log);
  ASSERT_EQ(survey.measurements.size(), 3u);
  for (const Measurement& m : survey.measurements) {
    ASSERT_EQ(m.status, MeasurementStatus::Found) << m.reason;
    const int i = m.request.axes == ObservedAxes::X ? 0 : 1;
    EXPECT_NEAR(m.measured.position.in_mm()(i), line_at(m.request), kLocated_mm);
    EXPECT_EQ(m.measured.position.in_mm()(1 - i), m.request.expected.in_mm()(1 - i));
    EXPECT_LT(std::sqrt(m.measured.cov(i, i)), kLocated_mm);
    EXPECT_GT(std::sqrt(m.measured.cov(1 - i, 1 - i)), 0.5);
    EXPECT_EQ(m.measured.cov(0, 1), 0);
  }
}

TEST_F(SlotMeasurement, IsSearchedForAcross) {
  config_.sim->panel_offset = displacement_mm<frame::Actual>(2.6, -1.9);
  auto machine = SimMachine::create(config_, program_);
  ASSERT_TRUE(machine) << machine.error().text();
  MeasurementRequest request;
  request.command = "G33";
  request.settings.tools = {1};
  request.settings.search = true;
  request.settings.search_area = mm(4);
  request.axes = ObservedAxes::X;
  request.nominal = position_mm<frame::Nominal>(20, 15);
  request.expected = position_mm<frame::Actual>(20, 15);
  const auto measurement = machine->measure(request);
  ASSERT_TRUE(measurement) << measurement.error().text();
  ASSERT_EQ(measurement->status, MeasurementStatus::Found) << measurement->reason;
  // Point at which the turned middle line meets y = 15.
  const double x_mm = 20 - kTurn_rad * 15 + 2.6 + kTurn_rad * (15 + kTurn_rad * 20 - 1.9 - 15);
  EXPECT_NEAR(measurement->measured.position.in_mm().x(), x_mm, 3 * kLocated_mm);
}

TEST_F(SlotMeasurement, AlongTheCoordinateThatCountsIsRejected) {
  config_.vision_tools = {{1, slot(1, 0)}, {2, slot(2, 90)}};
  auto machine = SimMachine::create(config_, program_);
  ASSERT_TRUE(machine) << machine.error().text();
  DiagnosticLog log;
  const Survey survey = panelcal::survey(program_, config_.walk, *machine, log);
  ASSERT_FALSE(survey.measurements.empty()) << test::all_text(log);
  EXPECT_EQ(survey.measurements[0].status, MeasurementStatus::Rejected);
  EXPECT_EQ(survey.measurements[0].reason, "slot along x: x not measurable");
}

TEST_F(SlotMeasurement, ForBothCoordinatesIsRefused) {
  config_.walk.sieb_meyer.measurement_mode = 1;
  EXPECT_THAT(SimMachine::create(config_, program_),
              FailsWith(Code::TargetInvalid, "vision tool 1"));
}

}  // namespace
}  // namespace panelcal
