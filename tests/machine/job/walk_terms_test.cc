// SPDX-License-Identifier: Apache-2.0
#include "machine/job/walk_terms.h"

#include <chrono>

#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using namespace std::chrono_literals;
using test::FailsWith;

constexpr std::chrono::sys_seconds kFound = std::chrono::sys_days{2026y / 11 / 21};

/// 4 um after sixteen days.
MachineConfig drifting_machine() {
  MachineConfig machine;
  machine.offset_date = OffsetDate{.date = kFound, .place = {}, .is_utc = true};
  machine.drift_um_per_sqrt_day = 1;
  return machine;
}

WalkTerms terms() {
  return {.program = "there/job.sm",
          .clock = "",
          .now = kFound + std::chrono::days(16),
          .max_operations = 77,
          .reading = ReadingTerms{.accepts_unterminated = true, .format = {}}};
}

TEST(WalkTerms, SetWhatEveryWalkOfThatDayNeeds) {
  MachineConfig machine = drifting_machine();
  const auto time = set_walk_terms(terms(), machine);
  ASSERT_TRUE(time) << time.error().text();
  EXPECT_EQ(time->substr(0, 7), "2026-12");
  EXPECT_EQ(machine.walk.max_operations, 77);
  EXPECT_TRUE(machine.reading.accepts_unterminated);
  EXPECT_NEAR(machine.walk.uncertainty.drift_mm2(0, 0), 16e-6, 1e-12);
}

TEST(WalkTerms, ANamedTimeCountsForTextsAndForTheOffset) {
  MachineConfig machine = drifting_machine();
  WalkTerms named = terms();
  named.clock = "2027-01-02T03:04:05";
  EXPECT_EQ(set_walk_terms(named, machine).value_or(""), named.clock);
  EXPECT_GT(machine.walk.uncertainty.drift_mm2(0, 0), 41e-6);
  EXPECT_EQ(machine.walk.sieb_meyer.text.file, "job");
  EXPECT_EQ(machine.walk.sieb_meyer.text.extension, "sm");
  EXPECT_EQ(machine.walk.sieb_meyer.text.date, "02/01/2027");
  EXPECT_EQ(machine.walk.sieb_meyer.text.time, "03:04:05");
  named.clock = "2026-01-02T03:04:05";
  MachineConfig young = drifting_machine();
  EXPECT_THAT(set_walk_terms(named, young), FailsWith(Code::ConfigValue));
  named.clock = "yesterday";
  EXPECT_THAT(set_walk_terms(named, young), FailsWith(Code::Usage, "yesterday"));
}

TEST(WalkTerms, LeaveReadingAsTheMachineHasIt) {
  for (const bool accepts : {false, true}) {
    MachineConfig machine = drifting_machine();
    machine.reading.accepts_unterminated = accepts;
    WalkTerms unsaid = terms();
    unsaid.reading.reset();
    ASSERT_TRUE(set_walk_terms(unsaid, machine));
    EXPECT_EQ(machine.reading.accepts_unterminated, accepts);
  }
}

TEST(WalkTerms, AnOffsetThatIsNotUsedHasNoAge) {
  MachineConfig machine = drifting_machine();
  WalkTerms earlier = terms();
  earlier.now = kFound - std::chrono::days(1);
  earlier.ages_offset = false;
  EXPECT_TRUE(set_walk_terms(earlier, machine));
  EXPECT_EQ(machine.walk.uncertainty.drift_mm2(0, 0), 0);
}

}  // namespace
}  // namespace panelcal
