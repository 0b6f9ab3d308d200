// SPDX-License-Identifier: Apache-2.0
// Nights that probe the table's own surface.

#include "tests/machine/calibrate/kinds/surface_night.h"

#include <array>
#include <optional>
#include <string>

#include "machine/calibrate/surface/record.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::Contains;
using testing::HasSubstr;

using SurfaceNights = test::SurfaceNights;

const NightGate* gate(const NightStep& step, std::string_view words) {
  if (!step.decision) return nullptr;
  for (const NightGate& one : step.decision->gates) {
    if (one.text.find(words) != std::string::npos) return &one;
  }
  return nullptr;
}

TEST_F(SurfaceNights, MeasureAndInstallWhatIsThere) {
  const NightRecord record = run();
  ASSERT_EQ(exit_code(record), 0) << record.verdict;
  const NightStep& step = record.steps.at(0);
  EXPECT_EQ(step.kind, "surface");
  EXPECT_EQ(step.subject, "table");
  // By hand: the middle of the area is (200, 150), the bow's; its half sides are 100 mm.
  const std::array<double, 6> expected_mm = {
      0.2 + 80e-6 * 200 - 30e-6 * 150, 80e-6 * 100, -30e-6 * 100, 0.020 / 2.25, 0.020 / 2.25, 0};
  for (std::size_t i = 0; i < expected_mm.size(); ++i) {
    const NightAxis& axis = step.axes.at(i);
    ASSERT_TRUE(axis.new_value && axis.new_sigma) << axis.name;
    EXPECT_NEAR(*axis.new_value, expected_mm.at(i), 4 * *axis.new_sigma) << axis.name;
    EXPECT_LT(*axis.new_sigma, 0.003) << axis.name;
    EXPECT_GT(*axis.new_sigma, 0.0002) << axis.name;
  }
  const auto installed = read_map_file(file());
  ASSERT_TRUE(installed) << installed.error().text();
  EXPECT_EQ(installed->points.size(), 30U);
  const auto ledger = Ledger::open_to_read(ledger_file());
  ASSERT_TRUE(ledger);
  EXPECT_EQ(*ledger->result(*step.ledger_id), text());
  const auto figures = figures_of(*ledger->entry(*step.ledger_id));
  ASSERT_TRUE(figures);
  EXPECT_EQ(figures->value_mm[0], *step.axes[0].new_value);
}

TEST_F(SurfaceNights, ATiltBeyondItsLimitIsRefusedAndSaid) {
  surface += "tilt_um = 20\n";
  run();
  const std::string before = text();
  // Corners 40 um up and down.
  truth.surface.slope_x_ppm += 400;
  const NightRecord record = run();
  EXPECT_EQ(exit_code(record), 1);
  EXPECT_FALSE(record.may_drill);
  const NightGate* const tilt = gate(record.steps[0], "tilt has moved the corners by 4");
  ASSERT_TRUE(tilt) << record.verdict;
  EXPECT_FALSE(tilt->passed);
  EXPECT_THAT(tilt->text, HasSubstr("more than probes scatter (chance "));
  EXPECT_THAT(tilt->text, HasSubstr("limit 20.0 um"));
  EXPECT_EQ(text(), before);
}

TEST_F(SurfaceNights, WhatProbesScatterIsNoChange) {
  run();
  const NightRecord record = run();
  EXPECT_EQ(exit_code(record), 0) << record.verdict;
  for (const char* words : {"the middle", "tilt", "bow and twist", "moved most at"}) {
    const NightGate* const found = gate(record.steps[0], words);
    ASSERT_TRUE(found) << words;
    EXPECT_TRUE(found->passed) << found->text;
    EXPECT_THAT(found->text, HasSubstr("as probes scatter")) << found->text;
  }
}

TEST_F(SurfaceNights, AChipIsNamedAndOnceAcceptedKnown) {
  run();
  // At column 2 row 1.
  truth.chip = {position_mm<frame::Actual>(180, 100), mm(8), um(300)};
  NightRecord record = run();
  EXPECT_EQ(exit_code(record), 1);
  EXPECT_THAT(record.verdict, HasSubstr("the probe at column 2 row 1"));
  EXPECT_THAT(record.steps[0].fit_report, Contains(HasSubstr("left out: column 2 row 1 is 0.")));
  // A person has looked at it and takes that map.
  {
    auto ledger = Ledger::open(ledger_file(), [this] { return now; });
    ASSERT_TRUE(ledger);
    const auto result = ledger->result(*record.steps[0].ledger_id);
    auto entry = ledger->entry(*record.steps[0].ledger_id);
    ASSERT_TRUE(result && entry);
    LedgerDraft draft;
    draft.record = entry->record;
    draft.record.verdict = LedgerVerdict::Installed;
    draft.record.replaces.reset();
    draft.result = *result;
    ASSERT_TRUE(ledger->append(draft));
    ASSERT_TRUE(write_file(file(), *result));
  }
  record = run();
  EXPECT_EQ(exit_code(record), 0) << record.verdict;
  // It grows.
  truth.chip->depth = um(420);
  record = run();
  EXPECT_EQ(exit_code(record), 1);
  EXPECT_THAT(record.verdict, HasSubstr("the probe at column 2 row 1"));
}

TEST_F(SurfaceNights, AProbeThatIsTooBadIsRefused) {
  surface += "sigma_um = 2\n";
  truth.surface.noise_sigma = um(15);
  const NightRecord record = run();
  EXPECT_EQ(exit_code(record), 1);
  EXPECT_THAT(record.verdict, HasSubstr("sigma of the map is up to"));
  EXPECT_FALSE(std::filesystem::exists(file()));
}

TEST_F(SurfaceNights, WritesAgainWhatWasTakenAway) {
  run();
  std::filesystem::remove(file());
  NightRecord record = run();
  EXPECT_EQ(exit_code(record), 0) << record.verdict;
  EXPECT_THAT(record.notes, Contains(HasSubstr("written again from the ledger")));
  ASSERT_TRUE(write_file(file(), "{\"kind\": \"surf"));
  record = run();
  EXPECT_EQ(exit_code(record), 0) << record.verdict;
  EXPECT_TRUE(read_map_file(file()));
}

TEST_F(SurfaceNights, AMapThatAPersonPutThereIsNotLost) {
  run();
  auto by_hand = read_map_file(file());
  ASSERT_TRUE(by_hand);
  by_hand->made_by = "a person";
  const std::string mine = map_file_text(*by_hand);
  ASSERT_TRUE(write_file(file(), mine));
  const NightRecord record = run();
  EXPECT_EQ(exit_code(record), 1);
  EXPECT_THAT(record.verdict, HasSubstr("a map is not in the ledger"));
  EXPECT_EQ(text(), mine);
}

TEST_F(SurfaceNights, RolledBackTheMapBeforeIsThereAgain) {
  run();
  const std::string first = text();
  run();
  ASSERT_NE(text(), first);
  {
    auto ledger = Ledger::open(ledger_file(), [this] { return now; });
    ASSERT_TRUE(ledger);
    const LedgerKey key = {"drill 1", LedgerKind::Surface, "table"};
    ASSERT_TRUE(ledger->roll_back({key, std::nullopt, "a swarf", "test", "panelcal test"}));
  }
  now -= std::chrono::days(1);
  const auto again = try_run();
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_THAT(again->notes, Contains(HasSubstr("written again from the ledger")));
  EXPECT_EQ(text(), first);
}

TEST_F(SurfaceNights, FiguresOfAnotherAreaDoNotCompare) {
  run();
  area = "low_mm = [120, 50]\nhigh_mm = [300, 250]\n";
  const NightRecord record = run();
  // The maps do; by their figures the night is a first one.
  EXPECT_EQ(record.steps.at(0).series.size(), 1U);
  EXPECT_EQ(exit_code(record), 0) << record.verdict;
}

TEST_F(SurfaceNights, AnUnchangedTableIsQuietAndATiltThatGrowsIsSaid) {
  surface = "columns = 4\nrows = 4\n";
  constexpr int kQuiet = 20;  // six more than it takes to judge
  for (int night = 0; night < kQuiet; ++night) {
    const NightRecord record = run();
    ASSERT_EQ(exit_code(record), 0) << night << ": " << record.verdict;
    ASSERT_THAT(record.steps[0].alarms, testing::IsEmpty()) << night;
  }
  EXPECT_NE(run().steps[0].forecast->answer, DrillAnswer::NotEnoughHistory);
  truth.since = now;
  truth.slope_ppm_per_day = {20, 0};  // 2 um a day at the edge
  std::string alarm;
  for (int night = 0; night < 15 && alarm.empty(); ++night) {
    const NightRecord record = run();
    for (const std::string& text : record.steps[0].alarms) alarm += text;
    if (exit_code(record) != 0) alarm += record.verdict;
  }
  EXPECT_THAT(alarm, testing::Not(testing::IsEmpty()));
}

TEST_F(SurfaceNights, ADryRunProbesNothing) {
  const auto record = try_run(true);
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(record->steps.at(0).state, NightState::WouldRun);
  EXPECT_FALSE(std::filesystem::exists(file()));
  EXPECT_FALSE(std::filesystem::exists(ledger_file()));
}

TEST_F(SurfaceNights, AreRefusedWithoutAProbe) {
  has_probe = false;
  const auto record = try_run();
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_THAT(record->verdict, HasSubstr("this machine has no probe"));
}

TEST_F(SurfaceNights, AreRefusedBeyondTheTravel) {
  area = "low_mm = [100, 50]\nhigh_mm = [700, 250]\n";
  EXPECT_THAT(try_run(), FailsWith(Code::ConfigValue, "(700, 250)"));
}

TEST(SurfaceNightConfig, NamesWhatIsWrong) {
  const auto config = [](std::string_view surface, std::string_view machine) {
    return parse_machine_config(
        fmt::format(
            "[machine]\nstage_command = [\"s\", \"{{x}}\", \"{{y}}\"]\n{}\n[ledger]\nfile = "
            "\"l\"\n[nightly]\ncamera = \"gige://a\"\ncalibrate = [\"surface\"]\n{}",
            machine,
            surface),
        "machine.toml");
  };
  const std::string table = "[nightly.surface]\nfile = \"m.json\"\n";
  const std::string area = table + "low_mm = [0, 0]\nhigh_mm = [100, 60]\n";
  EXPECT_THAT(config("", ""), FailsWith(Code::ConfigValue));
  EXPECT_THAT(config("[nightly.surface]\n", ""), FailsWith(Code::ConfigValue, "file"));
  EXPECT_THAT(config(table, ""), FailsWith(Code::ConfigValue, "low_mm"));
  EXPECT_THAT(config(table + "low_mm = [0, 0]\nhigh_mm = [0, 60]\n", ""),
              FailsWith(Code::ConfigValue, "high_mm"));
  EXPECT_THAT(config(area, ""), FailsWith(Code::ConfigValue, "columns"));
  EXPECT_THAT(config(area + "columns = 3\nrows = 5\n", ""),
              FailsWith(Code::ConfigValue, "columns"));
  EXPECT_THAT(config(area + "columns = 5\nspacing_mm = 10\n", ""),
              FailsWith(Code::ConfigValue, "spacing_mm"));
  EXPECT_THAT(config(area + "spacing_mm = 0.1\n", ""), FailsWith(Code::ConfigValue, "spacing_mm"));
  EXPECT_THAT(config(area + "spacing_mm = 20\ntilt_um = 0\n", ""),
              FailsWith(Code::ConfigValue, "tilt_um"));
  EXPECT_THAT(config(area + "spacing_mm = 20\ntylt_um = 3\n", ""),
              FailsWith(Code::ConfigKeyUnknown, "tylt_um"));
  const auto made = config(area + "spacing_mm = 20\n", "");
  ASSERT_TRUE(made) << made.error().text();
  EXPECT_EQ(made->nightly->surface.n_columns, 6);
  EXPECT_EQ(made->nightly->surface.n_rows, 4);
  test::OnlyProbe none;
  EXPECT_THAT(run_nightly({*made,
                           *made->nightly,
                           {none, none, none, {}, {}},
                           [] { return std::chrono::sys_seconds(); },
                           "panelcal test",
                           "timer"}),
              FailsWith(Code::ConfigValue));
}

}  // namespace
}  // namespace panelcal
