// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <string_view>

#include "machine/config/machine_config.h"
#include "machine/job/output/output_format.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::Reports;
using testing::HasSubstr;

std::string refusal(std::string_view toml) {
  const auto config = parse_machine_config(toml, "machine.toml");
  return config ? "accepted" : config.error().text();
}

TEST(GcodeConfig, IsEmptyWithoutTheTable) {
  const auto config = parse_machine_config("[gates]\n", "machine.toml");
  ASSERT_TRUE(config);
  EXPECT_FALSE(config->gcode);
}

TEST(GcodeConfig, ReadsEveryKey) {
  const auto config = parse_machine_config(R"(
[gcode]
safe_z_mm = 5
approach_z_mm = 1
change_z_mm = 40
table_z_mm = -1.6
board_z_mm = 0
spin_up_s = 3
length_offset = true
drill_z_mm = -1.8
rout_z_mm = -2
peck_mm = 0.5
infeed_mm_s = 20
retract_mm_s = 100
feed_mm_s = 8
speed_rpm = 30000
[[gcode.tool]]
number = 3
drill_z_mm = -2.5
[[gcode.tool]]
drill_mm = 0.3
infeed_mm_s = 5
speed_rpm = 60000
)",
                                           "machine.toml");
  ASSERT_TRUE(config) << config.error().text();
  ASSERT_TRUE(config->gcode);
  const GcodeSetting& setting = *config->gcode;
  EXPECT_EQ(setting.safe_z, mm(5));
  EXPECT_EQ(setting.approach_z, mm(1));
  EXPECT_EQ(setting.change_z, mm(40));
  EXPECT_EQ(setting.table_z, mm(-1.6));
  EXPECT_EQ(setting.board_z, mm(0));
  EXPECT_EQ(setting.spin_up, seconds(3));
  EXPECT_TRUE(setting.has_length_offset);
  EXPECT_EQ(setting.usual.drill_z, mm(-1.8));
  EXPECT_EQ(setting.usual.rout_z, mm(-2));
  EXPECT_EQ(setting.usual.peck, mm(0.5));
  EXPECT_EQ(setting.usual.infeed, mm_per_s(20));
  EXPECT_EQ(setting.usual.retract, mm_per_s(100));
  EXPECT_EQ(setting.usual.feed, mm_per_s(8));
  EXPECT_EQ(setting.usual.speed, rpm(30'000));
  EXPECT_EQ(setting.work_of({.number = 3}).drill_z, mm(-2.5));
  EXPECT_EQ(setting.work_of({.number = 1, .diameter = mm(0.3)}).infeed, mm_per_s(5));
}

TEST(GcodeConfig, OnlyTheSafeHeightIsRequired) {
  EXPECT_EQ(refusal("[gcode]\nsafe_z_mm = 5\n"), "accepted");
  EXPECT_THAT(refusal("[gcode]\ndrill_z_mm = -1\n"), HasSubstr("safe_z_mm"));
}

TEST(GcodeConfig, TheFlavourIsThatOfTheKeyThenOfTheControlThenLinuxCncs) {
  const auto flavour = [](const std::string& text) {
    const auto config = parse_machine_config(text, "machine.toml");
    return config ? std::string(name(gcode_flavour(*config))) : config.error().text();
  };
  const std::string control = "[machine]\ndriver = \"grbl\"\nhost = \"cnc\"\nsafe_z_mm = -1\n";
  const std::string gcode = "[gcode]\nsafe_z_mm = 5\n";
  EXPECT_EQ(flavour(gcode), "linuxcnc");
  EXPECT_EQ(flavour(control + gcode), "grbl");
  EXPECT_EQ(flavour(control + gcode + "flavour = \"marlin\"\n"), "marlin");
  EXPECT_THAT(flavour(gcode + "flavour = \"mach3\"\n"), HasSubstr("\"grbl\" or \"marlin\""));
}

TEST(GcodeConfig, AFlavourNeedsWhatItsControlNeeds) {
  const auto ready = [](const std::string& keys) {
    const auto config = parse_machine_config("[gcode]\nsafe_z_mm = 5\n" + keys, "machine.toml");
    if (!config) return config.error().text();
    const auto done = check_output_format(OutputFormat::Gcode, *config);
    return done ? std::string("ready") : done.error().text();
  };
  EXPECT_EQ(ready("flavour = \"grbl\"\n"), "ready");
  EXPECT_EQ(ready("length_offset = true\n"), "ready");
  EXPECT_THAT(ready("flavour = \"grbl\"\nlength_offset = true\n"), HasSubstr("G43"));
  EXPECT_THAT(ready("flavour = \"marlin\"\n"), HasSubstr("rapid_mm_s"));
  EXPECT_EQ(ready("flavour = \"marlin\"\nrapid_mm_s = 50\n"), "ready");
}

TEST(GcodeConfig, HeightsAreInOrder) {
  const std::string safe = "[gcode]\nsafe_z_mm = 5\n";
  EXPECT_THAT(
      refusal(safe + "approach_z_mm = 5.1\n"),
      Reports("machine.toml:3:17: error[config-value]", "approach_z_mm", "5.1", "safe_z_mm"));
  EXPECT_EQ(refusal(safe + "approach_z_mm = 5\n"), "accepted");
  EXPECT_THAT(refusal(safe + "change_z_mm = 4\n"), HasSubstr("safe_z_mm"));
  for (const std::string key : {"drill_z_mm", "rout_z_mm", "board_z_mm", "table_z_mm"}) {
    EXPECT_THAT(refusal(safe + key + " = 5\n"), HasSubstr("safe_z_mm (5)"));
    EXPECT_THAT(refusal(safe + "approach_z_mm = 1\n" + key + " = 1\n"),
                HasSubstr("approach_z_mm (1)"));
  }
  EXPECT_THAT(refusal(safe + "[[gcode.tool]]\nnumber = 1\nrout_z_mm = 6\n"),
              HasSubstr("safe_z_mm (5)"));
}

TEST(GcodeConfig, NumbersMakeSense) {
  const std::string safe = "[gcode]\nsafe_z_mm = 5\n";
  for (const std::string key :
       {"peck_mm", "infeed_mm_s", "retract_mm_s", "feed_mm_s", "speed_rpm"}) {
    EXPECT_THAT(refusal(safe + key + " = 0\n"), HasSubstr("error[config-value]")) << key;
  }
  EXPECT_THAT(refusal(safe + "spin_up_s = -1\n"), HasSubstr("error[config-value]"));
  EXPECT_THAT(refusal("[gcode]\nsafe_z_mm = nan\n"), HasSubstr("error[config-value]"));
  EXPECT_THAT(refusal(safe + "dril_z_mm = 1\n"), HasSubstr("error[config-key-unknown]"));
}

TEST(GcodeConfig, EachToolOnce) {
  const std::string safe = "[gcode]\nsafe_z_mm = 5\n";
  const std::string by_number = "[[gcode.tool]]\nnumber = 1\nspeed_rpm = 1000\n";
  const std::string by_drill = "[[gcode.tool]]\ndrill_mm = 0.8\nspeed_rpm = 1000\n";
  EXPECT_EQ(refusal(safe + by_number + by_drill), "accepted");
  EXPECT_THAT(refusal(safe + by_number + by_number), HasSubstr("error[config-value]"));
  EXPECT_THAT(refusal(safe + by_drill + by_drill), HasSubstr("error[config-value]"));
  EXPECT_THAT(refusal(safe + "[[gcode.tool]]\nspeed_rpm = 1000\n"), HasSubstr("number"));
  EXPECT_THAT(refusal(safe + "[[gcode.tool]]\nnumber = 1\ndrill_mm = 1\nspeed_rpm = 1000\n"),
              HasSubstr("error[config-value]"));
  EXPECT_THAT(refusal(safe + "[[gcode.tool]]\nnumber = 1\n"), HasSubstr("drill_z_mm"));
}

}  // namespace
}  // namespace panelcal
