// SPDX-License-Identifier: Apache-2.0
#include "machine/init/machine_text.h"

#include <chrono>
#include <cmath>
#include <sstream>
#include <string>

#include "machine/config/machine_config.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr std::chrono::sys_seconds kDay = std::chrono::sys_days{2026y / 11 / 28};
constexpr auto kKinds = {MachineKind::UsbCameraLinuxCnc,
                         MachineKind::UsbCameraGrbl,
                         MachineKind::GigeCnc7,
                         MachineKind::Folder};

/// The configuration that every command reads of a new machine.toml beside its assumed camera.
Expected<MachineConfig> configured(const MachineAnswers& answers) {
  const test::TemporaryFolder folder;
  const auto camera = assumed_camera(answers, kDay);
  EXPECT_TRUE(write_camera_calibration(folder.path() / kAssumedCameraFile, camera));
  const auto file = folder.path() / "machine.toml";
  return parse_machine_config(machine_text(answers, "machine.toml"), file.string());
}

TEST(MachineText, EveryKindIsFoundByItsName) {
  for (const MachineKind kind : kKinds) EXPECT_EQ(machine_kind_from_name(name(kind)), kind);
  EXPECT_EQ(machine_kind_from_name("laser"), std::nullopt);
}

TEST(MachineText, IsReadAsItIs) {
  for (const MachineKind kind : kKinds) {
    const auto config = configured({.kind = kind});
    ASSERT_TRUE(config) << name(kind) << ": " << config.error().text();
    EXPECT_EQ(config->name, "my machine");
    EXPECT_EQ(config->vision_tools.size(), 1U);
    EXPECT_EQ(config->gcode.has_value(), config->control.driver.has_value()) << name(kind);
  }
}

TEST(MachineText, HasWhatAPersonSaid) {
  MachineAnswers answers;
  answers.kind = MachineKind::UsbCameraGrbl;
  answers.name = "mill \"B\" \\ \n[sim]";
  answers.device = "/dev/ttyACM1";
  answers.safe_z = mm(-2.5);
  answers.travel_low = {mm(0), mm(0)};
  answers.travel_high = {mm(300), mm(180.5)};
  answers.fiducials = {mm(1.5), mm(2)};
  const auto config = configured(answers);
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->name, answers.name);
  EXPECT_EQ(config->control.driver, ControlKind::Grbl);
  EXPECT_EQ(config->control.device, "/dev/ttyACM1");
  EXPECT_EQ(config->control.safe_z, mm(-2.5));
  EXPECT_EQ(config->vision_tools.size(), 2U);
  answers.device.clear();
  answers.host = "cnc.local";
  const auto by_network = configured(answers);
  ASSERT_TRUE(by_network) << by_network.error().text();
  EXPECT_EQ(by_network->control.host, "cnc.local");
  EXPECT_EQ(by_network->control.device, "");
}

TEST(MachineText, PutsHelpBeforeEveryKeyAndMarksWhatIsAssumed) {
  for (const MachineKind kind : kKinds) {
    std::istringstream lines(machine_text({.kind = kind}, "machine.toml"));
    std::string before;
    for (std::string line; std::getline(lines, line); before = line) {
      if (line.find(" = ") == std::string::npos || line.starts_with('#')) continue;
      EXPECT_TRUE(before.starts_with("# ")) << line;
      EXPECT_THAT(before, AllOf(Not(HasSubstr("](")), testing::SizeIs(testing::Le(100U))));
    }
  }
  const std::string mill = machine_text({.kind = MachineKind::UsbCameraLinuxCnc}, "m.toml");
  EXPECT_THAT(mill, HasSubstr("camera_offset_sigma_um = 1000  # assumed; panelcal calibrate"));
  EXPECT_THAT(mill, HasSubstr("panelcal check -m m.toml"));
  EXPECT_THAT(machine_text({.kind = MachineKind::Folder}, "m.toml"),
              AllOf(Not(HasSubstr("[spindle]")), HasSubstr("--images PICTURES")));
}

TEST(AssumedCamera, IsAsUnsureAsACameraThatWasJustScrewedOn) {
  MachineAnswers answers;
  answers.pixel = um(20);
  answers.picture_px = {640, 480};
  const CameraCalibration camera = assumed_camera(answers, kDay);
  EXPECT_EQ(camera.picture_width_px, 640);
  EXPECT_EQ(camera.picture_height_px, 480);
  EXPECT_DOUBLE_EQ(camera.parameters.scale_mm_per_px, 0.02);
  // The middle between the first and the last pixel, whose middles are whole numbers.
  EXPECT_EQ(camera.parameters.axis_px, Eigen::Vector2d(319.5, 239.5));
  EXPECT_DOUBLE_EQ(std::sqrt(camera.covariance(0, 0)), 0.0004);
  EXPECT_DOUBLE_EQ(std::sqrt(camera.covariance(1, 1)), 0.05);
  EXPECT_DOUBLE_EQ(std::sqrt(camera.covariance(3, 3)), 20);
  EXPECT_THAT(camera.provenance, HasSubstr("not measured"));
}

}  // namespace
}  // namespace panelcal
