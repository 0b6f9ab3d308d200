// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/spindle/coupon.h"

#include <filesystem>
#include <string>

#include "calib/base/files/atomic_file.h"
#include "calib/ledger/ledger.h"
#include "machine/config/machine_config.h"
#include <gmock/gmock.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::HasSubstr;

/// Reads [coupon] of a machine.toml in the folder "there".
Expected<std::optional<Coupon>> parse(std::string_view text) {
  PANELCAL_TRY(const MachineConfig config, parse_machine_config(text, "there/machine.toml"));
  return config.coupon;
}

std::string refusal(std::string_view text) {
  const auto coupon = parse(text);
  return coupon ? "accepted" : coupon.error().text();
}

MachineConfig machine_in(const test::TemporaryFolder& folder) {
  MachineConfig config;
  Coupon& coupon = config.coupon.emplace();
  coupon.name = "A";
  coupon.rows = 7;
  coupon.state_file = folder.path() / "coupon.json";
  coupon.place = {"machine.toml", 3, 1};
  return config;
}

TakenBy timer() {
  return {fixed_clock(*from_iso_8601("2026-11-21T02:00:00Z")), "timer", "panelcal test"};
}

TEST(Coupon, ReadsEveryKey) {
  const auto coupon = parse(R"([coupon]
name = "A"
origin_mm = [300, 12.5]
columns = 4
rows = 20
rows_per_run = 2
pitch_mm = 2.54
drill_tool = 3
vision_tool = 9
entry_material = true
drill_approach = "-x+y"
approaches = ["+x+y", "-y"]
approach_mm = 0.5
state = "used.json"
)");
  ASSERT_TRUE(coupon && *coupon) << coupon.error().text();
  const Coupon& c = **coupon;
  EXPECT_EQ(c.name, "A");
  EXPECT_EQ(c.origin, position_mm<frame::Machine>(300, 12.5));
  EXPECT_EQ(c.columns, 4);
  EXPECT_EQ(c.rows, 20);
  EXPECT_EQ(c.rows_per_run, 2);
  EXPECT_EQ(c.pitch, mm(2.54));
  EXPECT_EQ(c.drill_tool, 3);
  EXPECT_EQ(c.vision_tool, 9);
  EXPECT_TRUE(c.has_entry_material);
  EXPECT_EQ(c.drilling, (Approach{-1, 1}));
  EXPECT_THAT(c.looking, testing::ElementsAre(Approach{1, 1}, Approach{0, -1}));
  EXPECT_EQ(c.approach_distance, mm(0.5));
  EXPECT_EQ(c.state_file, std::filesystem::path("there/used.json"));
  EXPECT_EQ(c.place.line, 1);
}

TEST(Coupon, IsNoneUnlessStatedAndNineHolesUnlessSaid) {
  EXPECT_FALSE(*parse(""));
  const auto coupon = parse("[coupon]\norigin_mm = [0, 0]\n");
  ASSERT_TRUE(coupon && *coupon);
  EXPECT_EQ(places_of_row(**coupon, 0).size(), 9u);
  // Backlash shows in looks from several sides.
  EXPECT_EQ((*coupon)->looking.size(), 4u);
}

TEST(Coupon, RefusesWhatMakesNoSense) {
  const std::string sound = "[coupon]\norigin_mm = [0, 0]\n";
  EXPECT_THAT(refusal("[coupon]\n"), HasSubstr("origin_mm"));
  EXPECT_THAT(refusal(sound + "pitch_m = 1\n"), HasSubstr("\"pitch_mm\""));
  EXPECT_THAT(refusal(sound + "pitch_mm = 0\n"), HasSubstr("machine.toml:3:"));
  EXPECT_THAT(refusal(sound + "pitch_mm = nan\n"), HasSubstr("machine.toml:3:"));
  EXPECT_THAT(refusal(sound + "columns = 0\n"), HasSubstr("machine.toml:3:"));
  EXPECT_THAT(refusal(sound + "rows = 2\nrows_per_run = 3\n"), HasSubstr("2 rows"));
  EXPECT_THAT(refusal(sound + "columns = 1\nrows_per_run = 2\n"), HasSubstr("machine.toml:"));
  EXPECT_THAT(refusal(sound + "approaches = []\n"), HasSubstr("1 to 64"));
  EXPECT_THAT(refusal(sound + "approaches = [\"x\"]\n"), HasSubstr("\"+x+y\""));
  EXPECT_THAT(refusal(sound + "drill_approach = \"\"\n"), HasSubstr("\"+x+y\""));
  EXPECT_THAT(refusal(sound + "state = \"\"\n"), HasSubstr("machine.toml:3:"));
  EXPECT_THAT(refusal(sound + "name = \"\"\n"), HasSubstr("machine.toml:3:"));
}

TEST(Coupon, RunsGoToAndFroUpTheRows) {
  Coupon coupon;
  coupon.origin = position_mm<frame::Machine>(100, 50);
  coupon.columns = 2;
  coupon.rows_per_run = 2;
  coupon.pitch = mm(3);
  EXPECT_THAT(places_of_row(coupon, 4),
              testing::ElementsAre(position_mm<frame::Machine>(100, 62),
                                   position_mm<frame::Machine>(103, 62),
                                   position_mm<frame::Machine>(103, 65),
                                   position_mm<frame::Machine>(100, 65)));
  // G39's coordinate is the first hole's place.
  EXPECT_EQ(places_from(coupon, position_mm<frame::Machine>(7, 8)).front(),
            position_mm<frame::Machine>(7, 8));
}

TEST(Coupon, RowsAreTakenOnceAndThenItIsFull) {
  const test::TemporaryFolder folder;
  const MachineConfig config = machine_in(folder);
  EXPECT_EQ(used_rows(config)->count(), 0);
  EXPECT_EQ(free_rows_text(*config.coupon, 0),
            "rows 1 to 7 of coupon \"A\" are free (7 of 7): 2 runs of 3 rows");
  EXPECT_EQ(*take_rows(config, {}), 0);
  EXPECT_EQ(*take_rows(config, {}), 3);
  EXPECT_EQ(used_rows(config)->count(), 6);
  EXPECT_THAT(take_rows(config, {}), FailsWith(Code::ConfigValue, "7"));
  EXPECT_EQ(used_rows(config)->count(), 6);
  EXPECT_EQ(free_rows_text(*config.coupon, 7), "all 7 rows of coupon \"A\" are used up");
}

TEST(Coupon, AnotherNameIsANewCoupon) {
  const test::TemporaryFolder folder;
  MachineConfig config = machine_in(folder);
  ASSERT_TRUE(take_rows(config, {}));
  config.coupon->name = "B";
  EXPECT_EQ(*take_rows(config, {}), 0);
  EXPECT_EQ(used_rows(config)->count(), 3);
}

/// Its rows are drilled, whatever the state file says.
TEST(Coupon, AStateFileThatIsOlderOrGoneFreesNoRow) {
  const test::TemporaryFolder folder;
  MachineConfig config = machine_in(folder);
  config.ledger_file = folder.path() / "drill 1.ledger";
  ASSERT_EQ(take_rows(config, timer()).value_or(-1), 0);
  const std::string older = read_file(config.coupon->state_file).value();
  EXPECT_EQ(missing_rows_text(*config.coupon, *used_rows(config)), "");
  ASSERT_EQ(take_rows(config, timer()).value_or(-1), 3);
  ASSERT_TRUE(write_file(config.coupon->state_file, older));
  EXPECT_EQ(used_rows(config)->by_file, 3);
  EXPECT_EQ(used_rows(config)->by_ledger, 6);
  EXPECT_EQ(missing_rows_text(*config.coupon, *used_rows(config)),
            "\"coupon.json\" has 3 rows used, the ledger 6: the ledger counts");
  EXPECT_THAT(take_rows(config, timer()), FailsWith(Code::ConfigValue, "7"));
  std::filesystem::remove(config.coupon->state_file);
  EXPECT_EQ(used_rows(config)->count(), 6);
  EXPECT_THAT(take_rows(config, timer()), FailsWith(Code::ConfigValue, "7"));
  config.coupon->rows = 9;
  EXPECT_EQ(take_rows(config, timer()).value_or(-1), 6);
  // The state file knows one coupon, the ledger all.
  config.coupon->name = "B";
  EXPECT_EQ(take_rows(config, timer()).value_or(-1), 0);
  config.coupon->name = "A";
  EXPECT_EQ(used_rows(config)->count(), 9);
}

/// A run that is cut off before its first hole loses rows, and no more.
TEST(Coupon, RowsAreInTheLedgerBeforeTheyAreInTheFile) {
  const test::TemporaryFolder folder;
  MachineConfig config = machine_in(folder);
  config.ledger_file = folder.path() / "drill 1.ledger";
  config.coupon->state_file = folder.path() / "no" / "coupon.json";
  EXPECT_THAT(take_rows(config, timer()), FailsWith(Code::DeviceWrite));
  EXPECT_EQ(used_rows(config)->count(), 3);
  const auto ledger = Ledger::open_to_read(config.ledger_file);
  ASSERT_TRUE(ledger) << ledger.error().text();
  const auto entry = ledger->entry(1);
  ASSERT_TRUE(entry) << entry.error().text();
  EXPECT_EQ(entry->record.key, (LedgerKey{"machine", LedgerKind::Coupon, "A"}));
  EXPECT_EQ(entry->record.asked_by, "timer");
  EXPECT_EQ(iso_8601(entry->time), "2026-11-21T02:00:00Z");
}

TEST(Coupon, TakesNoRowThatTheLedgerCannotRecord) {
  const test::TemporaryFolder folder;
  MachineConfig config = machine_in(folder);
  config.ledger_file = folder.path() / "drill 1.ledger";
  EXPECT_THAT(take_rows(config, {}), FailsWith(Code::LedgerEntryInvalid, "time"));
  ASSERT_TRUE(write_file(config.ledger_file, "SQLite format 3"));
  EXPECT_FALSE(take_rows(config, timer()));
  EXPECT_FALSE(std::filesystem::exists(config.coupon->state_file));
}

TEST(Coupon, DoesNotGuessWhichRowsAreFree) {
  const test::TemporaryFolder folder;
  const MachineConfig config = machine_in(folder);
  const std::filesystem::path& state = config.coupon->state_file;
  ASSERT_TRUE(write_file(state, "{\"kind\": \"coupon\", \"vers"));
  EXPECT_THAT(take_rows(config, {}), FailsWith(Code::JsonSyntax, "coupon.json"));
  ASSERT_TRUE(write_file(
      state, "{\"kind\": \"coupon\", \"version\": 1, \"coupon\": \"A\", \"rows_used\": -1}"));
  EXPECT_THAT(take_rows(config, {}), FailsWith(Code::CalibrationInvalid, "rows_used"));
  std::filesystem::remove(state);
  std::filesystem::create_directory(state);
  EXPECT_THAT(take_rows(config, {}), FailsWith(Code::FileUnreadable));
}

TEST(Coupon, TakesNoRowItCannotWriteDown) {
  MachineConfig config;
  config.coupon.emplace();
  config.coupon->state_file = "/nowhere/at/all/coupon.json";
  EXPECT_THAT(take_rows(config, {}), FailsWith(Code::DeviceWrite));
}

TEST(Coupon, ApproachesReadAsTheyAreWritten) {
  for (const int x : {-1, 0, 1}) {
    for (const int y : {-1, 0, 1}) {
      const Approach approach{x, y};
      if (approach == Approach{}) continue;
      EXPECT_EQ(approach_from_text(text(approach)), approach);
    }
  }
  EXPECT_FALSE(approach_from_text(""));
  EXPECT_FALSE(approach_from_text("+y+x"));
}

}  // namespace
}  // namespace panelcal
