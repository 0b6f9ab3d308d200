// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <string_view>

#include "machine/config/machine_config.h"
#include "machine/config/settings/control_setting.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

Expected<MachineConfig> machine(std::string_view keys) {
  return parse_machine_config("[machine]\n" + std::string(keys), "machine.toml");
}

constexpr std::string_view kGrbl = "driver = \"grbl\"\ndevice = \"/dev/ttyUSB0\"\nsafe_z_mm = -2\n";

TEST(ControlConfig, ReadsEveryKey) {
  const auto config = machine(std::string(kGrbl) +
                              "baud = 230400\nhoming = \"when_locked\"\nmove_feed_mm_min = 1500\n"
                              "move_limit_s = 30\nprobe_feed_mm_min = 40\nprobe_from_mm = -10\n"
                              "probe_to_mm = -20\nprobe_z0_mm = -15.5\n");
  ASSERT_TRUE(config) << config.error().text();
  const ControlSetting& control = config->control;
  EXPECT_EQ(control.driver, ControlKind::Grbl);
  EXPECT_EQ(control.device, "/dev/ttyUSB0");
  EXPECT_EQ(control.baud, 230400);
  EXPECT_EQ(control.homing, Homing::WhenLocked);
  EXPECT_EQ(control.safe_z.in_mm(), -2);
  EXPECT_EQ(control.move_feed_mm_min, 1500);
  EXPECT_EQ(control.limit.in_s(), 30);
  ASSERT_TRUE(control.probe);
  EXPECT_EQ(control.probe->feed_mm_min, 40);
  EXPECT_EQ(control.probe->from.in_mm(), -10);
  EXPECT_EQ(control.probe->to.in_mm(), -20);
  EXPECT_EQ(control.probe->z0.in_mm(), -15.5);
  EXPECT_TRUE(config->can_move());
  EXPECT_TRUE(config->can_probe());
}

TEST(ControlConfig, ADriverAloneMovesAndDoesNotProbe) {
  const auto config = machine("driver = \"linuxcnc\"\nhost = \"mill\"\nsafe_z_mm = 0\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_TRUE(config->can_move());
  EXPECT_FALSE(config->can_probe());
  EXPECT_FALSE(machine("")->can_move());
}

TEST(ControlConfig, RefusesKeysThatContradictEachOther) {
  const auto grbl = [](std::string_view more) {
    return machine(std::string(kGrbl) + std::string(more));
  };
  EXPECT_THAT(grbl("stage_command = [\"drive\", \"{x}\", \"{y}\"]\n"),
              FailsWith(Code::ConfigValue, "stage_command"));
  EXPECT_THAT(grbl("probe_command = [\"probe\", \"{x}\", \"{y}\"]\n"),
              FailsWith(Code::ConfigValue, "probe_command"));
  EXPECT_THAT(grbl("host = \"mill\"\n"), FailsWith(Code::ConfigValue, "driver"));
  EXPECT_THAT(grbl("port = 23\n"), FailsWith(Code::ConfigValue, "port"));
  EXPECT_THAT(grbl("connect_password = \"x\"\n"), FailsWith(Code::ConfigValue, "connect_password"));
  EXPECT_THAT(grbl("probe_from_mm = -10\n"), FailsWith(Code::ConfigValue, "probe_"));
  const std::string probe = "probe_feed_mm_min = 40\nprobe_z0_mm = -15\n";
  EXPECT_THAT(grbl(probe + "probe_from_mm = -10\nprobe_to_mm = -10\n"),
              FailsWith(Code::ConfigValue, "probe_to_mm"));
  EXPECT_THAT(grbl(probe + "probe_from_mm = -1\nprobe_to_mm = -10\n"),
              FailsWith(Code::ConfigValue, "probe_from_mm"));
  EXPECT_THAT(machine("driver = \"grbl\"\nhost = \"mill\"\n"),
              FailsWith(Code::ConfigValue, "safe_z_mm"));
  EXPECT_THAT(machine("driver = \"linuxcnc\"\nsafe_z_mm = 0\ndevice = \"/dev/ttyS0\"\n"),
              FailsWith(Code::ConfigValue, "device"));
  EXPECT_THAT(machine("safe_z_mm = 0\n"), FailsWith(Code::ConfigValue, "driver"));
  EXPECT_THAT(machine("driver = \"marlin\"\n"), FailsWith(Code::ConfigValue, "marlin"));
}

}  // namespace
}  // namespace panelcal
