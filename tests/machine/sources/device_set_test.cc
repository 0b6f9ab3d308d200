// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/device_set.h"

#include <filesystem>
#include <string>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "machine/devices/commands/command_spindle.h"
#include <gmock/gmock.h>

#include "tests/machine/calibrate/spindle/coupon_toml.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

TEST(CommandSpindle, TellsTheProgramWhichTool) {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "drilled").string();
  CommandSpindle spindle(
      {"/bin/sh", "-c", "printf '%s ' \"$1\" >> '" + file + "'", "sh", "T{tool}"}, seconds(10));
  EXPECT_TRUE(spindle.can_drill());
  ASSERT_TRUE(spindle.drill(4));
  ASSERT_TRUE(spindle.drill(17));
  EXPECT_EQ(read_file(file).value_or(""), "T4 T17 ");
}

TEST(CommandSpindle, AProgramThatFailsIsADrillThatFailed) {
  CommandSpindle spindle({"/bin/sh", "-c", "echo broken >&2; exit 3", "{tool}"}, seconds(10));
  EXPECT_THAT(spindle.drill(1), FailsWith(Code::DeviceStage, "broken"));
}

TEST(CommandSpindle, WithoutACommandItCannotDrill) {
  CommandSpindle spindle({}, seconds(10));
  EXPECT_FALSE(spindle.can_drill());
  EXPECT_THAT(spindle.drill(1), FailsWith(Code::NotSupported, "drill_command"));
}

class DeviceSetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto config = test::spindle_machine(folder_.path());
    ASSERT_TRUE(config) << config.error().text();
    config_ = *std::move(config);
  }

  test::TemporaryFolder folder_;
  MachineConfig config_;
};

TEST_F(DeviceSetTest, TheSimulatedMachineSeesWhatItDrilled) {
  auto made = DeviceSet::simulated(config_);
  ASSERT_TRUE(made) << made.error().text();
  const DeviceSet set = *std::move(made);
  const CalibrationDevices devices = set.devices();
  const auto place = position_mm<frame::Machine>(300, 100);
  const auto spindle = place - displacement_mm<frame::Machine>(45.03, -2.98);
  ASSERT_TRUE(devices.stage.move_to(spindle));
  const auto before = devices.camera.take();
  ASSERT_TRUE(devices.stage.move_to(place));
  ASSERT_TRUE(devices.spindle.drill(1));
  ASSERT_TRUE(devices.stage.move_to(spindle));
  const auto after = devices.camera.take();
  ASSERT_TRUE(before && after);
  const CameraMapping::Parameters& camera = config_.camera->parameters;
  const int x_px = static_cast<int>(camera.axis_px.x());
  const int y_px = static_cast<int>(camera.axis_px.y());
  EXPECT_GT(before->at(x_px, y_px), after->at(x_px, y_px) + 40) << "a hole is dark";
}

TEST_F(DeviceSetTest, ADamagedStateOfTheCouponIsNotOverlooked) {
  ASSERT_TRUE(write_file(config_.coupon->state_file, "{"));
  EXPECT_THAT(DeviceSet::simulated(config_), FailsWith(Code::JsonSyntax, "coupon.json"));
}

TEST_F(DeviceSetTest, WithoutSimThereIsNoSimulatedMachine) {
  config_.sim.reset();
  EXPECT_THAT(DeviceSet::simulated(config_), FailsWith(Code::ConfigValue, "[sim]"));
}

TEST_F(DeviceSetTest, ALiveMachineNeedsAStage) {
  EXPECT_THAT(DeviceSet::live(config_, "folder:" + folder_.path().string()),
              FailsWith(Code::ConfigValue, "stage_command"));
  EXPECT_THAT(DeviceSet::live(config_, "floppy:a"), FailsWith(Code::CameraUri, "floppy"));
  config_.stage.move = {"true", "{x}", "{y}"};
  EXPECT_FALSE(DeviceSet::live(config_, "folder:" + (folder_.path() / "none").string()));
}

}  // namespace
}  // namespace panelcal
