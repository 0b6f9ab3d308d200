// SPDX-License-Identifier: Apache-2.0
#include "machine/job/text_variables.h"

#include <chrono>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"
#include "tests/support/time_zone.h"

namespace panelcal {
namespace {

using namespace std::chrono_literals;
using test::TimeZone;

constexpr std::chrono::sys_seconds kNoon = std::chrono::sys_days{2026y / 11 / 21} + 12h;

TEST(WallTime, IsWhatTheCommandLineSays) {
  EXPECT_EQ(wall_time("2026-02-03T04:05:06", kNoon), "2026-02-03T04:05:06");
}

TEST(WallTime, IsNowWhereThisComputerStands) {
  const TimeZone east("EAST-5:30");  // POSIX counts westwards
  EXPECT_EQ(wall_time("", kNoon), "2026-11-21T17:30:00");
}

TEST(WallTime, RefusesWhatNoCalendarHas) {
  for (const std::string_view text : {"2026-02-30T04:05:06",
                                      "2026-11-21",
                                      "2026-11-21 13:45:00",
                                      "2026-11-21T13:45:00Z",
                                      "now"}) {
    const auto time = wall_time(text, kNoon);
    ASSERT_FALSE(time) << text;
    EXPECT_THAT(time.error().text(),
                test::Reports("panelcal: error[usage]", '"' + std::string(text) + '"'));
  }
}

/// "dd/mm/yyyy" and "hh:mm:ss" (SIEB & MEYER manual, M97, Text variables).
TEST(TextVariables, AreInTheManualsForm) {
  sieb_meyer::TextVariables text;
  set_text_variables("jobs/PANEL.V2.SM5", "2026-11-21T13:45:07", text);
  EXPECT_EQ(text.date, "21/11/2026");
  EXPECT_EQ(text.time, "13:45:07");
  EXPECT_EQ(text.file, "PANEL.V2");
  EXPECT_EQ(text.extension, "SM5");
}

TEST(TextVariables, AProgramMayHaveNoExtensionOrNoName) {
  sieb_meyer::TextVariables text;
  set_text_variables("jobs/PANEL", "2026-11-21T13:45:07", text);
  EXPECT_EQ(text.file, "PANEL");
  EXPECT_EQ(text.extension, "");
  sieb_meyer::TextVariables nameless;
  set_text_variables("-", "2026-11-21T13:45:07", nameless);
  EXPECT_EQ(nameless.file, "");
  EXPECT_EQ(nameless.date, "21/11/2026");
}

TEST(TextVariables, OnlyTextsWithTheDateOrTheTimeDependOnTheClock) {
  const auto drills = [](std::string bytes) {
    DiagnosticLog log;
    return drills_the_time(load_program({"p.sm", std::move(bytes)}, log));
  };
  EXPECT_TRUE(drills("%%5000\nX1.Y1.T1M97,LOT &D\n$\nT1D1.\n$\n"));
  EXPECT_TRUE(drills("%%5000\nX1.Y1.T1M98,&T\n$\nT1D1.\n$\n"));
  EXPECT_FALSE(drills("%%5000\nX1.Y1.T1M97,&F\n$\nT1D1.\n$\n"));
  // Another language's comment.
  EXPECT_FALSE(drills("M48\nMETRIC,LZ\nT1C1.0\n%\n; &D\nT1\nX1Y1\nM30\n"));
}

}  // namespace
}  // namespace panelcal
