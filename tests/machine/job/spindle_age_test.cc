// SPDX-License-Identifier: Apache-2.0
#include "machine/job/spindle_age.h"

#include <chrono>

#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/support/time_zone.h"

namespace panelcal {
namespace {

using namespace std::chrono_literals;
using test::FailsWith;
using test::TimeZone;

/// Where the hour from two to three of 25 October 2026 is on the wall twice.
constexpr const char* kBerlin = "CET-1CEST,M3.5.0,M10.5.0/3";
/// 02:45 by summer time.
constexpr std::chrono::sys_seconds kFound = std::chrono::sys_days{2026y / 10 / 25} + 0h + 45min;
/// Half an hour later, 02:15 by winter time.
constexpr std::chrono::sys_seconds kLater = kFound + 30min;

MachineConfig drifting_machine(std::chrono::sys_seconds found, bool is_utc) {
  MachineConfig machine;
  machine.offset_date =
      OffsetDate{.date = found, .place = {"machine.toml", 5, 1}, .is_utc = is_utc};
  machine.drift_um_per_sqrt_day = 1;
  return machine;
}

double drift_um2(const MachineConfig& machine) {
  return 1e6 * machine.walk.uncertainty.drift_mm2(0, 0);
}

TEST(AgeOffset, CountsByUtcWhereTheDateIsKnownSo) {
  const TimeZone berlin(kBerlin);
  MachineConfig machine = drifting_machine(kFound, true);
  ASSERT_TRUE(age_offset(machine, kLater));
  EXPECT_NEAR(drift_um2(machine), 0.5 / 24, 1e-9);
}

TEST(AgeOffset, CountsByTheWallWhereTheDateIsReadFromThere) {
  const TimeZone berlin(kBerlin);
  MachineConfig machine = drifting_machine(std::chrono::sys_days{2026y / 10 / 25} + 2h, false);
  ASSERT_TRUE(age_offset(machine, kLater));
  EXPECT_NEAR(drift_um2(machine), 0.25 / 24, 1e-9);
}

TEST(AgeOffset, CountsByTheWallUpToATimeThatTheCommandLineNames) {
  const TimeZone berlin(kBerlin);
  MachineConfig machine = drifting_machine(kFound, true);
  ASSERT_TRUE(age_offset(machine, "2026-10-26T02:45:00", kLater));
  EXPECT_NEAR(drift_um2(machine), 1, 1e-9);
}

TEST(AgeOffset, RefusesADateInTheFuture) {
  const TimeZone berlin(kBerlin);
  MachineConfig machine = drifting_machine(kFound, true);
  EXPECT_THAT(age_offset(machine, kFound - 1s), FailsWith(Code::ConfigValue));
  EXPECT_THAT(age_offset(machine, "2026-10-25T02:44:59", kLater), FailsWith(Code::ConfigValue));
  EXPECT_EQ(drift_um2(machine), 0);
}

TEST(AgeOffset, LeavesAMachineWithoutADate) {
  MachineConfig machine;
  machine.drift_um_per_sqrt_day = 1;
  ASSERT_TRUE(age_offset(machine, kLater));
  EXPECT_EQ(drift_um2(machine), 0);
}

}  // namespace
}  // namespace panelcal
