// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/random.h"
#include "machine/nightly/nightly.h"
#include "machine/nightly/record/night_history.h"
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal::test {

/// State of the fake machine tonight; lengths in mm.
struct FakeMachine {
  Eigen::Vector2d offset = Eigen::Vector2d(51.2, -3.7);
  double sigma = 0.001;   ///< of a calibration, per axis
  double wander = 0.003;  ///< of the drill
  double looks = 0.001;   ///< scatter of looks at a hole
  double contrast = 0.5;
  double blur_px = 1;
  int n_outliers = 0;
  std::optional<Diagnostic> fails;  ///< problem that measuring reports instead of a result
};

/// An offset that is drawn instead of drilled: numbers in place of pictures.
class FakeCalibration final : public Calibration {
 public:
  FakeCalibration(std::filesystem::path folder, std::uint64_t seed)
      : folder_(std::move(folder)), random_(seed) {}

  FakeMachine machine;
  int n_measured = 0;
  int rows_used = 0;

  LedgerKey key() const override {
    return {"drill 1", LedgerKind::SpindleCamera, "spindle 1 station 1"};
  }
  std::vector<std::string> axes() const override { return {"x", "y"}; }
  std::string unit() const override { return "mm"; }
  std::filesystem::path file() const override { return folder_ / "offset.json"; }
  std::optional<Eigen::VectorXd> present() const override { return present_value; }
  std::optional<Eigen::VectorXd> present_value;

  Expected<std::vector<SelfTestCheck>> check() const override {
    return std::vector<SelfTestCheck>{};
  }
  Expected<int> used_up() const override { return rows_used; }
  int n_qualities() const override { return 4; }

  std::optional<LedgerValues> value_of(const LedgerEntry& entry) const override {
    if (entry.record.parameters.size() < 2 || !entry.record.covariance) return std::nullopt;
    return LedgerValues{
        Eigen::Vector2d(entry.record.parameters[0].value, entry.record.parameters[1].value),
        *entry.record.covariance};
  }

  Expected<CalibrationResult> measure(const CalibrationDevices& /*devices*/,
                                      const RecordWords& /*words*/) override {
    ++n_measured;
    rows_used += 3;
    if (machine.fails) return failure(*machine.fails);
    CalibrationResult out;
    const Eigen::Vector2d error(random_.normal(), random_.normal());
    const Eigen::Vector2d value = machine.offset + machine.sigma * error;
    const Eigen::Matrix2d cov = machine.sigma * machine.sigma * Eigen::Matrix2d::Identity();
    out.result.point.value = value;
    out.result.point.cov = cov;
    out.result.n_used = 9 - machine.n_outliers;
    out.result.n_outliers = machine.n_outliers;
    out.result.structure_chance = random_.uniform();
    out.spreads = {spread("holes about the fit", machine.wander, 16),
                   spread("looks at a hole", machine.looks, 52)};
    out.levels = {{"contrast", "1", machine.contrast * std::exp(0.004 * random_.normal()), true},
                  {"edge blur", "px", machine.blur_px * std::exp(0.004 * random_.normal()), false}};
    out.draft.record.key = key();
    out.draft.record.parameters = {{"offset_x", value.x(), "mm"}, {"offset_y", value.y(), "mm"}};
    out.draft.record.covariance = cov;
    out.draft.result = fmt::format("{{\"offset_mm\": [{}, {}]}}\n", value.x(), value.y());
    return out;
  }

  /// Of the fake's files only a damaged one differs from the ledger's, unless a test says more.
  Expected<std::string> by_hand(const Ledger& /*ledger*/) const override { return in_the_file; }
  std::string in_the_file;

 protected:
  std::string_view thing() const override { return "an offset"; }

 private:
  /// A variance as so many degrees of freedom estimate it.
  NightSpread spread(const std::string& name, double sigma, int degrees) {
    double squares = 0;
    for (int i = 0; i < degrees; ++i) {
      const double z = random_.normal();
      squares += z * z;
    }
    return {name, "mm", sigma * sigma * squares / degrees, static_cast<double>(degrees)};
  }

  std::filesystem::path folder_;
  Random random_;
};

/// Counts what it is told.
class FakeDevices final : public Stage, public Spindle, public CameraDevice {
 public:
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    ++n_moves;
    if (is_broken) return failure({Code::DeviceStage, {}, "the stage does not answer", ""});
    return spindle;
  }
  Expected<void> drill(int /*tool*/) override { return {}; }
  Expected<Image> take() override { return Image(8, 8, 255); }
  std::string name() const override { return "fake"; }
  bool can_set(CameraSetting setting) const override { return Stage::can_set(setting); }
  Expected<void> set(CameraSetting setting, double value) override {
    return Stage::set(setting, value);
  }

  int n_moves = 0;
  bool is_broken = false;
};

/// A machine without pictures, with a folder and a clock of its own.
class NightTest : public ::testing::Test {
 protected:
  NightTest() : calibration_(folder_.path(), 1) {
    config_.name = "drill 1";
    config_.ledger_file = folder_.path() / "drill 1.ledger";
    nightly_.min_disk_mb = 0;
    nightly_.drift.min_nights = 5;
  }

  NightJob job() {
    return {config_,
            nightly_,
            {devices_, devices_, devices_, {}, {}},
            [this] { return now_; },
            "panelcal test",
            "timer"};
  }

  Expected<NightRecord> run(const NightJob& job) {
    Calibration* const one = &calibration_;
    return run_nightly(job, std::span(&one, 1));
  }
  /// A night that must come to a record.
  NightRecord run() {
    const Expected<NightRecord> record = run(job());
    if (!record) ADD_FAILURE() << record.error().text();
    return record ? *record : NightRecord{};
  }
  void next_night() { now_ += std::chrono::days(1); }
  /// So many healthy nights.
  void learn(int n_nights) {
    for (int i = 0; i < n_nights; ++i) {
      const NightRecord record = run();
      ASSERT_EQ(exit_code(record), 0) << record.verdict;
      next_night();
    }
  }

  Ledger ledger() const {
    Expected<Ledger> ledger = Ledger::open(config_.ledger_file, [this] { return now_; });
    if (!ledger) ADD_FAILURE() << ledger.error().text();
    return std::move(ledger).value();
  }
  /// Names and contents of the folder's files.
  std::map<std::string, std::string> all_files() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      files[entry.path().filename().string()] = read_file(entry.path()).value_or("");
    }
    return files;
  }
  std::string file() const { return read_file(calibration_.file()).value_or("none"); }
  std::string in_force() const {
    const Ledger ledger = this->ledger();
    const auto entry = ledger.in_force(calibration_.key());
    if (!entry || !*entry) return "none";
    return ledger.result((*entry)->id).value_or("unreadable");
  }
  void fresh_start() {
    Ledger ledger = this->ledger();
    const auto marked =
        mark_fresh_start(ledger, calibration_.key(), {"looked at it", "operator", "panelcal test"});
    ASSERT_TRUE(marked) << marked.error().text();
  }

  TemporaryFolder folder_;
  MachineConfig config_;
  NightlyConfig nightly_;
  FakeDevices devices_;
  FakeCalibration calibration_;
  /// 2026-11-21T23:00:00Z.
  std::chrono::sys_seconds now_{std::chrono::seconds(1795302000)};
};

}  // namespace panelcal::test
