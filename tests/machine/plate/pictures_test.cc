// SPDX-License-Identifier: Apache-2.0
#include "machine/plate/pictures.h"

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>

#include "machine/calibrate/camera/run.h"
#include "machine/sim/sim_plate.h"
#include "vision/picture/files/image_io.h"
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

constexpr std::string_view kMachine = R"([[vision.tool]]
number = 1
shape = "disc"
size_mm = 0.3
polarity = "dark"
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.0, -3.0]
[sim]
seed = 5
noise = 2
background = 0.5
target_level = 0.8
)";
constexpr std::string_view kPlate = R"([plate]
columns = 5
rows = 4
pitch_mm = 0.8
dot_diameter_mm = 0.3
certified = true
[[pose]]
origin_mm = [100, 80]
angle_deg = 0
[[pose]]
origin_mm = [104, 79]
angle_deg = 90
)";

/// True turns of the plate, beside those of its file.
constexpr double kTurns_rad[] = {0.012, 1.565};
const Eigen::Vector2d kShifts_mm[] = {{100.05, 79.93}, {103.94, 79.06}};

class PlatePicturesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto config =
        test::config_with_camera(folder_.path(), test::test_camera(240, 200), kMachine);
    ASSERT_TRUE(config) << config.error().text();
    config_ = *config;
    const auto plate = parse_plate(kPlate, "plate.toml");
    ASSERT_TRUE(plate) << plate.error().text();
    plate_ = *plate;
  }

  /// Takes a picture over every dot, in its pose's folder; the stage errs by `error_mm`.
  void record(std::size_t i_pose,
              const std::function<Eigen::Vector2d(const Position<frame::Machine>&)>& error_mm) {
    SimPlateOptions options;
    options.error_mm = error_mm;
    for (const PlateDot& dot : plate_.dots()) {
      options.marks.push_back(place_in(lies_[i_pose], dot.place));
    }
    auto machine = SimPlate::create(config_, std::move(options));
    ASSERT_TRUE(machine) << machine.error().text();
    const auto folder = folder_.path() / "looks" / std::to_string(i_pose);
    std::filesystem::create_directories(folder);
    std::string csv = "file,x,y\n";
    int n = 0;
    for (const PlateDot& dot : plate_.dots()) {
      const auto axis = place_in(plate_.poses[i_pose], dot.place);
      ASSERT_TRUE(machine->move_to(config_.spindle_camera.spindle_to_see(axis)));
      const auto image = machine->take();
      ASSERT_TRUE(image);
      const std::string name = fmt::format("{}.png", n++);
      ASSERT_TRUE(write_png(folder / name, *image));
      csv += fmt::format("{},{},{}\n", name, axis.in_mm().x(), axis.in_mm().y());
    }
    ASSERT_TRUE(write_file(folder / "images.csv", csv));
  }

  Expected<MarkSights> look() const {
    PANELCAL_TRY(const auto folders, read_plate_folders(folder_.path() / "looks", plate_));
    return look_at_plate(config_, plate_, folders);
  }

  test::TemporaryFolder folder_;
  MachineConfig config_;
  CalibrationPlate plate_;
  std::vector<PlatePose> lies_ = {{kTurns_rad[0], kShifts_mm[0]}, {kTurns_rad[1], kShifts_mm[1]}};
};

TEST_F(PlatePicturesTest, TellsEveryDotFromItsNeighbours) {
  record(0, {});
  record(1, {});
  const auto sights = look();
  ASSERT_TRUE(sights) << sights.error().text();
  EXPECT_EQ(sights->data.views.size(), 40u);
  EXPECT_TRUE(sights->missed.empty());
  // Every picture shows its own dot and neighbours; the calibration is exact.
  EXPECT_GT(sights->data.seen.size(), 100u);
  const CameraModel model = config_.camera->model();
  for (const CameraObservation& look : sights->data.seen) {
    const PlateView& view = sights->data.views[look.i_view];
    const auto truth = place_in(lies_[view.i_pose], sights->data.dots[look.i_dot].place);
    const auto seen =
        view.axis_at + displacement_mm<frame::Machine>(model(look.seen.position).in_mm());
    EXPECT_THAT(seen, test::IsNearPosition(truth, um(1.5)));
  }
}

TEST_F(PlatePicturesTest, GivesTheTablesScaleAndSquareness) {
  // 400 ppm in x, 250 urad out of square, and a scale that the certified plate tells; of a plate
  // whose pictures show one dot each.
  plate_.pitch = mm(20);
  lies_[0].angle_rad = 0.002;
  record(0, [](const Position<frame::Machine>& p) -> Eigen::Vector2d {
    const Eigen::Vector2d c = p.in_mm() - Eigen::Vector2d(95, 113);
    return {4e-4 * c.x() + 2.5e-4 * c.y(), 0};
  });
  plate_.poses.resize(1);
  const auto sights = look();
  ASSERT_TRUE(sights) << sights.error().text();
  const auto run = calibrate_table(config_, table_sights(config_, *sights));
  ASSERT_TRUE(run) << run.error().text();
  const TableGeometry& geometry = run->fit.geometry;
  const auto sigma = [&](int i) { return std::sqrt(geometry.cov(i, i)); };
  EXPECT_NEAR(geometry.value[TableGeometry::ScaleX], 4e-4, 4 * sigma(TableGeometry::ScaleX))
      << report(*run);
  EXPECT_NEAR(geometry.value[TableGeometry::ScaleY], 0, 4 * sigma(TableGeometry::ScaleY));
  // Sent along y, the stage also goes along x, so the angle between the axes is less than 90
  // degrees.
  EXPECT_NEAR(
      geometry.value[TableGeometry::Squareness], 2.5e-4, 4 * sigma(TableGeometry::Squareness));
  EXPECT_LT(sigma(TableGeometry::ScaleX), 1e-4) << report(*run);
}

TEST_F(PlatePicturesTest, GivesTheCamera) {
  config_.sim->camera = config_.camera->parameters;
  config_.sim->camera->scale_mm_per_px *= 1.004;
  config_.sim->camera->rotation_rad += 0.003;
  record(0, {});
  plate_.poses.resize(1);
  auto sights = look();
  ASSERT_TRUE(sights) << sights.error().text();
  CameraRunOptions options;
  options.form = CameraForm::Radial;
  const auto run = fit_camera_run(config_, *std::move(sights), options);
  ASSERT_TRUE(run) << run.error().text();
  EXPECT_NEAR(run->fit.parameters.scale_mm_per_px,
              config_.sim->camera->scale_mm_per_px,
              4 * std::sqrt(run->fit.covariance(0, 0)));
  EXPECT_NEAR(run->fit.parameters.rotation_rad,
              config_.sim->camera->rotation_rad,
              4 * std::sqrt(run->fit.covariance(1, 1)));
  EXPECT_LE(*run->fit.held_out_rms_px, 0.03);
}

TEST_F(PlatePicturesTest, RefusesDotsThatDoNotMakeOnePlate) {
  // Right of the second column every stop is 0.22 mm off, 0.28 of the pitch: each dot is near
  // enough to be found, and together they are no plate.
  record(0, [](const Position<frame::Machine>& p) -> Eigen::Vector2d {
    return {p.in_mm().x() > 100 + 1.2 - 45 ? 0.22 : 0.0, 0};
  });
  plate_.poses.resize(1);
  EXPECT_THAT(look(), FailsWith(Code::CalibrationData, "pose 0"));
}

TEST_F(PlatePicturesTest, SaysWhyNoDotIsKnown) {
  record(0, {});
  CalibrationPlate elsewhere = plate_;
  elsewhere.poses.resize(1);
  elsewhere.poses[0].shift_mm << 300, 300;
  const auto folders = read_plate_folders(folder_.path() / "looks", elsewhere);
  ASSERT_TRUE(folders) << folders.error().text();
  EXPECT_THAT(look_at_plate(config_, elsewhere, *folders), FailsWith(Code::CalibrationData));
  CalibrationPlate no_size = plate_;
  no_size.dot_diameter = mm(0);
  EXPECT_THAT(look_at_plate(config_, no_size, *folders),
              FailsWith(Code::ConfigValue, "dot_diameter_mm"));
  no_size.poses.clear();
  EXPECT_THAT(read_plate_folders(folder_.path() / "looks", no_size),
              FailsWith(Code::ConfigValue, "[[pose]]"));
  EXPECT_THAT(look_at_plate(config_, plate_, *folders, 4.0),
              FailsWith(Code::ConfigValue, "calibration"));
}

}  // namespace
}  // namespace panelcal
