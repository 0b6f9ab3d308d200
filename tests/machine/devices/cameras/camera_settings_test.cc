// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/camera_settings.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::ElementsAre;
using testing::IsEmpty;

using Orders = std::vector<std::string>;

/// Writes down what it is told to set, if it can.
class WrittenMachine final : public Stage, public CameraDevice, public Spindle {
 public:
  WrittenMachine(std::string name, std::vector<CameraSetting> can, Orders& orders)
      : name_(std::move(name)), can_(std::move(can)), orders_(orders) {}

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    return spindle;
  }
  Expected<void> drill(int /*tool*/) override { return {}; }
  Expected<Image> take() override { return Image(); }
  std::string name() const override { return name_; }
  bool can_set(CameraSetting setting) const override {
    return std::ranges::find(can_, setting) != can_.end();
  }
  Expected<void> set(CameraSetting setting, double value) override {
    orders_.push_back(fmt::format("{} {} {}", name_, panelcal::name(setting), value));
    return {};
  }

 private:
  std::string name_;
  std::vector<CameraSetting> can_;
  Orders& orders_;
};

class CameraSettings : public ::testing::Test {
 protected:
  Orders orders_;
  WrittenMachine camera_{"camera", {CameraSetting::Lamp}, orders_};
  WrittenMachine stage_{"stage", {CameraSetting::Lamp, CameraSetting::Focus}, orders_};
  CalibrationDevices devices_{stage_, stage_, camera_, {}, {}};
  MachineConfig config_;
};

TEST_F(CameraSettings, AreSetAsMachineTomlStatesThemAndTheCamerasOwnFirst) {
  config_.vision.lamp = 40;
  config_.vision.focus = mm(-0.5);
  ASSERT_TRUE(set_camera_as_stated(config_, devices_));
  EXPECT_THAT(orders_, ElementsAre("camera lamp 40", "stage focus -0.5"));
}

TEST_F(CameraSettings, BeginAtTheUsualZoom) {
  config_.camera_file = "here/camera.cal.json";
  config_.zoom_files = {{1, "here/wide.cal.json"}, {2, "here/./camera.cal.json"}};
  ASSERT_TRUE(set_camera_as_stated(config_, devices_));
  EXPECT_THAT(orders_, IsEmpty());  // no command sets it
  WrittenMachine zooming{"stage", {CameraSetting::Zoom}, orders_};
  ASSERT_TRUE(set_camera_as_stated(config_, {zooming, zooming, camera_, {}, {}}));
  EXPECT_THAT(orders_, ElementsAre("stage zoom 2"));
}

TEST_F(CameraSettings, StayAsTheyAreWhereNobodyStatesThem) {
  ASSERT_TRUE(set_camera_as_stated(config_, devices_));
  EXPECT_THAT(orders_, IsEmpty());
}

TEST_F(CameraSettings, ThatNobodyCanSetAreRefused) {
  config_.file = "machine.toml";
  config_.vision.focus = mm(1);
  const CalibrationDevices no_axis{camera_, camera_, camera_, {}, {}};
  EXPECT_THAT(set_camera_as_stated(config_, no_axis),
              FailsWith(Code::ConfigValue, "focus_command"));
  EXPECT_THAT(orders_, IsEmpty());
}

TEST(CameraSettingsOfMachineToml, AreReadAndHeldAgainstTheRange) {
  const test::TemporaryFolder folder;
  const auto read = [&folder](const std::string& lines) {
    return test::config_with_camera(folder.path(),
                                    test::test_camera(160, 120),
                                    "[camera]\ncalibration = \"camera.cal.json\"\n" + lines);
  };
  const auto config = read("focus_range_mm = [-1, 2]\nfocus_mm = 1.5\nlamp = 40\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->vision.focus, mm(1.5));
  EXPECT_EQ(config->vision.lamp, 40);
  // Without one the travel of the axis is not known.
  EXPECT_THAT(read("focus_mm = 2.5\n"), FailsWith(Code::ConfigValue, "focus"));
  EXPECT_THAT(read("focus_range_mm = [-1, 2]\nfocus_mm = 2.5\n"),
              FailsWith(Code::ConfigValue, "-1 to 2"));
  EXPECT_THAT(read("lamp = -1\n"), FailsWith(Code::ConfigValue, "lamp"));
}

}  // namespace
}  // namespace panelcal
