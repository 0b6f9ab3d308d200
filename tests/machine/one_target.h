// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "machine/look/vision_procedure.h"
#include "machine/sim/sim_machine.h"
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal::test {

/// Ten sigmas of a located pad of this panel, and more for four of them.
inline constexpr Length kLocated = um(1);

struct PanelSetup {
  std::string vision;            ///< behind [vision]
  std::string camera;            ///< behind [camera] calibration
  std::string sim;               ///< behind [sim]
  std::string orders = "G34,1";  ///< in front of the target
};

/// One target at (20, 15) mm on a panel that lies shifted and turned.
class OneTargetTest : public ::testing::Test {
 protected:
  void set_up(const PanelSetup& setup) {
    const auto config = test::config_with_camera(
        folder_.path(), test::test_camera(320, 280), "[vision]\nrotate = 1\n" + setup.vision + R"(
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 0.5
[[vision.tool]]
number = 2
shape = "disc"
size_mm = 0.7
[[vision.tool]]
number = 3
shape = "ring"
size_mm = 0.8
inner_mm = 0.4
polarity = "dark"
[[vision.tool]]
number = 4
shape = "disc"
size_mm = 0.9
polarity = "dark"
[camera]
calibration = "camera.cal.json"
)" + setup.camera + R"(
[spindle]
camera_offset_mm = [45.0, -3.0]
[program]
work_zero_mm = [100.0, 50.0]
[sim]
seed = 5
noise = 3
background = 0.4
target_level = 0.75
)" + setup.sim);
    ASSERT_TRUE(config) << config.error().text();
    config_ = *config;
    program_ = test::program_of("M48\nMETRIC,TZ\nFMAT,2\nVER,1\nT1C0.8\n%\nG90\n" + setup.orders +
                                "\nG35X20.0Y15.0\nT1\nX30.0Y30.0\nM30\n");
  }
  SimMachine machine() {
    auto made = SimMachine::create(config_, program_, [this](const SeenView& seen) {
      seen_.push_back({seen.view, seen.picture.axis, seen.detection.status});
      mean_level_ = 0;
      for (const float v : seen.picture.image.pixels()) mean_level_ += static_cast<double>(v);
      mean_level_ /= static_cast<double>(seen.picture.image.pixels().size());
    });
    EXPECT_TRUE(made) << made.error().text();
    return *std::move(made);
  }
  /// Runs the survey; the only measurement.
  Measurement measure(SimMachine& machine) {
    DiagnosticLog log;
    survey_ = survey(program_, config_.walk, machine, log);
    diagnostics_ = test::all_text(log);
    EXPECT_EQ(survey_.measurements.size(), 1u) << diagnostics_;
    return survey_.measurements.empty() ? Measurement() : survey_.measurements.front();
  }
  Measurement measure() {
    SimMachine machine = this->machine();
    truth_ = machine.truth().targets.front().actual;
    return measure(machine);
  }
  void expect_found(const Measurement& measurement) {
    ASSERT_EQ(measurement.status, MeasurementStatus::Found) << measurement.reason;
    EXPECT_THAT(measurement.measured.position, test::IsNearPosition(truth_, kLocated));
  }

  struct Seen {
    View view;
    Position<frame::Machine> axis;
    DetectionStatus status;
  };

  test::TemporaryFolder folder_;
  MachineConfig config_;
  Program program_;
  std::vector<Seen> seen_;
  double mean_level_ = 0;
  Survey survey_;
  std::string diagnostics_;
  Position<frame::Actual> truth_;
};

/// Pose of the panel.
inline constexpr std::string_view kShaken =
    "panel_offset_mm = [0.3, -0.2]\npanel_rotation_mrad = 4\n";

}  // namespace panelcal::test
