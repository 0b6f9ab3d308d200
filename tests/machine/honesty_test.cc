// SPDX-License-Identifier: Apache-2.0
// Is the predicted uncertainty the real one, from the pixel to the hole? Rendered pictures, located
// targets, two levels of fits; errors against truth, normalised by the predicted covariance.

#include <algorithm>
#include <cmath>
#include <string>

#include "machine/sim/sim_machine.h"
#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

constexpr int kJobs = 200;
/// Greatest difference of the mean normalised squared error per degree of freedom from 1. For the
/// holes, whose errors within a seed are one draw of some twelve numbers, chance alone makes 0.03.
constexpr double kTolerance = 0.1;

/// Three panel fiducials, then two boards of three, each with ten holes.
constexpr std::string_view kProgram = R"(M48
METRIC,TZ
FMAT,2
VER,1
T1C0.8
%
G90
G34,1
G36X5.0Y5.0
G36X115.0Y5.0
G36X5.0Y75.0
G34,2
M50,1
M25
G46X10.0Y10.0
G46X50.0Y10.0
G46X50.0Y70.0
M01
R1M02X55.0
M02
M08
T1
M51,1
M25
M52,3
X12.0Y12.0
X30.0Y12.0
X48.0Y12.0
X12.0Y40.0
X30.0Y40.0
X48.0Y40.0
X12.0Y68.0
X30.0Y68.0
X48.0Y68.0
X40.0Y55.0
M01
R1M02X55.0
M02
M08
M30
)";

std::string config_text(int seed) {
  return fmt::format(R"(
[vision]
rotate = 3
search_radius_mm = 0.9
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 1.0
[[vision.tool]]
number = 2
shape = "disc"
size_mm = 0.7
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.0, -3.0]
[sim]
seed = {}
panel_offset_mm = [0.4, -0.25]
panel_rotation_mrad = 2.0
stretch_ppm = [200, -120]
board_offset_sigma_um = 60
board_rotation_sigma_mrad = 0.4
noise = 3
light_gradient = 0.05
vignetting = 0.05
)",
                     seed);
}

double normalized_squared_error(const Eigen::Vector2d& error, const Eigen::Matrix2d& cov) {
  return error.dot(cov.llt().solve(error));
}

double largest_sigma_um(const Eigen::Matrix2d& cov_mm2) {
  const double mean = cov_mm2.trace() / 2;
  return 1e3 * std::sqrt(mean + std::sqrt(std::max(0.0, mean * mean - cov_mm2.determinant())));
}

/// Sums over seeds.
struct Honesty {
  double fiducials = 0;  ///< of squared normalised errors
  double holes = 0;
  int n_fiducials = 0;
  int n_holes = 0;
  double worst_hole_um = 0;
  double hole_sigma_um = 0;  ///< of the last hole, its longest axis
  double fiducial_sigma_um = 0;
};

void add_seed(const Program& program, const MachineConfig& config, Honesty& sums) {
  auto machine = SimMachine::create(config, program);
  ASSERT_TRUE(machine) << machine.error().text();
  DiagnosticLog log;
  const Survey survey = panelcal::survey(program, config.walk, *machine, log);
  ASSERT_FALSE(log.has_errors()) << test::all_text(log);
  ASSERT_EQ(survey.measurements.size(), machine->truth().targets.size());
  for (std::size_t i = 0; i < survey.measurements.size(); ++i) {
    const auto& measured = survey.measurements[i].measured;
    const Eigen::Vector2d error_mm =
        (measured.position - machine->truth().targets[i].actual).in_mm();
    sums.fiducials += normalized_squared_error(error_mm, measured.cov);
    ++sums.n_fiducials;
    sums.fiducial_sigma_um = largest_sigma_um(measured.cov);
  }
  test::HoleSink sink;
  execute(program, config.walk, survey, sink, log);
  ASSERT_FALSE(log.has_errors()) << test::all_text(log);
  for (const test::Hole& hole : sink.holes()) {
    const auto actual = machine->truth().actual_from_nominal(hole.path)(hole.drill.nominal);
    const Eigen::Vector2d error_mm = (hole.drill.corrected - actual).in_mm();
    sums.holes += normalized_squared_error(error_mm, hole.drill.cov_mm2);
    ++sums.n_holes;
    sums.hole_sigma_um = largest_sigma_um(hole.drill.cov_mm2);
    sums.worst_hole_um = std::max(sums.worst_hole_um, error_mm.norm() * 1e3);
  }
}

TEST(Honesty, PredictedCovarianceOfFiducialsAndHolesIsTheRealOne) {
  const test::TemporaryFolder folder;
  const auto program = test::program_of(std::string(kProgram));
  Honesty sums;
  for (int seed = 1; seed <= kJobs; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto config =
        test::config_with_camera(folder.path(), test::test_camera(320, 320), config_text(seed));
    ASSERT_TRUE(config) << config.error().text();
    ASSERT_NO_FATAL_FAILURE(add_seed(program, *config, sums));
  }
  ASSERT_EQ(sums.n_fiducials, 9 * kJobs);
  ASSERT_EQ(sums.n_holes, 20 * kJobs);
  const double fiducials = sums.fiducials / (2.0 * sums.n_fiducials);
  const double holes = sums.holes / (2.0 * sums.n_holes);
  RecordProperty("fiducials", std::to_string(fiducials));
  RecordProperty("holes", std::to_string(holes));
  RecordProperty("worst_hole_um", std::to_string(sums.worst_hole_um));
  EXPECT_NEAR(fiducials, 1, kTolerance);
  EXPECT_NEAR(holes, 1, kTolerance);
}

/// What hobby machines look with: 20 um a pixel, an unsharp lens, noise of a small sensor.
constexpr std::string_view kUsbProgram = R"(M48
METRIC,TZ
FMAT,2
VER,1
T1C0.8
%
G90
G34,1
G36X5.0Y5.0
G36X95.0Y5.0
G36X95.0Y65.0
G36X5.0Y65.0
T1
X12.0Y12.0
X50.0Y35.0
X90.0Y12.0
X30.0Y60.0
M30
)";

TEST(Honesty, AUsbCameraOf640x480At20umAPixelKnowsItsSigma) {
  constexpr int kPanels = 200;
  constexpr double kSharpness_px = 1.5;
  constexpr double kNoise = 6;
  // A refused panel has no holes to judge.
  constexpr double kFalseAlarm = 1e-9;
  const test::TemporaryFolder folder;
  const auto program = test::program_of(std::string(kUsbProgram));
  CameraCalibration camera = test::test_camera(640, 480);
  camera.parameters.scale_mm_per_px = 0.02;
  Honesty sums;
  for (int seed = 1; seed <= kPanels; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    auto config = test::config_with_camera(folder.path(), camera, config_text(seed));
    ASSERT_TRUE(config) << config.error().text();
    config->walk.series_size = 4;
    config->sim->blur_px = kSharpness_px;
    config->sim->noise = kNoise;
    config->walk.base_limits.false_alarm = kFalseAlarm;
    ASSERT_NO_FATAL_FAILURE(add_seed(program, *config, sums));
  }
  ASSERT_EQ(sums.n_fiducials, 4 * kPanels);
  ASSERT_EQ(sums.n_holes, 4 * kPanels);
  const double fiducials = sums.fiducials / (2.0 * sums.n_fiducials);
  const double holes = sums.holes / (2.0 * sums.n_holes);
  RecordProperty("fiducials", std::to_string(fiducials));
  RecordProperty("holes", std::to_string(holes));
  RecordProperty("fiducial_sigma_um", std::to_string(sums.fiducial_sigma_um));
  RecordProperty("hole_sigma_um", std::to_string(sums.hole_sigma_um));
  RecordProperty("worst_hole_um", std::to_string(sums.worst_hole_um));
  EXPECT_NEAR(fiducials, 1, kTolerance);
  // Holes of a panel share the draw of its four pads: eight numbers less five that are fitted.
  EXPECT_NEAR(holes, 1, 0.2);
  EXPECT_LT(sums.worst_hole_um, 5);
}

/// Sigmas of a calibration that is far worse than a picture's noise, so that it is what is tested:
/// 50 ppm, 50 urad, 0.2 px and 0.15 px, 5 % of the distortion.
CameraCovariance poor_calibration() {
  const Eigen::Vector<double, 5> sigma(5e-7, 5e-5, 0.2, 0.15, 2e-9);
  CameraCovariance cov = sigma.cwiseAbs2().asDiagonal();
  cov(2, 3) = cov(3, 2) = 0.4 * sigma[2] * sigma[3];
  return cov;
}

/// A camera that differs from its calibration by one draw.
CameraMapping::Parameters real_camera(const CameraMapping::Parameters& calibrated, Random& random) {
  Eigen::Vector<double, 5> z;
  for (double& one : z) one = random.normal();
  const CameraCovariance root = poor_calibration().llt().matrixL();
  const Eigen::Vector<double, 5> error = root * z;
  CameraMapping::Parameters real = calibrated;
  real.scale_mm_per_px -= error[0];
  real.rotation_rad -= error[1];
  real.axis_px -= error.segment<2>(2);
  real.k1_per_px2 -= error[4];
  return real;
}

TEST(Honesty, ErrorsOfTheCalibrationComeThroughFitsAsPredicted) {
  // Two boards' holes of one seed share one draw, nearly the axis's two coordinates.
  constexpr int kDraws = 150;
  const double tolerance = test::kStatisticalLimit / std::sqrt(static_cast<double>(kDraws));
  const test::TemporaryFolder folder;
  const auto program = test::program_of(std::string(kProgram));
  Honesty stated;
  Honesty silent;
  for (int seed = 1; seed <= kDraws; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    auto config =
        test::config_with_camera(folder.path(), test::test_camera(320, 320), config_text(seed));
    ASSERT_TRUE(config) << config.error().text();
    Random random = Random(20261121).fork(static_cast<std::uint64_t>(seed));
    config->sim->camera = real_camera(config->camera->parameters, random);
    ASSERT_NO_FATAL_FAILURE(add_seed(program, *config, silent));
    config->walk.uncertainty.camera = poor_calibration();
    ASSERT_NO_FATAL_FAILURE(add_seed(program, *config, stated));
  }
  const double holes = stated.holes / (2.0 * stated.n_holes);
  RecordProperty("holes", std::to_string(holes));
  EXPECT_NEAR(holes, 1, tolerance);
  // Without the covariance the same holes would be promised far too much.
  EXPECT_GT(silent.holes / (2.0 * silent.n_holes), 10);
}

}  // namespace
}  // namespace panelcal
