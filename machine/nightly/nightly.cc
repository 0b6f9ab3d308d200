// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/nightly.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <utility>
#include <vector>

#include "calib/base/interruption.h"
#include "calib/drift/amount.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/calibrate/kinds/kinds.h"
#include "machine/devices/cameras/camera_settings.h"
#include "machine/nightly/checks/self_test.h"
#include "machine/nightly/checks/warm_up.h"
#include "machine/nightly/night_quality.h"
#include "machine/nightly/night_step.h"
#include "machine/nightly/night_verdict.h"
#include "machine/nightly/record/night_history.h"
#include "machine/nightly/record/night_ledger.h"
#include "machine/nightly/record/night_lock.h"
#include "machine/nightly/record/noted_heads.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// A machine that stood still for longer begins anew.
constexpr std::chrono::days kLongestPause(400);

/// One run, from the lock to the record.
class Night {
 public:
  /// In     config: the job's, or the copy of it that the calibrations share
  Night(const NightJob& job,
        const MachineConfig& config,
        std::span<Calibration* const> calibrations)
      : job_(job),
        config_(config),
        calibrations_(calibrations.begin(), calibrations.end()),
        nightly_(job.nightly) {
    nightly_.watch.nights_per_false_alarm *= n_charts();
    record_.machine = machine_name(config);
    record_.config_file = config.file;
    record_.ledger_file = config.ledger_file;
    record_.started = job.clock();
    record_.night = night_of(record_.started, job.nightly.noon_utc_h);
    record_.software = job.software;
    record_.asked_by = job.asked_by;
    record_.is_dry_run = job.is_dry_run;
    record_.notes = job.notes;
  }

  Expected<NightRecord> run() {
    PANELCAL_CHECK(check_config());
    read_the_temperature();
    std::optional<NightLock> own;
    std::optional<Ledger> ledger;
    if (job_.is_dry_run) {
      PANELCAL_TRY(ledger, look_at_ledger());
    } else {
      if (job_.lock == nullptr) {
        PANELCAL_TRY(NightLock taken, NightLock::take(config_.ledger_file, record_.started));
        own.emplace(std::move(taken));
      }
      note_cut_off(own ? *own : *job_.lock);
      PANELCAL_TRY(ledger,
                   open_night_ledger(files(), job_.clock, record_.machine, words(), record_.notes));
      PANELCAL_CHECK(check_clock(*ledger));
      PANELCAL_CHECK(note_lost(*ledger));
    }
    if (ledger) repair(*ledger);
    if (!job_.is_dry_run) warm_up_and_test(*ledger);
    run_steps(ledger ? &*ledger : nullptr);
    if (ledger) PANELCAL_CHECK(look_back(*ledger));
    record_.finished = job_.clock();
    fill_verdict(record_);
    if (!job_.is_dry_run) PANELCAL_CHECK(finish(*ledger));
    return std::move(record_);
  }

 private:
  /// All that may alarm falsely: each has its share of the rate that is stated for them together.
  int n_charts() const {
    int n = nightly_.mark ? kMarkQualities : 0;
    for (const Calibration* calibration : calibrations_) n += 1 + calibration->n_qualities();
    return std::max(1, n);
  }

  void say(const std::string& line) const {
    if (job_.progress) job_.progress(line);
  }

  void note_cut_off(const NightLock& lock) {
    if (lock.cut_off().empty()) return;
    record_.is_resumed = true;
    record_.notes.push_back("a run before this one was cut off: " + quoted(lock.cut_off(), 100));
  }

  /// A mistake in machine.toml shows before anything moves or is written.
  Expected<void> check_config() {
    if (config_.ledger_file.empty()) {
      return failure({Code::ConfigValue,
                      {config_.file.string(), 0, 0},
                      "there is no [ledger] to record the night in",
                      "[ledger] file"});
    }
    PANELCAL_CHECK(job_.nightly.limits.validate());
    PANELCAL_CHECK(job_.nightly.drift.validate());
    PANELCAL_CHECK(job_.nightly.watch.validate());
    PANELCAL_CHECK(nightly_.watch.validate());
    for (const Calibration* calibration : calibrations_) {
      PANELCAL_TRY(std::vector<SelfTestCheck> checks, calibration->check());
      std::ranges::move(checks, std::back_inserter(record_.checks));
    }
    record_.checks.push_back(check_disk(config_.ledger_file, job_.nightly.min_disk_mb));
    return {};
  }

  void read_the_temperature() {
    record_.temperature_c = job_.temperature_c;
    if (record_.temperature_c) return;
    if (job_.is_dry_run && !job_.nightly.temperature_command.empty()) return;
    const Expected<std::optional<double>> read = read_temperature(job_.nightly);
    if (read) {
      record_.temperature_c = *read;
    } else {
      record_.notes.push_back("the temperature is not known: " + read.error().what);
    }
  }

  NightFiles files() const { return night_files_of(config_, job_.nightly); }

  RecordWords words() const {
    return {.date = job_.clock(),
            .asked_by = job_.asked_by,
            .software = job_.software,
            .temperature_degC = record_.temperature_c};
  }

  /// A clock far ahead would leave entries that hold every later night.
  Expected<void> check_clock(const Ledger& ledger) const {
    LedgerFilter filter;
    filter.machine = record_.machine;
    filter.last = 1;
    PANELCAL_TRY(const std::vector<LedgerEntry> newest, ledger.list(filter));
    if (newest.empty()) return {};
    const std::chrono::days pause =
        std::chrono::floor<std::chrono::days>(record_.started - newest.back().time);
    if (pause <= kLongestPause) return {};
    return failure({Code::LedgerEntryInvalid,
                    {config_.ledger_file.string(), 0, 0},
                    fmt::format("the clock says {}, {} days after the newest entry of {}",
                                iso_8601(record_.started),
                                pause.count(),
                                quoted(record_.machine)),
                    "the right time, or after such a pause `panelcal history fresh-start`"});
  }

  /// Records what a run that was cut off has used up.
  Expected<void> note_lost(const Ledger& ledger) {
    for (const Calibration* calibration : calibrations_) {
      PANELCAL_TRY(const NightHistory history,
                   read_night_history(ledger, *calibration, record_.night, record_.started));
      if (history.is_unconfirmed) {
        record_.notes.push_back(fmt::format(
            "the ledger was begun anew: no {} is installed until a person marks a fresh "
            "start",
            word(calibration->key().kind)));
      }
      PANELCAL_TRY(const int used_up, calibration->used_up());
      if (!history.used_up || used_up <= *history.used_up) continue;
      record_.notes.push_back(
          fmt::format("{} rows of the coupon were taken since the last recorded night, by a run "
                      "that was cut off or by hand",
                      used_up - *history.used_up));
    }
    return {};
  }

  /// Files of installations that were interrupted. What a person has put there is neither written
  /// over nor passed over: the night is held.
  void repair(const Ledger& ledger) {
    for (Calibration* calibration : calibrations_) {
      const Expected<bool> is_there = calibration->is_installed(ledger);
      const Expected<std::string> by_hand = calibration->by_hand(ledger);
      if (by_hand && !by_hand->empty() && !(job_.is_dry_run && is_there && *is_there)) {
        held_ = past_the_ledger(*calibration, *by_hand);
        continue;
      }
      const std::string file = quoted(calibration->file().string(), 200);
      if (job_.is_dry_run && is_there) {
        if (*is_there) continue;
        record_.notes.push_back(fmt::format(
            "{} is not the calibration in force: it would be written again from the ledger", file));
        continue;
      }
      const Expected<bool> written = job_.is_dry_run ? is_there : calibration->install(ledger);
      if (written && !*written) continue;
      record_.notes.push_back(
          written ? fmt::format(
                        "{} was not the calibration in force: written again from the ledger", file)
                  : fmt::format("{} cannot be written: {}", file, written.error().what));
      if (!written) blocked_ = record_.notes.back();
    }
  }

  static std::string past_the_ledger(const Calibration& calibration, const std::string& what) {
    return fmt::format(
        "{}: {} is not in the ledger: if the ledger is an older copy, put the newest back; else "
        "move the file away, and the next run writes it again from the ledger; or, to keep it, "
        "calibrate again with --install",
        quoted(calibration.file().string(), 200),
        what);
  }

  void warm_up_and_test(Ledger& ledger) {
    for (const SelfTestCheck& check : record_.checks) {
      if (!check.passed && check.name == "disk") blocked_ = check.text;
    }
    if (!blocked_.empty() || !held_.empty() || is_nothing_to_measure(ledger)) return;
    if (job_.nightly.warm_up > seconds(0)) say("warming up");
    // Before the mark is looked at for the first time.
    const Expected<void> set = set_camera_as_stated(config_, job_.devices);
    if (!set) return block(set.error());
    Expected<WarmUpRun> warm = warm_up(config_, job_.nightly, job_.devices, job_.clock);
    if (!warm) return block(warm.error());
    record_.warmed_up = warm->waited;
    if (warm->seen) {
      record_.checks.push_back(warm_up_check(*warm->seen));
      if (!warm->seen->is_warm) no_measuring_ = warm->seen->text;
      say(warm->seen->text);
    }
    record_.warm_up = std::move(warm->seen);
    if (!job_.nightly.mark) return;
    say("looking at the mark");
    const Expected<void> tested = test_and_record(ledger);
    if (!tested) block(tested.error());
  }

  bool is_nothing_to_measure(const Ledger& ledger) const {
    return !job_.is_again && std::ranges::all_of(calibrations_, [&](const auto* calibration) {
      const auto history = read_night_history(ledger, *calibration, record_.night, record_.started);
      return history && history->tonight;
    });
  }

  void block(const Diagnostic& problem) {
    SelfTestCheck check;
    check.name = "machine";
    check.passed = false;
    check.text = problem.message();
    record_.checks.push_back(check);
    blocked_ = check.text;
  }

  Expected<void> test_and_record(Ledger& ledger) {
    PANELCAL_TRY(MarkLooks looks, test_mark(config_, job_.nightly, job_.devices));
    looks.quality.time = job_.clock();
    PANELCAL_TRY(const SelfTestHistory history,
                 read_self_tests(ledger, record_.machine, looks.quality.time));
    looks.quality.is_fresh_start = history.is_fresh_start;
    PANELCAL_TRY(const QualityVerdict verdict,
                 judge_qualities(history.nights, looks.quality, nightly_));
    for (const NightQuality& quality : verdict.qualities) {
      const auto gate = std::ranges::find(verdict.gates, quality.name, &NightGate::name);
      SelfTestCheck check;
      check.name = quality.name;
      check.passed = gate == verdict.gates.end();
      check.text = check.passed ? quality.name + ": " + quality.text : gate->text;
      check.value = quality.value;
      check.unit = quality.unit;
      const auto slow = std::ranges::find_if(verdict.alarms, [&](const std::string& alarm) {
        return alarm.starts_with(quality.name);
      });
      if (check.passed && slow != verdict.alarms.end()) {
        check.text = *slow;
        record_.notes.push_back(*slow);
      }
      looks.checks.push_back(std::move(check));
    }
    for (const SelfTestCheck& check : looks.checks) {
      if (!check.passed && bad_pictures_.empty()) bad_pictures_ = check.text;
    }
    PANELCAL_CHECK(
        ledger.append(self_test_draft(record_.machine, looks.quality, words(), bad_pictures_)));
    std::ranges::move(looks.checks, std::back_inserter(record_.checks));
    return {};
  }

  NightStep next_step(const NightContext& context, Calibration& calibration, Ledger* ledger) const {
    if (!blocked_.empty()) return unreached_night_step(calibration, blocked_);
    if (!held_.empty()) return held_night_step(calibration, held_);
    if (job_.is_dry_run) return foresee_night_step(context, calibration, ledger);
    return run_night_step(context, calibration, *ledger);
  }

  /// In     ledger: null where a dry run found none
  void run_steps(Ledger* ledger) {
    for (Calibration* calibration : calibrations_) {
      if (const Expected<void> goes_on = check_interruption(); !goes_on && blocked_.empty()) {
        blocked_ = "interrupted: " + goes_on.error().what;
      }
      const NightlyConfig held_to = calibration->held_to(nightly_);
      NightContext context = {job_, held_to, record_.night, record_.temperature_c, no_measuring_};
      if (calibration->may_explain_pictures() && !bad_pictures_.empty()) {
        context.untrusted = bad_pictures_ + " (measured since it may be why, and not installed)";
      } else if (no_measuring_.empty()) {
        context.no_measuring = bad_pictures_;
      }
      record_.steps.push_back(next_step(context, *calibration, ledger));
      const NightStep& step = record_.steps.back();
      if (step.state == NightState::Failed && !job_.is_dry_run) blocked_ = step.summary;
      record_.is_resumed = record_.is_resumed || step.is_from_earlier_run;
    }
  }

  /// Checks what only a person can put there.
  Expected<void> check_machine_toml(const Ledger& ledger) {
    for (const Calibration* calibration : calibrations_) {
      SelfTestCheck check;
      PANELCAL_TRY(check.text, calibration->stated_otherwise(ledger));
      if (check.text.empty()) continue;
      check.name = "machine.toml";
      check.passed = false;
      record_.checks.push_back(std::move(check));
    }
    return {};
  }

  /// What the ledger says when all is done.
  Expected<void> look_back(const Ledger& ledger) {
    if (job_.is_dry_run) PANELCAL_CHECK(check_clock(ledger));
    fill_changes(ledger);
    PANELCAL_CHECK(check_machine_toml(ledger));
    if (!job_.is_dry_run) return {};
    PANELCAL_TRY(std::string words, last_warm_up(ledger, record_.machine));
    if (!words.empty()) record_.notes.push_back(std::move(words));
    return {};
  }

  Expected<void> finish(Ledger& ledger) {
    PANELCAL_TRY(const bool is_recorded, is_night_recorded(ledger));
    if (!is_recorded) {
      const Expected<LedgerEntry> entry = ledger.append(night_draft(record_, record_.machine));
      // The steps are in the ledger; without this entry only the summary is missing.
      if (!entry) {
        record_.notes.push_back("the night's entry is not recorded: " + entry.error().what);
        record_.outcome = NightOutcome::Failed;
        record_.may_drill = false;
        record_.drill_until.reset();
        record_.verdict = "do not drill: " + record_.notes.back();
      }
    }
    PANELCAL_TRY(record_.head, ledger.head());
    say(record_.verdict);
    return {};
  }

  /// A run that had nothing to do adds nothing to what an earlier one has recorded.
  Expected<bool> is_night_recorded(const Ledger& ledger) const {
    const bool is_all_done = std::ranges::all_of(record_.steps, &NightStep::is_from_earlier_run);
    if (!is_all_done || record_.steps.empty()) return false;
    PANELCAL_TRY(const auto last, ledger.list({record_.machine, LedgerKind::Night, "night"}, 1));
    std::int64_t newest = 0;
    for (const NightStep& step : record_.steps)
      newest = std::max(newest, step.ledger_id.value_or(0));
    return !last.empty() && last.back().id > newest;
  }

  void fill_changes(const Ledger& ledger) {
    for (const Calibration* calibration : calibrations_) {
      const auto history = read_night_history(ledger, *calibration, record_.night, record_.started);
      if (!history || !history->week_ago || !history->in_force_value) continue;
      // The very same result has not changed, however uncertain it is.
      const bool is_same = history->week_ago->value == history->in_force_value->value &&
                           history->week_ago->cov == history->in_force_value->cov;
      const LedgerKey key = calibration->key();
      std::string line = fmt::format("{} {}:", word(key.kind), key.subject);
      const std::vector<std::string> axes = calibration->axes();
      for (std::size_t i = 0; i < axes.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        const double change = history->in_force_value->value(row) - history->week_ago->value(row);
        const double variance =
            is_same ? 0 : history->in_force_value->cov(row, row) + history->week_ago->cov(row, row);
        line += fmt::format("{} {} {} (sigma {})",
                            i == 0 ? "" : ",",
                            axes[i],
                            signed_amount(change, calibration->unit()),
                            amount(std::sqrt(variance), calibration->unit()));
      }
      record_.changes.push_back(line + " against a week ago");
    }
  }

  /// The ledger of a dry run, if there is one.
  Expected<std::optional<Ledger>> look_at_ledger() {
    const std::string holder = NightLock::holder(config_.ledger_file);
    if (!holder.empty()) record_.notes.push_back("a night of this machine runs: " + holder);
    std::optional<Ledger> ledger;
    std::error_code ignored;
    if (std::filesystem::exists(config_.ledger_file, ignored)) {
      PANELCAL_TRY(ledger, Ledger::open_to_read(config_.ledger_file));
      PANELCAL_TRY(record_.head, ledger->verify());
    } else {
      record_.notes.emplace_back("there is no ledger yet: it would be begun");
    }
    PANELCAL_CHECK(check_noted_heads(files(), ledger ? &*ledger : nullptr));
    return ledger;
  }

  const NightJob& job_;
  const MachineConfig& config_;
  std::vector<Calibration*> calibrations_;
  NightlyConfig nightly_;  ///< job_.nightly, with each chart's own rate of false alarms
  NightRecord record_;
  std::string blocked_;       ///< reason why no further step is begun
  std::string held_;          ///< reason why no step is begun, and a person has to see to it
  std::string no_measuring_;  ///< reason why nothing is measured, though the machine works
  std::string bad_pictures_;  ///< reason why nothing is measured but what may explain them
};

}  // namespace

std::string night_of(std::chrono::sys_seconds time, int noon_utc_h) {
  const auto day = std::chrono::floor<std::chrono::days>(time - std::chrono::hours(noon_utc_h));
  return iso_8601(std::chrono::sys_seconds(day)).substr(0, 10);
}

Expected<NightRecord> run_nightly(const NightJob& job, std::span<Calibration* const> calibrations) {
  return Night(job, job.config, calibrations).run();
}

Expected<NightRecord> run_nightly(const NightJob& job) {
  PANELCAL_TRY(const NightCalibrations calibrations,
               NightCalibrations::make(job.config, job.nightly));
  return Night(job, calibrations.config(), calibrations.all()).run();
}

}  // namespace panelcal
