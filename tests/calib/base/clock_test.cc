// SPDX-License-Identifier: Apache-2.0
#include "calib/base/clock.h"

#include <gtest/gtest.h>

namespace panelcal {
namespace {

using std::chrono::sys_days;
using std::chrono::sys_seconds;
using std::chrono::year;

TEST(Clock, FixedClockStandsStill) {
  const sys_seconds time(std::chrono::seconds(1234567));
  const Clock clock = fixed_clock(time);
  EXPECT_EQ(clock(), time);
  EXPECT_EQ(clock(), time);
}

TEST(Clock, SystemClockTellsARecentTime) {
  EXPECT_GT(system_clock()(), sys_days(year(2020) / 1 / 1));
}

TEST(Clock, PrintsIso8601) {
  EXPECT_EQ(iso_8601(sys_seconds()), "1970-01-01T00:00:00Z");
  EXPECT_EQ(iso_8601(sys_days(year(2026) / 11 / 21) + std::chrono::seconds(31058)),
            "2026-11-21T08:37:38Z");
  EXPECT_EQ(iso_8601(sys_days(year(2024) / 2 / 29) + std::chrono::seconds(86399)),
            "2024-02-29T23:59:59Z");
  EXPECT_EQ(iso_8601(sys_seconds(std::chrono::seconds(-1))), "1969-12-31T23:59:59Z");
}

TEST(Clock, ReadsBackWhatItPrints) {
  for (const long long s : {0LL, -1LL, 951782400LL, 1795250258LL, 253402300799LL}) {
    const sys_seconds time{std::chrono::seconds(s)};
    EXPECT_EQ(from_iso_8601(iso_8601(time)), time) << iso_8601(time);
  }
}

TEST(Clock, RefusesOtherTexts) {
  for (const char* text : {"",
                           "2026-11-21",
                           "2026-11-21 08:37:38Z",
                           "2026-11-21T08:37:38",
                           "2026-11-21T08:37:38z",
                           "2026-11-21T08:37:38Z ",
                           "2026-1a-21T08:37:38Z",
                           "2026-13-01T00:00:00Z",
                           "2026-00-01T00:00:00Z",
                           "2025-02-29T00:00:00Z",
                           "2026-11-21T24:00:00Z",
                           "2026-11-21T08:60:00Z",
                           "2026-11-21T08:37:60Z",
                           "-026-11-21T08:37:38Z"}) {
    EXPECT_EQ(from_iso_8601(text), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace panelcal
