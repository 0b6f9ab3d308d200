// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/grbl/report.h"

#include "machine/devices/controls/grbl/words.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::grbl {
namespace {

// Lines of the public descriptions of GRBL 1.1, grblHAL and FluidNC.
TEST(GrblReport, ReadsStateAndPlace) {
  const auto report = parse_report("<Hold:1|MPos:5.529,0.560,7.000|FS:0,0|Pn:PZ|WCO:1,2,3>");
  ASSERT_TRUE(report);
  EXPECT_EQ(report->state, "Hold:1");
  EXPECT_TRUE(report->is("Hold"));
  EXPECT_EQ(*report->machine, Eigen::Vector3d(5.529, 0.56, 7));
  EXPECT_EQ(*report->offset, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(report->is_probe_tripped);
  EXPECT_FALSE(report->is_homed);
}

TEST(GrblReport, ReadsMoreAxesAndGrblHal) {
  const auto report = parse_report("<Idle|WPos:1.000,2.000,3.000,4.000|Bf:100,1023|H:0,0|Pn:O>");
  ASSERT_TRUE(report);
  EXPECT_EQ(*report->work, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(report->is_homed, false);
  EXPECT_FALSE(report->is_probe_known);
}

TEST(GrblReport, TakesNoDamagedLine) {
  for (const char* const line : {"",
                                 "<>",
                                 "<Idle>",
                                 "<Idle|MPos:1.0,2.0>",
                                 "<Idle|MPos:1.0,2.0,x>",
                                 "<Idle|MPos:1.0,2.0,3.0",
                                 "<Id le|MPos:1.0,2.0,3.0>",
                                 "<Idle|MPos:1e9,2.0,3.0>",
                                 "<Idle|MPos:nan,2.0,3.0>",
                                 "<Idle|MPos:1.0,2.0,3.0|WCO:1.0>",
                                 "Idle|MPos:1.0,2.0,3.0"}) {
    EXPECT_FALSE(parse_report(line)) << line;
  }
}

TEST(GrblReport, ReadsTouches) {
  const auto touch = parse_touch("[PRB:151.000,149.000,-137.505:1]");
  ASSERT_TRUE(touch);
  EXPECT_EQ(touch->machine.z(), -137.505);
  EXPECT_TRUE(touch->is_touched);
  EXPECT_FALSE(parse_touch("[PRB:0.000,0.000,0.000:0]")->is_touched);
  EXPECT_FALSE(parse_touch("[PRB:0.000,0.000,0.000]"));
  EXPECT_FALSE(parse_touch("[PRB:0.000,0.000:1]"));
  EXPECT_FALSE(parse_touch("[G54:0.000,0.000,0.000]"));
}

TEST(GrblReport, KnowsWhoAnswers) {
  Facts facts;
  take_identity({"[VER:1.1h.20190830:]", "[OPT:VZ,15,128]"}, facts);
  EXPECT_EQ(facts.name, "GRBL 1.1h.20190830");
  EXPECT_TRUE(facts.has_forced_origin);
  facts = {};
  take_identity({"[VER:1.1f.20260817:]", "[OPT:VNML+,100,1024,3,0]", "[FIRMWARE:grblHAL]"}, facts);
  EXPECT_EQ(facts.name, "grblHAL 1.1f.20260817");
  EXPECT_FALSE(facts.has_forced_origin);
  facts = {};
  take_identity({"[VER:3.7 FluidNC v3.7.8:]", "[OPT:PHSW]"}, facts);
  EXPECT_EQ(facts.name, "FluidNC v3.7.8");
  EXPECT_EQ(facts.firmware, Firmware::FluidNc);
}

TEST(GrblReport, ReadsSettingsModesAndOffsets) {
  Facts facts;
  take_settings({"$13=1", "$130=200.000", "$20=0 (soft limits, bool)", "$N0=", "$x=1"}, facts);
  EXPECT_TRUE(facts.is_on(13));
  EXPECT_EQ(facts.setting(130), 200);
  EXPECT_EQ(facts.setting(20), 0);
  EXPECT_FALSE(facts.setting(131));
  EXPECT_TRUE(take_modes({"[GC:G0 G55 G17 G21 G90 G94 M5 M9 T0 F0 S0]"}, facts));
  EXPECT_TRUE(facts.has_mode("G55"));
  EXPECT_FALSE(facts.has_mode("G5"));
  take_offsets({"[G54:1.000,0.000,0.000]",
                "[G55:2.000,0.000,0.000]",
                "[G92:0.000,0.000,0.000]",
                "[G28:7.000,0.000,0.000]",
                "[TLO:-1.000]",
                "[PRB:1.000,1.000,1.000:1]"},
               facts);
  EXPECT_THAT(facts.offsets, ::testing::ElementsAre("G55", "tool length"));
  EXPECT_FALSE(take_modes({"ok"}, facts));
}

TEST(GrblWords, SayNumberAndMeaning) {
  EXPECT_EQ(alarm_words("5"), "ALARM:5 (the probe touched nothing on its way)");
  EXPECT_EQ(alarm_words("99"), "ALARM:99");
  EXPECT_EQ(error_words("15"), "error:15 (the place is outside the travel: nothing moved)");
  EXPECT_EQ(state_words("Hold:0"), "in feed hold (Hold:0)");
  EXPECT_EQ(state_words("Alarm:11"), "locked by an alarm, Alarm:11: the machine has to be homed");
  EXPECT_EQ(state_words("Fish"), "in the unknown state Fish");
}

}  // namespace
}  // namespace panelcal::grbl
