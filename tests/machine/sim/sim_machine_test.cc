// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_machine.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "program/text/source_text.h"
#include <gtest/gtest.h>

#include "tests/machine/small_panel.h"
#include "tests/machine/virtual_machine.h"
#include "tests/support/folders.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::IsNearPosition;

/// Ten sigmas of a located fiducial of the small panel.
constexpr Length kLocated = um(1);

class SimMachineTest : public ::testing::Test {
 protected:
  MachineConfig config(std::string_view sim = "", std::string_view vision = "") const {
    return test::small_config(folder_.path(), sim, vision);
  }
  SimMachine machine(const MachineConfig& config, PictureObserver observer = {}) const {
    auto made = SimMachine::create(config, program_, std::move(observer));
    EXPECT_TRUE(made) << made.error().text();
    return std::move(made).value();
  }
  /// Looks for every target where the drawing has it.
  std::vector<MeasurementRequest> requests(const MachineConfig& config) const {
    NominalSource nominal;
    DiagnosticLog log;
    std::vector<MeasurementRequest> out;
    for (const auto& m : survey(program_, config.walk, nominal, log).measurements) {
      out.push_back(m.request);
    }
    EXPECT_EQ(out.size(), 7u);
    return out;
  }

  test::TemporaryFolder folder_;
  Program program_ = test::program_of(std::string(test::kSmallProgram));
};

TEST_F(SimMachineTest, FindsEveryTargetWhereItReallyIs) {
  const MachineConfig config = this->config("neighbors = 5\nlight_gradient = 0.1\n");
  SimMachine machine = this->machine(config);
  for (const MeasurementRequest& request : requests(config)) {
    const auto measurement = machine.measure(request);
    ASSERT_TRUE(measurement) << measurement.error().text();
    ASSERT_EQ(measurement->status, MeasurementStatus::Found) << measurement->reason;
    const Truth::Target& truth = machine.truth().targets[static_cast<std::size_t>(request.seq)];
    EXPECT_EQ(truth.nominal, request.nominal);
    EXPECT_THAT(measurement->measured.position, IsNearPosition(truth.actual, kLocated));
    EXPECT_GT(measurement->score, 0.9);
    EXPECT_TRUE(measurement->image.empty());
  }
}

TEST_F(SimMachineTest, OrderOfRequestsDoesNotMatter) {
  const MachineConfig config = this->config("neighbors = 3\n");
  SimMachine forward = machine(config);
  SimMachine backward = machine(config);
  std::vector<MeasurementRequest> all = requests(config);
  std::vector<std::string> there;
  for (const auto& request : all) there.push_back(to_json(*forward.measure(request)));
  std::ranges::reverse(all);
  std::vector<std::string> back;
  for (const auto& request : all) back.push_back(to_json(*backward.measure(request)));
  std::ranges::reverse(back);
  EXPECT_EQ(there, back);
}

TEST_F(SimMachineTest, SeedNamesThePanel) {
  MachineConfig config = this->config();
  const MeasurementRequest request = requests(config).back();
  const std::string first = to_json(*machine(config).measure(request));
  EXPECT_EQ(to_json(*machine(config).measure(request)), first);
  config.sim->seed = 6;
  EXPECT_NE(to_json(*machine(config).measure(request)), first);
}

TEST_F(SimMachineTest, WrongSpindleCameraOffsetShiftsEveryMeasurement) {
  const MachineConfig config = this->config("spindle_camera_offset_mm = [45.02, -3.01]\n");
  SimMachine machine = this->machine(config);
  // The camera looks 20 um further right than believed: everything seems 20 um further left.
  const auto error = displacement_mm<frame::Actual>(-0.02, 0.01);
  for (const MeasurementRequest& request : requests(config)) {
    const auto measurement = machine.measure(request);
    ASSERT_TRUE(measurement) << measurement.error().text();
    const Truth::Target& truth = machine.truth().targets[static_cast<std::size_t>(request.seq)];
    EXPECT_THAT(measurement->measured.position, IsNearPosition(truth.actual + error, kLocated));
  }
}

TEST_F(SimMachineTest, TargetThatTheProgramHasDrilledIsTheHole) {
  const MachineConfig config = this->config();
  SimMachine machine = this->machine(config);
  const std::vector<MeasurementRequest> all = requests(config);
  const auto seen = [&](const MeasurementRequest& request) {
    const auto measurement = machine.measure(request);
    EXPECT_TRUE(measurement) << measurement.error().text();
    EXPECT_EQ(measurement->status, MeasurementStatus::Found) << measurement->reason;
    return measurement->measured.position;
  };
  const auto drill_at = [&](const MeasurementRequest& request, double dx_mm, double dy_mm) {
    const Position<frame::Actual> place =
        position_mm<frame::Actual>(request.nominal.in_mm() + Eigen::Vector2d(dx_mm, dy_mm));
    // A copy has more digits than a target's coordinate.
    const auto nominal = request.nominal + displacement_mm<frame::Nominal>(0.003, -0.004);
    machine.drill({nominal, place, request.work_zero});
    return place;
  };
  // A mark of the panel, until the program drills there.
  const Position<frame::Actual> mark = machine.truth().targets[0].actual;
  EXPECT_THAT(seen(all[0]), IsNearPosition(mark, kLocated));
  const Position<frame::Actual> hole = drill_at(all[0], 0.02, -0.01);
  EXPECT_THAT(seen(all[0]), IsNearPosition(hole, kLocated));
  EXPECT_THAT(machine.truth().targets[0].actual, IsNearPosition(mark, um(0)));  // as it was seen
  // The drill follows the hole that is there.
  drill_at(all[0], -0.1, 0.1);
  EXPECT_THAT(seen(all[0]), IsNearPosition(hole, kLocated));

  const Position<frame::Actual> next = drill_at(all[1], 0, 0.05);
  EXPECT_THAT(machine.truth().targets[1].actual, IsNearPosition(next, um(1e-6)));
  EXPECT_THAT(seen(all[1]), IsNearPosition(next, kLocated));
  // Of the others none has moved.
  EXPECT_THAT(seen(all[2]), IsNearPosition(machine.truth().targets[2].actual, kLocated));
  EXPECT_GT((seen(all[2]).in_mm() - all[2].nominal.in_mm()).norm(), 0.2);
}

TEST_F(SimMachineTest, ColdOffsetGoesWithTheTimeThatThePicturesTake) {
  MachineConfig config = this->config("[sim.coupon]\ncold_um = [40, -20]\nwarm_up_s = 10\n");
  config.settle = seconds(5);
  SimMachine machine = this->machine(config);
  const MeasurementRequest request = requests(config).front();
  // The camera looks 40 um farther right than believed when the machine is started, and everything
  // seems so much farther left.
  for (const double time_s : {5.0, 10.0, 15.0}) {
    const auto measurement = machine.measure(request);
    ASSERT_TRUE(measurement) << measurement.error().text();
    const double left = std::exp(-time_s / 10);
    EXPECT_THAT(measurement->measured.position,
                IsNearPosition(machine.truth().targets.front().actual +
                                   displacement_mm<frame::Actual>(-0.04 * left, 0.02 * left),
                               kLocated));
  }
}

TEST_F(SimMachineTest, WrongCameraScaleShowsAwayFromTheAxis) {
  const MachineConfig config = this->config("[sim.camera]\nscale_mm_per_px = 0.0101\n");
  SimMachine machine = this->machine(config);
  const MeasurementRequest request = requests(config).front();
  const auto measurement = machine.measure(request);
  ASSERT_TRUE(measurement) << measurement.error().text();
  ASSERT_EQ(measurement->status, MeasurementStatus::Found) << measurement->reason;
  const Displacement<frame::Actual> from_axis =
      machine.truth().targets.front().actual - request.expected;
  EXPECT_THAT(measurement->measured.position,
              IsNearPosition(request.expected + (1 / 1.01) * from_axis, kLocated));
}

TEST_F(SimMachineTest, TruthSaysWhereRingsHaveTheirHoles) {
  const MachineConfig config = this->config("ring_offset_sigma_um = 30\n");
  const CameraMapping mapping = config.camera->mapping();
  Displacement<frame::Actual> seen;
  SimMachine machine = this->machine(config, [&](const SeenView& view) {
    ASSERT_EQ(view.detection.status, DetectionStatus::Found) << view.detection.reason;
    const TargetFit& fit = *view.detection.best;
    const Eigen::Vector2d seen_mm = mapping.jacobian(fit.center.position) * fit.hole_offset_px;
    seen = displacement_mm<frame::Actual>(seen_mm);
  });
  int n_rings = 0;
  for (const MeasurementRequest& request : requests(config)) {
    const Truth::Target& truth = machine.truth().targets[static_cast<std::size_t>(request.seq)];
    const int tool = request.settings.tools.front();
    const bool is_ring = config.vision_tools.at(tool).shape == Shape::Ring;
    EXPECT_EQ(truth.hole_offset.has_value(), is_ring);
    if (!is_ring) continue;
    ++n_rings;
    ASSERT_TRUE(machine.measure(request));
    EXPECT_LT((seen - *truth.hole_offset).in_mm().norm(), kLocated.in_mm());
    EXPECT_GT(truth.hole_offset->in_mm().norm(), 2 * kLocated.in_mm());
  }
  EXPECT_EQ(n_rings, 4);
}

TEST_F(SimMachineTest, WorkZeroIsTakenOut) {
  MachineConfig config = this->config();
  const Measurement here = *machine(config).measure(requests(config).back());
  config.walk.work_zero = position_mm<frame::Machine>(-300, 20);
  const Measurement there = *machine(config).measure(requests(config).back());
  EXPECT_THAT(there.measured.position, IsNearPosition(here.measured.position, kLocated));
}

TEST_F(SimMachineTest, InspectionsAreAveraged) {
  const MachineConfig config = this->config();
  std::vector<Eigen::Matrix2d> covs;
  SimMachine machine = this->machine(config, [&](const SeenView& seen) {
    EXPECT_EQ(seen.picture.image.width(), 280);
    ASSERT_EQ(seen.detection.status, DetectionStatus::Found);
    covs.push_back(seen.detection.best->center_optical->cov);
  });
  MeasurementRequest request = requests(config).front();
  const Measurement one = *machine.measure(request);
  ASSERT_EQ(covs.size(), 1u);
  const double besides = one.measured.cov.trace() - covs[0].trace();  // the camera's own error
  request.settings.inspections = 4;
  const Measurement four = *machine.measure(request);
  ASSERT_EQ(covs.size(), 5u);
  // Of the mean picture, with half the noise. Each picture says for itself what its rim may hide.
  constexpr double kOwnShape = 0.3;
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (std::size_t i = 1; i < 5; ++i) sum += covs[i];
  EXPECT_NEAR((four.measured.cov.trace() - besides) / (sum.trace() / 16), 1, kOwnShape);
  EXPECT_THAT(four.measured.position,
              IsNearPosition(machine.truth().targets.front().actual, kLocated));
}

TEST_F(SimMachineTest, TargetOutsideOfTheSearchedAreaIsAnAnswer) {
  const MachineConfig config = this->config("", "min_score = 0.5\n");
  SimMachine machine = this->machine(config);
  MeasurementRequest request = requests(config).front();
  request.expected = position_mm<frame::Actual>(20, 20);
  const auto measurement = machine.measure(request);
  ASSERT_TRUE(measurement) << measurement.error().text();
  EXPECT_EQ(measurement->status, MeasurementStatus::NotFound);
  EXPECT_FALSE(measurement->reason.empty());
}

TEST_F(SimMachineTest, RefusesWhatCannotBeSimulated) {
  MachineConfig config = this->config();
  EXPECT_THAT(SimMachine::create(config, test::program_of(test::small_program_with("G34,9"))),
              FailsWith(Code::VisionToolUndefined, "G36 target 0 (line 10)"));
  EXPECT_THAT(
      SimMachine::create(config, test::program_of(test::small_program_with("$uvis,zoom,2"))),
      FailsWith(Code::ConfigValue, "G36 target 0 (line 10)"));
  EXPECT_THAT(SimMachine::create(config, test::program_of(test::small_program_with("G99"))),
              FailsWith(Code::CommandUnknown, "test.exc:9:1"));
  config.vision_tools.at(1).size = mm(2.4);
  EXPECT_THAT(SimMachine::create(config, program_), FailsWith(Code::ConfigValue, "2.400 mm"));
  config.sim.reset();
  EXPECT_THAT(SimMachine::create(config, program_), FailsWith(Code::ConfigValue, "[sim]"));
}

TEST_F(SimMachineTest, RefusesToInspectForEver) {
  const MachineConfig config = this->config();
  SimMachine machine = this->machine(config);
  MeasurementRequest request = requests(config).front();
  request.settings.inspections = 1'000'000'000;
  EXPECT_THAT(machine.measure(request), FailsWith(Code::NotSupported, "1000000000 inspections"));
}

/// The demo promises: every hole of a shaken panel within 2 um, though the panel is 275 mm long and
/// nothing but pictures of fiducials was known of it.
TEST(SimMachine, DemoPanelIsDrilledWithinTwoMicrometers) {
  constexpr double kMaxHoleError_um = 2;
  const test::TemporaryFolder folder;
  const auto config = test::config_with_camera(folder.path(), test::test_camera(400, 360), R"(
[vision]
rotate = 3
search_radius_mm = 1.2
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 2.0
[[vision.tool]]
number = 2
shape = "disc"
size_mm = 1.0
[camera]
calibration = "camera.cal.json"
[gates]
residual_um = 10
rotation_mrad = 5
stretch_ppm = 500
offset_mm = 1.5
[program]
work_zero_mm = [50, 30]
[sim]
panel_offset_mm = [0.4, 0.0]
panel_rotation_mrad = 2
stretch_ppm = [200, 200]
board_offset_sigma_um = 30
board_rotation_sigma_mrad = 0.1
noise = 3
)");
  ASSERT_TRUE(config) << config.error().text();
  auto source = read_source(test::source_folder() / "datasets/demo/panel.exc");
  ASSERT_TRUE(source) << source.error().text();
  const auto program = test::program_of(source->bytes);
  auto machine = SimMachine::create(*config, program);
  ASSERT_TRUE(machine) << machine.error().text();

  DiagnosticLog log;
  const Survey survey = panelcal::survey(program, config->walk, *machine, log);
  ASSERT_FALSE(log.has_errors()) << test::all_text(log);
  EXPECT_TRUE(survey.is_accepted());
  EXPECT_EQ(survey.measurements.size(), 21u);

  test::HoleSink sink;
  execute(program, config->walk, survey, sink, log);
  ASSERT_FALSE(log.has_errors()) << test::all_text(log);
  ASSERT_EQ(sink.holes().size(), 990u);
  double worst_um = 0;
  for (const test::Hole& hole : sink.holes()) {
    const auto actual = machine->truth().actual_from_nominal(hole.path)(hole.drill.nominal);
    worst_um = std::max(worst_um, (hole.drill.corrected - actual).in_mm().norm() * 1e3);
  }
  RecordProperty("worst_hole_um", std::to_string(worst_um));
  EXPECT_LT(worst_um, kMaxHoleError_um);
}

}  // namespace
}  // namespace panelcal
