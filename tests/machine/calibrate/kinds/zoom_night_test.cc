// SPDX-License-Identifier: Apache-2.0
// Nights that calibrate the camera at every zoom level that has a calibration of its own.

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "machine/nightly/nightly.h"
#include "machine/nightly/record/night_files.h"
#include "machine/sim/sim_plate.h"
#include <gmock/gmock.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A table with a mark, seen by a camera that can zoom: one virtual table a level.
class ZoomingTable final : public Stage, public Spindle, public CameraDevice {
 public:
  ZoomingTable(SimPlate usual, SimPlate near)
      : levels_{{{1.0, std::move(usual)}, {2.0, std::move(near)}}} {}

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    for (auto& [level, table] : levels_) PANELCAL_CHECK(table.move_to(spindle));
    return spindle;
  }
  Expected<void> drill(int tool) override { return levels_[0].second.drill(tool); }
  Expected<Image> take() override {
    return levels_[zoom_ == levels_[1].first ? 1 : 0].second.take();
  }
  std::string name() const override { return "zooming"; }
  bool can_set(CameraSetting setting) const override { return setting == CameraSetting::Zoom; }
  Expected<void> set(CameraSetting /*setting*/, double value) override {
    zoom_ = value;
    orders.push_back(value);
    return {};
  }

  std::vector<double> orders;

 private:
  std::array<std::pair<double, SimPlate>, 2> levels_;
  double zoom_ = 1;
};

class ZoomNights : public ::testing::Test {
 protected:
  /// True scale of the near level against its calibration.
  static constexpr double kGrown = 1.001;
  std::string usual_level = "[[camera.zoom]]\nlevel = 1\ncalibration = \"camera.cal.json\"\n";

  static CameraCalibration near_camera() {
    CameraCalibration camera = test::test_camera(160, 120);
    camera.parameters.scale_mm_per_px *= 0.5;
    return camera;
  }

  Expected<MachineConfig> config() const {
    const std::string toml = R"([machine]
name = "drill 1"
[ledger]
file = "drill.ledger"
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 0.2
[camera]
calibration = "camera.cal.json"
[[camera.zoom]]
level = 2
calibration = "near.cal.json"
)" + usual_level + R"([spindle]
camera_offset_mm = [45.0, -3.0]
[nightly]
camera = "gige://192.168.1.10"
calibrate = ["camera"]
mark_mm = [300, 200]
min_disk_mb = 0
[sim]
noise = 2
)";
    PANELCAL_CHECK(write_file(folder_.path() / "machine.toml", toml));
    PANELCAL_CHECK(write_camera_calibration(folder_.path() / "near.cal.json", near_camera()));
    return test::config_with_camera(folder_.path(), test::test_camera(160, 120), toml);
  }

  /// The virtual table as the camera of one level sees it.
  static Expected<SimPlate> table(MachineConfig config,
                                  const CameraCalibration& calibrated,
                                  double grown) {
    config.camera = calibrated;
    config.sim->camera = calibrated.parameters;
    config.sim->camera->scale_mm_per_px *= grown;
    SimPlateOptions options;
    options.marks = {position_mm<frame::Machine>(300.02, 199.97)};
    return SimPlate::create(config, std::move(options));
  }

  Expected<NightRecord> run() {
    PANELCAL_TRY(const MachineConfig config, this->config());
    PANELCAL_TRY(SimPlate usual, table(config, *config.camera, 1));
    PANELCAL_TRY(SimPlate near, table(config, near_camera(), kGrown));
    ZoomingTable machine(std::move(usual), std::move(near));
    auto record =
        run_nightly({config,
                     *config.nightly,
                     {machine, machine, machine, {}, {}},
                     fixed_clock(std::chrono::sys_seconds(std::chrono::seconds(1795302000))),
                     "panelcal test",
                     "timer"});
    orders_ = machine.orders;
    return record;
  }

  test::TemporaryFolder folder_;
  std::vector<double> orders_;
};

TEST_F(ZoomNights, EveryLevelIsCalibratedInstalledAndLeftAgain) {
  const auto record = run();
  ASSERT_TRUE(record) << record.error().text();
  ASSERT_EQ(record->steps.size(), 2u);
  EXPECT_EQ(exit_code(*record), 0) << record->verdict;
  EXPECT_EQ(record->steps[0].subject, "camera");
  EXPECT_EQ(record->steps[1].subject, "zoom 2");
  EXPECT_EQ(record->steps[1].file, folder_.path() / "near.cal.json");
  EXPECT_THAT(orders_, ElementsAre(1, 2, 1));
  const auto near = read_camera_calibration(folder_.path() / "near.cal.json");
  ASSERT_TRUE(near) << near.error().text();
  const auto scale_mm = [](const CameraCalibration& camera) {
    return camera.model().parameters().scale_mm_per_px;
  };
  EXPECT_NEAR(scale_mm(*near) / scale_mm(near_camera()), kGrown, 2e-4);
  const auto usual = read_camera_calibration(folder_.path() / "camera.cal.json");
  ASSERT_TRUE(usual);
  EXPECT_NEAR(scale_mm(*usual) / scale_mm(test::test_camera(160, 120)), 1, 2e-4);
}

TEST_F(ZoomNights, NeedToKnowWhichLevelTheCameraGoesBackTo) {
  usual_level.clear();
  const auto record = run();
  ASSERT_FALSE(record);
  EXPECT_EQ(record.error().code, Code::ConfigValue);
  EXPECT_THAT(record.error().text(), HasSubstr("zoom"));
  EXPECT_TRUE(orders_.empty());
}

TEST_F(ZoomNights, ADamagedCalibrationOfALevelComesBackFromTheLedger) {
  ASSERT_TRUE(run());
  const auto near = folder_.path() / "near.cal.json";
  const std::string good = read_file(near).value_or("none");
  ASSERT_TRUE(write_file(near, "{\"kind\": "));
  const auto files = find_night_files(folder_.path() / "machine.toml");
  ASSERT_TRUE(files) << files.error().text();
  EXPECT_TRUE(files->has_calibration(near));
  EXPECT_FALSE(files->has_calibration(folder_.path() / "machine.toml"));
  EXPECT_THAT(restore_damaged_files(*files).value(),
              ElementsAre(testing::HasSubstr("near.cal.json")));
  EXPECT_EQ(read_file(near).value_or(""), good);
  EXPECT_THAT(restore_damaged_files(*files).value(), testing::IsEmpty());
}

}  // namespace
}  // namespace panelcal
