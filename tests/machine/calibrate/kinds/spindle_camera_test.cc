// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/kinds/spindle_camera.h"

#include <filesystem>
#include <string>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "machine/sources/device_set.h"
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/calib/ledger/drafts.h"
#include "tests/machine/calibrate/spindle/coupon_toml.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::HasSubstr;

/// A run as if it had been measured: these tests are about what becomes of it.
SpindleCameraRun run_of(double x_mm) {
  SpindleCameraRun run;
  run.fit.offset.offset = displacement_mm<frame::Machine>(x_mm, -2.98);
  run.fit.offset.cov_mm2 << 1e-6, 2e-7, 2e-7, 2e-6;
  run.fit.wander.sigma = {um(3), um(3.5)};
  run.fit.repeatability.sigma = {um(1), um(1)};
  run.fit.is_separated = true;
  run.fit.backlash[0] = {true, um(2), um(0.5)};
  run.fit.n_used = 8;
  run.fit.n_views = 32;
  run.fit.holes.resize(9);
  run.places.resize(9);
  return run;
}

Expected<bool> install_spindle_camera(const MachineConfig& config, const Ledger& ledger) {
  return spindle_camera_kind(std::make_shared<MachineConfig>(config))->write_in_force(ledger);
}

class CalibrationRecordTest : public ::testing::Test {
 protected:
  void SetUp() override { read(); }
  void read(const std::string& spindle = "") {
    auto config = test::spindle_machine(folder_.path(), test::spindle_toml(spindle));
    ASSERT_TRUE(config) << config.error().text();
    config_ = *std::move(config);
  }
  RecordWords words(LedgerVerdict verdict = LedgerVerdict::Installed) const {
    return {test::kFirstNight, verdict, "because", "timer", "panelcal 0.1.0", 21.5};
  }
  Ledger ledger() {
    auto opened = Ledger::open(config_.ledger_file, test::first_night());
    EXPECT_TRUE(opened) << opened.error().text();
    return *std::move(opened);
  }
  Expected<LedgerDraft> draft_of(double x_mm, const RecordWords& words) const {
    PANELCAL_TRY(std::vector<LedgerInput> inputs, spindle_camera_inputs(config_));
    return spindle_camera_draft(config_, run_of(x_mm), words, std::move(inputs));
  }
  void append(Ledger& ledger, double x_mm, LedgerVerdict verdict = LedgerVerdict::Installed) {
    const auto draft = draft_of(x_mm, words(verdict));
    ASSERT_TRUE(draft) << draft.error().text();
    const auto entry = ledger.append(*draft);
    ASSERT_TRUE(entry) << entry.error().text();
  }
  std::string installed() const {
    return read_file(config_.spindle_setting.file).value_or("no file");
  }
  double installed_x_mm(SpindleAt at) const {
    const auto read = read_spindle_calibration(config_.spindle_setting.file);
    EXPECT_TRUE(read) << read.error().text();
    const SpindleCameraOffset* const offset = read ? read->offsets.find(at) : nullptr;
    return offset == nullptr ? 0 : offset->offset.in_mm().x();
  }

  test::TemporaryFolder folder_;
  MachineConfig config_;
};

TEST_F(CalibrationRecordTest, TheDraftSaysAllThatThereIs) {
  const auto draft = draft_of(45.03, words());
  ASSERT_TRUE(draft) << draft.error().text();
  const LedgerRecord& record = draft->record;
  EXPECT_EQ(record.key, (LedgerKey{"drill 1", LedgerKind::SpindleCamera, "spindle 1 station 1"}));
  ASSERT_EQ(record.parameters.size(), 2u);
  EXPECT_EQ(record.parameters[0], (LedgerParameter{"offset_x", 45.03, "mm"}));
  EXPECT_EQ(record.parameters[1], (LedgerParameter{"offset_y", -2.98, "mm"}));
  EXPECT_EQ(*record.covariance, run_of(45.03).fit.offset.cov_mm2);
  EXPECT_EQ(record.temperature_degC, 21.5);
  ASSERT_EQ(record.inputs.size(), 2u);
  EXPECT_EQ(record.inputs[0].name, "machine.toml");
  EXPECT_EQ(record.inputs[0].sha256, sha256(*read_file(config_.file)));
  EXPECT_EQ(record.inputs[1].name, "camera.cal.json");
  const auto result = parse_spindle_calibration(draft->result, "result");
  ASSERT_TRUE(result) << result.error().text();
  EXPECT_EQ(result->date, test::kFirstNight);
  const auto& quality = result->records.at({1, 1}).quality;
  ASSERT_TRUE(quality);
  EXPECT_EQ(quality->n_holes, 8);
  EXPECT_EQ(quality->n_left_out, 1);
  EXPECT_NEAR(quality->wander_um[1], 3.5, 1e-9);
  EXPECT_NEAR(quality->repeatability_um.value()[0], 1, 1e-9);
  EXPECT_NEAR(quality->backlash_um[0].value(), 2, 1e-9);
  EXPECT_FALSE(quality->backlash_um[1]);
}

TEST_F(CalibrationRecordTest, TheFileIsTheLedgersResultByteForByte) {
  Ledger ledger = this->ledger();
  EXPECT_EQ(install_spindle_camera(config_, ledger), false) << "nothing is in force yet";
  append(ledger, 45.03);
  append(ledger, 47.5, LedgerVerdict::Refused);
  EXPECT_EQ(install_spindle_camera(config_, ledger), true);
  EXPECT_EQ(installed(), ledger.result(1).value());
  EXPECT_EQ(install_spindle_camera(config_, ledger), false) << "it is there already";
}

TEST_F(CalibrationRecordTest, ADamagedOrLostFileIsWrittenAgain) {
  Ledger ledger = this->ledger();
  append(ledger, 45.03);
  for (const char* damage : {"", "{", "{\"kind\": \"spindle-camera\"}"}) {
    ASSERT_TRUE(write_file(config_.spindle_setting.file, damage));
    EXPECT_EQ(install_spindle_camera(config_, ledger), true);
    EXPECT_EQ(installed(), ledger.result(1).value());
  }
  std::filesystem::remove(config_.spindle_setting.file);
  EXPECT_EQ(install_spindle_camera(config_, ledger), true);
  EXPECT_EQ(installed(), ledger.result(1).value());
}

TEST_F(CalibrationRecordTest, ARollbackBringsTheOldFileBack) {
  Ledger ledger = this->ledger();
  append(ledger, 45.03);
  append(ledger, 45.04);
  EXPECT_EQ(install_spindle_camera(config_, ledger), true);
  EXPECT_NEAR(installed_x_mm({1, 1}), 45.04, 1e-12);
  ASSERT_TRUE(ledger.roll_back({spindle_camera_key(config_), {}, "it was better", "me", "test"}));
  EXPECT_EQ(install_spindle_camera(config_, ledger), true);
  EXPECT_EQ(installed(), ledger.result(1).value());
}

TEST_F(CalibrationRecordTest, SpindlesDoNotDisturbEachOther) {
  Ledger ledger = this->ledger();
  append(ledger, 45.03);
  read("number = 2\n");
  append(ledger, -60);
  EXPECT_EQ(install_spindle_camera(config_, ledger), true);
  EXPECT_NEAR(installed_x_mm({1, 1}), 45.03, 1e-12);
  EXPECT_NEAR(installed_x_mm({2, 1}), -60, 1e-12);
  EXPECT_EQ(install_spindle_camera(config_, ledger), false) << "again it is the same";
  const auto config = read_machine_config(config_.file);
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_NEAR(config->spindle_camera.offset.in_mm().x(), -60, 1e-12);
}

TEST_F(CalibrationRecordTest, ASpindleThatOnlyTheFileHasIsKept) {
  SpindleCalibration found;
  SpindleCameraOffset offset;
  offset.offset = displacement_mm<frame::Machine>(12, 13);
  found.offsets.set({7, 2}, offset);
  found.date = test::kFirstNight - std::chrono::hours(100);
  ASSERT_TRUE(write_spindle_calibration(config_.spindle_setting.file, found));
  Ledger ledger = this->ledger();
  append(ledger, 45.03);
  EXPECT_EQ(install_spindle_camera(config_, ledger), true);
  EXPECT_EQ(installed_x_mm({7, 2}), 12);
  EXPECT_NEAR(installed_x_mm({1, 1}), 45.03, 1e-12);
  const auto read = read_spindle_calibration(config_.spindle_setting.file);
  EXPECT_EQ(read->date_of({7, 2}), found.date);
  EXPECT_EQ(install_spindle_camera(config_, ledger), false) << "again it is the same";
}

TEST_F(CalibrationRecordTest, WhatAPersonPutInTheFileIsToldFromAnInterruptedInstallation) {
  const auto draft = draft_of(46, words());
  ASSERT_TRUE(draft) << draft.error().text();
  SpindleCalibration by_hand = parse_spindle_calibration(draft->result, "").value();
  by_hand.date = by_hand.records[{1, 1}].date = test::kFirstNight - std::chrono::hours(1);
  const auto put_by_hand = [&] {
    ASSERT_TRUE(write_spindle_calibration(config_.spindle_setting.file, by_hand));
  };
  const std::vector<SpindleAt> nobody;
  Ledger ledger = this->ledger();
  put_by_hand();
  EXPECT_EQ(spindles_by_hand(config_, ledger), nobody) << "there is nothing to write over it";
  append(ledger, 45.03);
  EXPECT_EQ(spindles_by_hand(config_, ledger), nobody) << "it is of before the first installation";
  by_hand.date = by_hand.records[{1, 1}].date = test::kFirstNight + std::chrono::hours(100);
  put_by_hand();
  EXPECT_EQ(spindles_by_hand(config_, ledger), std::vector<SpindleAt>{SpindleAt{}});
  EXPECT_EQ(install_spindle_camera(config_, ledger), true);
  EXPECT_EQ(spindles_by_hand(config_, ledger), nobody) << "it is what is in force";
  append(ledger, 45.04);
  EXPECT_EQ(spindles_by_hand(config_, ledger), nobody) << "it is of an earlier installation";
  append(ledger, 46, LedgerVerdict::Refused);
  put_by_hand();
  EXPECT_EQ(spindles_by_hand(config_, ledger), std::vector<SpindleAt>{SpindleAt{}})
      << "a refused one was not installed by a night";
  ASSERT_TRUE(write_file(config_.spindle_setting.file, "{"));
  EXPECT_EQ(spindles_by_hand(config_, ledger), nobody);
  std::filesystem::remove(config_.spindle_setting.file);
  EXPECT_EQ(spindles_by_hand(config_, ledger), nobody);
}

TEST_F(CalibrationRecordTest, OtherMachinesAndKindsOfTheLedgerAreNotTaken) {
  Ledger ledger = this->ledger();
  LedgerDraft other = test::offset_draft(99);
  other.record.key = {"drill 2", LedgerKind::SpindleCamera, "spindle 1 station 1"};
  ASSERT_TRUE(ledger.append(other));
  other.record.key = {"drill 1", LedgerKind::Camera, "spindle 1 station 1"};
  ASSERT_TRUE(ledger.append(other));
  EXPECT_EQ(install_spindle_camera(config_, ledger), false);
}

TEST_F(CalibrationRecordTest, AResultThatIsNoCalibrationIsNotInstalled) {
  Ledger ledger = this->ledger();
  ASSERT_TRUE(ledger.append(test::offset_draft(45)));
  EXPECT_THAT(install_spindle_camera(config_, ledger),
              FailsWith(Code::CalibrationInvalid, "ledger entry 1"));
  EXPECT_EQ(installed(), "no file");
}

TEST_F(CalibrationRecordTest, WithoutAFileThereIsNothingToInstall) {
  Ledger ledger = this->ledger();
  config_.spindle_setting.file.clear();
  append(ledger, 45.03);
  EXPECT_EQ(install_spindle_camera(config_, ledger), false);
}

TEST_F(CalibrationRecordTest, APowerCutBetweenLedgerAndFileIsMended) {
  // The process is gone right after the ledger has acknowledged, before the file is written.
  for (int night = 1; night <= 3; ++night) {
    SCOPED_TRACE(night);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      auto opened = Ledger::open(config_.ledger_file, test::first_night());
      const auto draft = draft_of(45 + 0.01 * night, words());
      if (!opened || !draft || !opened->append(*draft)) _exit(1);
      kill(getpid(), SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the child could not append";
    const Ledger ledger = this->ledger();
    EXPECT_EQ(install_spindle_camera(config_, ledger), true);
    EXPECT_NEAR(installed_x_mm({1, 1}), 45 + 0.01 * night, 1e-9);
  }
}

}  // namespace
}  // namespace panelcal
