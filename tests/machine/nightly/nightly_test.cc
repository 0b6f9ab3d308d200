// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/nightly.h"

#include <array>
#include <fstream>

#include "machine/nightly/record/night_lock.h"
#include <gmock/gmock.h>

#include "tests/machine/nightly/fake_night.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::NightTest;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kEnough = 7;  // nights, for a forecast

class NightlyTest : public NightTest {};

TEST_F(NightlyTest, TheFirstNightInstallsAndSaysThatNobodyCanForetell) {
  const NightRecord record = run();
  EXPECT_EQ(exit_code(record), 0);
  ASSERT_EQ(record.steps.size(), 1u);
  EXPECT_EQ(record.steps[0].state, NightState::Installed);
  EXPECT_EQ(record.steps[0].kind, "spindle-camera");
  EXPECT_FALSE(record.steps[0].axes[0].old_value);
  EXPECT_NEAR(*record.steps[0].axes[0].new_value, 51.2, 0.006);
  EXPECT_TRUE(record.may_drill);
  EXPECT_FALSE(record.drill_until);
  EXPECT_THAT(record.verdict, HasSubstr("too few nights"));
  EXPECT_EQ(record.night, "2026-11-21");
  EXPECT_EQ(file(), in_force());
  EXPECT_NE(file(), "none");
  // Calibration, companion, the night itself.
  EXPECT_EQ(record.head.id, 3);
}

TEST_F(NightlyTest, AFirstNightIsHeldAgainstWhatTheFilesSay) {
  calibration_.present_value = Eigen::Vector2d(51.2, -3.6);
  const NightRecord record = run();
  EXPECT_EQ(record.steps[0].state, NightState::Held);
  EXPECT_EQ(exit_code(record), 1);
  EXPECT_FALSE(record.may_drill);
  EXPECT_EQ(file(), "none");
}

TEST_F(NightlyTest, WithEnoughNightsThereIsAForecast) {
  learn(kEnough);
  const NightRecord record = run();
  EXPECT_TRUE(record.may_drill);
  ASSERT_TRUE(record.steps[0].forecast);
  EXPECT_NE(record.steps[0].forecast->answer, DrillAnswer::NotEnoughHistory);
  EXPECT_THAT(record.steps[0].forecast_text, HasSubstr("yes"));
  EXPECT_TRUE(record.steps[0].axes[0].expected);
  EXPECT_EQ(record.steps[0].series.size(), kEnough + 1u);
  EXPECT_FALSE(record.steps[0].series.back().in_force.empty());
  EXPECT_THAT(record.changes, testing::SizeIs(1));
  EXPECT_THAT(record.changes.at(0), HasSubstr("against a week ago"));
}

TEST_F(NightlyTest, AMovedCameraIsHeldUntilAPersonMarksAFreshStart) {
  learn(kEnough);
  const std::string before = in_force();
  calibration_.machine.offset.x() += 0.040;
  NightRecord record = run();
  EXPECT_EQ(record.steps[0].state, NightState::Held);
  EXPECT_EQ(exit_code(record), 1);
  EXPECT_FALSE(record.may_drill);
  EXPECT_THAT(record.verdict, HasSubstr("do not drill"));
  EXPECT_EQ(in_force(), before);
  EXPECT_EQ(file(), before);
  next_night();
  EXPECT_EQ(run().steps[0].state, NightState::Held);
  fresh_start();
  record = run();
  EXPECT_EQ(record.steps[0].state, NightState::Installed) << record.verdict;
  EXPECT_NE(in_force(), before);
  EXPECT_EQ(file(), in_force());
}

TEST_F(NightlyTest, ABadMeasurementKeepsTheOldOneWhileTheForecastLetsIt) {
  learn(kEnough);
  const std::string before = in_force();
  calibration_.machine.n_outliers = 4;
  const NightRecord record = run();
  EXPECT_EQ(record.steps[0].state, NightState::KeptOld) << record.verdict;
  EXPECT_EQ(exit_code(record), 1);
  EXPECT_TRUE(record.may_drill);
  EXPECT_THAT(record.verdict, HasSubstr("4 holes were left out"));
  EXPECT_EQ(file(), before);
  EXPECT_TRUE(record.steps[0].series.back().is_refused);
}

/// 0 of 9 holes, night after night.
TEST_F(NightlyTest, ABlindCameraIsHeldWhenTheOldCalibrationIsNoLongerTrusted) {
  nightly_.limits.old.tolerance = 1;  // a forecast that would go on for ever
  learn(kEnough);
  const auto last = now_ - std::chrono::days(1);
  calibration_.machine.fails = {
      Code::CalibrationRefused, {"machine.toml", 3, 1}, "0 of 9 holes were seen", "holes"};
  for (int days = 1; days <= 9; ++days) {
    const NightRecord record = run();
    ASSERT_EQ(exit_code(record), 1) << record.verdict;
    const NightStep& step = record.steps.at(0);
    const bool is_trusted = days <= 6;  // of 7, with the day until the next night
    EXPECT_EQ(record.may_drill, is_trusted) << days << ": " << record.verdict;
    EXPECT_EQ(step.state, is_trusted ? NightState::KeptOld : NightState::Held) << days;
    EXPECT_THAT(record.verdict, HasSubstr("0 of 9 holes were seen"));
    EXPECT_THAT(record.verdict, HasSubstr("last measured " + iso_8601(last)));
    if (is_trusted) {
      EXPECT_EQ(record.drill_until, last + std::chrono::days(7)) << days;
    }
    next_night();
  }
  calibration_.machine.fails.reset();
  EXPECT_TRUE(run().may_drill);
}

TEST_F(NightlyTest, ADirtyLensAndAWornDrillAreRefusedOnTheirNight) {
  learn(kEnough);
  const std::string before = in_force();
  calibration_.machine.wander = 0.008;
  NightRecord record = run();
  EXPECT_EQ(record.steps[0].state, NightState::KeptOld) << record.verdict;
  EXPECT_THAT(record.verdict, HasSubstr("holes about the fit"));
  next_night();
  calibration_.machine.wander = 0.003;
  calibration_.machine.contrast = 0.35;
  record = run();
  EXPECT_EQ(record.steps[0].state, NightState::KeptOld) << record.verdict;
  EXPECT_THAT(record.verdict, HasSubstr("contrast"));
  EXPECT_EQ(file(), before);
  next_night();
  calibration_.machine.contrast = 0.5;
  EXPECT_EQ(run().steps[0].state, NightState::Installed);
}

TEST_F(NightlyTest, AFailingDeviceIsSaidAndTheSameNightCanBeFinished) {
  learn(kEnough);
  const std::string before = in_force();
  calibration_.machine.fails = Diagnostic{Code::DeviceStage, {}, "the stage lost its way", ""};
  NightRecord record = run();
  EXPECT_EQ(exit_code(record), 3);
  EXPECT_EQ(record.steps[0].state, NightState::Failed);
  EXPECT_FALSE(record.may_drill);
  EXPECT_THAT(record.verdict, HasSubstr("lost its way"));
  EXPECT_EQ(file(), before);
  calibration_.machine.fails.reset();
  now_ += std::chrono::hours(1);
  record = run();
  EXPECT_EQ(exit_code(record), 0) << record.verdict;
  EXPECT_THAT(record.notes, Contains(HasSubstr("3 rows of the coupon")));
  EXPECT_EQ(file(), in_force());
  EXPECT_NE(file(), before);
}

TEST_F(NightlyTest, WhatOneStepBreaksTheNextDoesNotBegin) {
  test::FakeCalibration second(folder_.path(), 2);
  calibration_.machine.fails = Diagnostic{Code::DeviceFrame, {}, "no picture", ""};
  const std::array<Calibration*, 2> both = {&calibration_, &second};
  const Expected<NightRecord> record = run_nightly(job(), both);
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(record->steps[1].state, NightState::NotReached);
  EXPECT_EQ(second.n_measured, 0);
}

TEST_F(NightlyTest, AnEarlierRunIsShownAsItWas) {
  learn(2);
  const NightStep first = run().steps.at(0);
  const NightStep again = run().steps.at(0);
  EXPECT_TRUE(again.is_from_earlier_run);
  EXPECT_EQ(again.summary, first.summary);
  EXPECT_EQ(again.ledger_id, first.ledger_id);
  EXPECT_EQ(again.axes[0].old_value, first.axes[0].old_value);
  EXPECT_EQ(again.axes[0].new_value, first.axes[0].new_value);
  EXPECT_EQ(again.change, first.change);
  EXPECT_EQ(again.series.size(), first.series.size());
}

TEST_F(NightlyTest, ANightThatIsDoneIsNotDoneAgainUnlessAsked) {
  run();
  const LedgerHead head = *ledger().head();
  now_ += std::chrono::hours(2);
  const NightRecord record = run();
  EXPECT_EQ(calibration_.n_measured, 1);
  EXPECT_TRUE(record.is_resumed);
  EXPECT_TRUE(record.steps[0].is_from_earlier_run);
  EXPECT_EQ(record.steps[0].state, NightState::Installed);
  EXPECT_EQ(exit_code(record), 0);
  EXPECT_EQ(record.head, head);
  NightJob again = job();
  again.is_again = true;
  ASSERT_TRUE(run(again));
  EXPECT_EQ(calibration_.n_measured, 2);
  // The next noon begins another night.
  now_ += std::chrono::hours(12);
  run();
  EXPECT_EQ(calibration_.n_measured, 3);
}

TEST_F(NightlyTest, AnInterruptedInstallationIsMended) {
  run();
  const std::string good = file();
  ASSERT_TRUE(write_file(calibration_.file(), "{\"offset_mm\": [0, 0]}\n"));
  const NightRecord record = run();
  EXPECT_EQ(file(), good);
  EXPECT_THAT(record.notes, Contains(HasSubstr("written again from the ledger")));
}

TEST_F(NightlyTest, WhatAPersonPutThereIsNotWrittenOverButHolds) {
  learn(2);
  ASSERT_TRUE(write_file(calibration_.file(), "{\"by\": \"hand\"}\n"));
  calibration_.in_the_file = "an offset of spindle 1 station 1";
  const int n_measured = calibration_.n_measured;
  for (const bool is_dry_run : {true, false}) {
    NightJob job = this->job();
    job.is_dry_run = is_dry_run;
    const Expected<NightRecord> record = run(job);
    ASSERT_TRUE(record) << record.error().text();
    EXPECT_EQ(record->steps.at(0).state, NightState::Held);
    EXPECT_EQ(exit_code(*record), 1);
    EXPECT_FALSE(record->may_drill);
    EXPECT_THAT(record->verdict, HasSubstr("is not in the ledger"));
  }
  EXPECT_EQ(calibration_.n_measured, n_measured);
  EXPECT_EQ(file(), "{\"by\": \"hand\"}\n");
  // An operator takes it away.
  std::filesystem::remove(calibration_.file());
  calibration_.in_the_file.clear();
  const NightRecord record = run();
  EXPECT_EQ(record.steps.at(0).state, NightState::Installed) << record.verdict;
  EXPECT_EQ(file(), in_force());
}

TEST_F(NightlyTest, ACallerMayHoldTheLockFromBefore) {
  const auto lock = NightLock::take(config_.ledger_file, now_);
  ASSERT_TRUE(lock) << lock.error().text();
  NightJob job = this->job();
  job.lock = &*lock;
  job.notes = {"what was before"};
  const Expected<NightRecord> record = run(job);
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(exit_code(*record), 0);
  EXPECT_THAT(record->notes, Contains("what was before"));
}

TEST_F(NightlyTest, NamesTheLastAlarmUntilAFreshStart) {
  learn(kEnough);
  const auto told = [](const NightRecord& record) { return record.steps.at(0).since_when; };
  NightRecord record;
  for (int night = 0; night < 30 && told(record = run()).empty(); ++night) {
    EXPECT_EQ(exit_code(record), 0) << record.verdict;
    calibration_.machine.offset.x() -= 0.0008;
    next_night();
  }
  EXPECT_THAT(told(record), HasSubstr("x moved by -"));
  EXPECT_THAT(told(record), HasSubstr(record.night));
  const std::string said = told(record);
  next_night();
  EXPECT_EQ(told(run()), said);
  next_night();
  fresh_start();
  EXPECT_EQ(told(run()), "");
}

TEST_F(NightlyTest, WhatIsStillTheSameHasNotChangedSinceLastWeek) {
  learn(1);
  now_ += std::chrono::days(8);
  calibration_.machine.n_outliers = 4;
  const NightRecord record = run();
  EXPECT_NE(record.steps.at(0).state, NightState::Installed);
  ASSERT_EQ(record.changes.size(), 1u);
  EXPECT_THAT(record.changes[0], HasSubstr("(sigma 0"));
}

TEST_F(NightlyTest, ADryRunSaysWhatItWouldDoAndWritesNothing) {
  NightJob dry = job();
  dry.is_dry_run = true;
  ASSERT_TRUE(run(dry));
  EXPECT_THAT(all_files(), IsEmpty());
  learn(kEnough);
  ASSERT_TRUE(write_file(calibration_.file(), "{}"));
  const auto before = all_files();
  const int n_measured = calibration_.n_measured;
  const Expected<NightRecord> record = run(dry);
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(all_files(), before);
  EXPECT_EQ(calibration_.n_measured, n_measured);
  EXPECT_EQ(devices_.n_moves, 0);
  EXPECT_EQ(record->steps[0].state, NightState::WouldRun);
  EXPECT_THAT(record->notes, Contains(HasSubstr("would be written again")));
  EXPECT_TRUE(record->may_drill) << record->verdict;
}

TEST_F(NightlyTest, ASecondRunIsRefusedAndToldWhoRuns) {
  {
    const auto lock = NightLock::take(config_.ledger_file, now_);
    ASSERT_TRUE(lock) << lock.error().text();
    EXPECT_THAT(run(job()), FailsWith(Code::LedgerBusy, "2026-11-21T23:00:00Z"));
  }
  EXPECT_EQ(exit_code(run()), 0);
}

TEST_F(NightlyTest, ADamagedLedgerIsKeptAsideAndNothingInstalledUntilAFreshStart) {
  learn(3);
  const std::string before = file();
  {
    std::fstream disk(config_.ledger_file, std::ios::in | std::ios::out | std::ios::binary);
    disk.seekp(0);
    disk << std::string(4096, 'x');
  }
  NightRecord record = run();
  EXPECT_EQ(record.steps[0].state, NightState::Held) << record.verdict;
  EXPECT_EQ(exit_code(record), 1);
  EXPECT_THAT(record.notes, Contains(HasSubstr("damaged")));
  EXPECT_EQ(file(), before);
  next_night();
  record = run();
  EXPECT_EQ(record.steps[0].state, NightState::Held);
  EXPECT_EQ(file(), before);
  fresh_start();
  record = run();
  EXPECT_EQ(record.steps[0].state, NightState::Installed) << record.verdict;
  EXPECT_EQ(file(), in_force());
}

TEST_F(NightlyTest, AFullDiskStopsTheNightBeforeAnythingMoves) {
  nightly_.min_disk_mb = 1e12;
  nightly_.warm_up = seconds(60);
  const NightRecord record = run();
  EXPECT_EQ(exit_code(record), 3);
  EXPECT_EQ(record.steps[0].state, NightState::NotReached);
  EXPECT_THAT(record.verdict, HasSubstr("MB are free"));
  EXPECT_EQ(calibration_.n_measured, 0);
  EXPECT_EQ(devices_.n_moves, 0);
}

TEST_F(NightlyTest, AStageThatDoesNotMoveStopsTheNight) {
  nightly_.warm_up = seconds(60);
  config_.travel = Travel{position_mm<frame::Machine>(0, 0), position_mm<frame::Machine>(600, 500)};
  devices_.is_broken = true;
  const NightRecord record = run();
  EXPECT_EQ(exit_code(record), 3);
  EXPECT_THAT(record.verdict, HasSubstr("does not answer"));
  EXPECT_EQ(calibration_.n_measured, 0);
}

TEST_F(NightlyTest, WithoutALedgerThereIsNoNight) {
  config_.ledger_file.clear();
  EXPECT_THAT(run(job()), FailsWith(Code::ConfigValue, "[ledger]"));
}

TEST_F(NightlyTest, SomebodyElsesInstallationMeanwhileIsNotOverwritten) {
  run();
  next_night();
  // While the night measures, a person installs another one.
  NightJob meddled = job();
  bool is_first = true;
  meddled.progress = [&](std::string_view line) {
    if (line.find("measuring") == std::string_view::npos || !is_first) return;
    is_first = false;
    Ledger other = ledger();
    LedgerDraft draft;
    draft.record.key = calibration_.key();
    draft.record.verdict = LedgerVerdict::Installed;
    draft.record.asked_by = "operator";
    draft.record.software = "panelcal test";
    draft.record.parameters = {{"offset_x", 51.3, "mm"}, {"offset_y", -3.7, "mm"}};
    draft.record.covariance = 1e-6 * Eigen::Matrix2d::Identity();
    draft.result = "{\"by\": \"hand\"}\n";
    ASSERT_TRUE(other.append(draft));
  };
  const Expected<NightRecord> record = run(meddled);
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_EQ(record->steps[0].state, NightState::Failed);
  EXPECT_EQ(in_force(), "{\"by\": \"hand\"}\n");
}

TEST_F(NightlyTest, AClockThatWasAheadHoldsUntilAPersonHasLooked) {
  learn(kEnough);
  now_ += std::chrono::days(300);
  run();
  now_ -= std::chrono::days(299);
  const std::string before = in_force();
  const int n_measured = calibration_.n_measured;
  NightRecord record = run();
  EXPECT_EQ(record.steps[0].state, NightState::Held);
  EXPECT_FALSE(record.steps[0].forecast);
  EXPECT_FALSE(record.may_drill);
  EXPECT_THAT(record.verdict, HasSubstr("set the clock if it is wrong"));
  EXPECT_EQ(calibration_.n_measured, n_measured);
  EXPECT_EQ(in_force(), before);
  fresh_start();
  record = run();
  EXPECT_EQ(record.steps[0].state, NightState::Installed) << record.verdict;
  EXPECT_TRUE(record.steps[0].forecast);
  next_night();
  record = run();
  EXPECT_EQ(exit_code(record), 0) << record.verdict;
}

TEST_F(NightlyTest, AClockFarAheadIsRefusedBeforeItHoldsTheNightsAfterIt) {
  learn(kEnough);
  const int n_measured = calibration_.n_measured;
  const LedgerHead head = ledger().head().value();
  now_ += std::chrono::days(500);
  EXPECT_THAT(run(job()), FailsWith(Code::LedgerEntryInvalid));
  EXPECT_EQ(calibration_.n_measured, n_measured);
  EXPECT_EQ(ledger().head().value(), head);
  now_ -= std::chrono::days(499);
  EXPECT_EQ(run().steps[0].state, NightState::Installed);
}

TEST_F(NightlyTest, ARollbackIsShownByTheRunsAfterIt) {
  learn(2);
  const NightRecord first = run();
  ASSERT_EQ(first.steps[0].state, NightState::Installed);
  const std::string rolled_back = in_force();
  {
    Ledger ledger = this->ledger();
    const auto back = ledger.roll_back({calibration_.key(), {}, "wrong", "operator", "test"});
    ASSERT_TRUE(back) << back.error().text();
  }
  const NightRecord record = run();
  EXPECT_EQ(record.steps[0].state, NightState::KeptOld);
  EXPECT_THAT(record.steps[0].summary, HasSubstr("rolled back since"));
  EXPECT_EQ(exit_code(record), 1);
  EXPECT_NE(in_force(), rolled_back);
  EXPECT_EQ(file(), in_force());
  EXPECT_TRUE(record.steps[0].series.back().is_refused);
}

TEST_F(NightlyTest, AMoveByHandIsLearnedByTheGateAsByTheForecast) {
  learn(kEnough);
  // A person mounts the camera anew and installs what is found, 40 um away: less than change_um.
  calibration_.machine.offset.x() += 0.040;
  {
    Ledger ledger = this->ledger();
    LedgerDraft draft;
    draft.record.key = calibration_.key();
    draft.record.verdict = LedgerVerdict::Installed;
    draft.record.asked_by = "operator";
    draft.record.software = "panelcal test";
    const Eigen::Vector2d& offset = calibration_.machine.offset;
    draft.record.parameters = {{"offset_x", offset.x(), "mm"}, {"offset_y", offset.y(), "mm"}};
    draft.record.covariance = 1e-6 * Eigen::Matrix2d::Identity();
    draft.result = "{\"by\": \"hand\"}\n";
    ASSERT_TRUE(ledger.append(draft));
  }
  next_night();
  const NightRecord record = run();
  ASSERT_EQ(record.steps[0].state, NightState::Installed) << record.verdict;
  // The move is no drift: what is predicted stays as sure as it was, not tens of um.
  ASSERT_TRUE(record.steps[0].axes[0].expected_sigma);
  EXPECT_LT(*record.steps[0].axes[0].expected_sigma, 0.008);
  calibration_.machine.offset.x() += 0.030;
  next_night();
  EXPECT_EQ(run().steps[0].state, NightState::Held);
}

TEST_F(NightlyTest, EachMachineOfADamagedLedgerIsHeld) {
  run();
  {
    std::fstream disk(config_.ledger_file, std::ios::in | std::ios::out | std::ios::binary);
    disk.seekp(0);
    disk << std::string(4096, 'x');
  }
  config_.name = "drill 2";  // its night comes first
  const auto other = run_nightly(job(), std::span<Calibration* const>());
  ASSERT_TRUE(other) << other.error().text();
  EXPECT_THAT(other->notes, Contains(HasSubstr("damaged")));
  config_.name = "drill 1";
  const NightRecord record = run();
  EXPECT_EQ(record.steps[0].state, NightState::Held) << record.verdict;
  EXPECT_THAT(record.notes, Contains(HasSubstr("begun anew")));
}

TEST_F(NightlyTest, ANightIsFromNoonToNoon) {
  const auto at = [](const char* text) { return *from_iso_8601(text); };
  EXPECT_EQ(night_of(at("2026-11-21T12:00:00Z"), 12), "2026-11-21");
  EXPECT_EQ(night_of(at("2026-11-22T11:59:59Z"), 12), "2026-11-21");
  EXPECT_EQ(night_of(at("2026-11-22T03:59:59Z"), 4), "2026-11-21");
  EXPECT_EQ(night_of(at("2026-11-22T04:00:00Z"), 4), "2026-11-22");
}

}  // namespace
}  // namespace panelcal
