// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_coupon.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "machine/sources/device_set.h"
#include "vision/locate/focus.h"
#include "vision/locate/locate.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

constexpr double kMark_mm[] = {300.02, 199.97};

class SimCouponMark : public ::testing::Test {
 protected:
  /// The machine of a machine.toml; `coupon` are lines of [sim.coupon].
  DeviceSet machine(const std::string& sim, const std::string& coupon) {
    const auto config = this->config(sim, coupon);
    EXPECT_TRUE(config) << config.error().text();
    config_ = *config;
    auto made = DeviceSet::simulated(config_);
    EXPECT_TRUE(made) << made.error().text();
    return *std::move(made);
  }
  Expected<MachineConfig> config(const std::string& sim, const std::string& coupon) const {
    return test::config_with_camera(folder_.path(), test::test_camera(160, 120), R"(
[[vision.tool]]
number = 2
shape = "disc"
size_mm = 0.4
[[vision.tool]]
number = 1
shape = "hole"
size_mm = 0.8
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.0, -3.0]
[sim]
)" + sim + "[sim.coupon]\n" + coupon);
  }

  /// Seen place of the mark from its true place.
  Eigen::Vector2d seen_um(const CalibrationDevices& devices) const {
    const auto image = devices.camera.take();
    if (!image) ADD_FAILURE() << image.error().text();
    const CameraMapping mapping = config_.camera->mapping();
    const Detection seen = locate(*image, config_.vision_tools.at(2), &mapping, config_.locate);
    if (!seen.best) ADD_FAILURE() << seen.reason;
    if (!seen.best) return Eigen::Vector2d::Zero();
    return 1e3 * mapping(seen.best->center).position.in_mm();
  }
  void look_at_mark(const CalibrationDevices& devices) const {
    const auto mark = position_mm<frame::Machine>(kMark_mm[0], kMark_mm[1]);
    ASSERT_TRUE(devices.stage.move_to(config_.spindle_camera.spindle_to_see(mark)));
  }

  test::TemporaryFolder folder_;
  MachineConfig config_;
};

const std::string kMarkLines = "mark_mm = [300.02, 199.97]\nmark_tool = 2\n";
/// A disc of 40 px without noise is found so well.
constexpr double kSame_um = 0.3;

TEST_F(SimCouponMark, IsSeenWhereItIs) {
  const DeviceSet machine = this->machine("", kMarkLines);
  const CalibrationDevices devices = machine.devices();
  look_at_mark(devices);
  EXPECT_LT(seen_um(devices).norm(), kSame_um);
}

TEST_F(SimCouponMark, IsSharpAtItsHeightAndBrightAtItsLamp) {
  const DeviceSet machine = this->machine("lamp = 50\nfocus_z_mm = 0.4\n", kMarkLines);
  const CalibrationDevices devices = machine.devices();
  look_at_mark(devices);
  const auto sharpness_at = [&](double z_mm) {
    EXPECT_TRUE(devices.camera.set(CameraSetting::Focus, z_mm));
    return sharpness(*devices.camera.take());
  };
  EXPECT_GT(sharpness_at(0.4), sharpness_at(0.3));
  EXPECT_GT(sharpness_at(0.4), sharpness_at(0.5));
  const auto brightest_at = [&](double level) {
    EXPECT_TRUE(devices.camera.set(CameraSetting::Lamp, level));
    const Image image = *devices.camera.take();
    return *std::ranges::max_element(image.pixels());
  };
  EXPECT_NEAR(brightest_at(25), 0.5 * brightest_at(50), 1.5);
}

TEST_F(SimCouponMark, SwingsAfterAMoveUntilItHasBeenWaitedFor) {
  const DeviceSet machine =
      this->machine("", kMarkLines + "swing_um = 30\nswing_decay_s = 0.1\nswing_hz = 10\n");
  const CalibrationDevices devices = machine.devices();
  look_at_mark(devices);
  EXPECT_NEAR(seen_um(devices).norm(), 30, kSame_um);
  devices.wait(seconds(0.1));
  EXPECT_NEAR(seen_um(devices).norm(), 30 / std::numbers::e, kSame_um);
  devices.wait(seconds(1));
  EXPECT_LT(seen_um(devices).norm(), kSame_um);
  // Without a move it stays at rest.
  look_at_mark(devices);
  EXPECT_LT(seen_um(devices).norm(), kSame_um);
}

TEST_F(SimCouponMark, IsSeenElsewhereWhileTheMachineWarmsUp) {
  const DeviceSet machine =
      this->machine("", kMarkLines + "cold_um = [40, -20]\nwarm_up_s = 300\n");
  const CalibrationDevices devices = machine.devices();
  look_at_mark(devices);
  // The axis stands farther by the cold offset, so the mark is seen on the other side.
  const Eigen::Vector2d cold_um = seen_um(devices);
  EXPECT_NEAR(cold_um.x(), -40, kSame_um);
  EXPECT_NEAR(cold_um.y(), 20, kSame_um);
  devices.wait(seconds(300));
  EXPECT_NEAR(seen_um(devices).x(), -40 / std::numbers::e, kSame_um);
}

TEST_F(SimCouponMark, SayWhatMakesNoSense) {
  EXPECT_THAT(config("", "mark_tool = 2\n"), FailsWith(Code::ConfigValue, "mark_mm"));
  EXPECT_THAT(config("", "swing_decay_s = 0\n"), FailsWith(Code::ConfigValue, "swing_decay_s"));
  EXPECT_THAT(config("", "cold_mm = 1\n"), FailsWith(Code::ConfigKeyUnknown, "cold_um"));
  const auto no_tool = config("", "mark_mm = [1, 2]\nmark_tool = 7\n");
  ASSERT_TRUE(no_tool);
  const auto made = DeviceSet::simulated(*no_tool);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, Code::VisionToolUndefined);
}

}  // namespace
}  // namespace panelcal
