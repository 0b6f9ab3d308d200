// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/base/interruption.h"
#include "machine/config/machine_config.h"
#include "machine/devices/no_devices.h"
#include "machine/files/machine_files.h"
#include "machine/nightly/nightly.h"
#include "machine/nightly/record/night_files.h"
#include "machine/nightly/record/night_lock.h"
#include "machine/sources/device_set.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/process/version.h"
#include "tools/cli/provenance.h"
#include "tools/cli/stated_clock.h"
#include "tools/nightly/metrics.h"
#include "tools/nightly/report.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// One call of `panelcal nightly`.
class NightlyRun {
 public:
  NightlyRun(const NightlyOptions& options, CommandContext& context)
      : options_(options), context_(context) {}

  Expected<Answer> execute_all() {
    PANELCAL_CHECK(check_options());
    // If machine.toml is no TOML, the folder of reports is unknown.
    if (auto files = find_night_files(options_.machine)) files_ = *std::move(files);
    PANELCAL_CHECK(check_reports());
    const Expected<NightRecord> record = run();
    if (record) return write_reports(*record, static_cast<ExitCode>(exit_code(*record)));
    const ExitCode code = exit_code(record.error());
    // The run that holds the lock reports for itself. Any other reason not to measure is read in
    // the morning: the page of the night before would still say that the machine may drill.
    const bool is_read = code == ExitCode::DeviceFailed || has_report();
    if (!is_read || another_runs_) return failure(record.error());
    context_.console.print(record.error());
    return write_reports(failed_record(record.error()), code);
  }

 private:
  bool has_report() const {
    return !options_.is_dry_run &&
           !(files_.reports.empty() && !options_.facts.any() && options_.metrics.empty());
  }

  Expected<void> check_options() {
    PANELCAL_TRY(clock_, stated_clock(options_.clock));
    PANELCAL_CHECK(check_extension("panelcal nightly", options_.metrics, ".prom"));
    // A value that is no number passes every range.
    if (options_.temperature_c && !std::isfinite(*options_.temperature_c)) {
      return failure({Code::Usage,
                      {"panelcal nightly", 0, 0},
                      fmt::format("--temperature {}", *options_.temperature_c),
                      "a number from -50 to 100"});
    }
    return {};
  }

  /// The pages that the folder of reports gets are outputs as those that the command line names,
  /// and those of other nights there are none.
  Expected<void> check_reports() {
    if (files_.reports.empty()) return {};
    add_night_records(files_.reports, context_.files, night_of(clock_(), files_.noon_utc_h));
    PANELCAL_CHECK(check_outputs(context_.options, context_.files));
    return check_output(context_.options, context_.files, files_.reports / "NIGHT.html");
  }

  Expected<void> read_config() {
    PANELCAL_TRY(config_, read_machine_config(options_.machine));
    is_read_ = true;
    if (!config_.nightly) {
      return failure({Code::ConfigValue,
                      {options_.machine, 0, 0},
                      "missing table [nightly]",
                      "a table [nightly] (docs/howto/nightly.md)"});
    }
    return {};
  }

  Expected<NightRecord> run() {
    if (options_.is_dry_run) {
      PANELCAL_CHECK(read_config());
      NoDevices none;
      return run_nightly(job(none.devices(), nullptr));
    }
    // A machine file that is not valid leaves no traces.
    const Expected<void> readable = read_config();
    if (!readable && !lies_in_a_calibration(readable.error())) return failure(readable.error());
    // Before a device is opened: another run may be using it.
    std::optional<NightLock> lock;
    if (!files_.ledger.empty()) {
      Expected<NightLock> taken = NightLock::take(files_.ledger, clock_());
      another_runs_ = !taken && taken.error().code == Code::LedgerBusy;
      if (!taken) return failure(taken.error());
      lock.emplace(*std::move(taken));
    }
    PANELCAL_CHECK(read_or_restore());
    heed_interruptions();
    PANELCAL_TRY(const DeviceSet devices,
                 config_.nightly->is_simulated ? DeviceSet::simulated(config_, clock_())
                                               : DeviceSet::live(config_, config_.nightly->camera));
    for (const Diagnostic& risk : devices.risks()) notes_.push_back(risk.text());
    return run_nightly(job(devices.devices(), lock ? &*lock : nullptr));
  }

  /// A damaged calibration is no reason to lose a night if the ledger has it.
  Expected<void> read_or_restore() {
    // Again: another run may have ended meanwhile.
    Expected<void> read = read_config();
    if (read || !lies_in_a_calibration(read.error())) return read;
    const Expected<std::vector<std::string>> restored = restore_damaged_files(files_);
    if (!restored || restored->empty()) return read;
    notes_ = *restored;
    return read_config();
  }

  /// No file of the ledger's mends a mistake in machine.toml itself.
  bool lies_in_a_calibration(const Diagnostic& problem) const {
    const std::string& file = problem.place.file;
    std::error_code ignored;
    if (is_read_) return false;
    return files_.has_calibration(file) ||
           (!files_.spindle.empty() && !std::filesystem::exists(files_.spindle, ignored));
  }

  NightJob job(CalibrationDevices devices, const NightLock* lock) {
    return {.config = config_,
            .nightly = *config_.nightly,
            .devices = std::move(devices),
            .clock = clock_,
            .software = software(),
            .asked_by = asking_person(options_.asked_by),
            .is_dry_run = options_.is_dry_run,
            .is_again = options_.is_again,
            .temperature_c = options_.temperature_c,
            .progress = [this](std::string_view line) { context_.console.say(line); },
            .lock = lock,
            .notes = notes_};
  }

  static std::string software() { return std::string("panelcal ") + kVersion; }

  /// The record that a person finds in the morning if not even the ledger was reached.
  NightRecord failed_record(const Diagnostic& problem) const {
    NightRecord record;
    record.machine = files_.machine;
    record.config_file = options_.machine;
    record.ledger_file = files_.ledger;
    record.started = record.finished = clock_();
    record.night = night_of(record.started, files_.noon_utc_h);
    record.software = software();
    record.asked_by = asking_person(options_.asked_by);
    record.is_dry_run = options_.is_dry_run;
    record.outcome = NightOutcome::Failed;
    record.verdict = "do not drill: nothing was measured: " + problem.text();
    record.notes = notes_;
    return record;
  }

  Provenance provenance() const {
    Provenance out = {command_line_row(context_.options)};
    if (const auto bytes = read_file(options_.machine)) {
      out.emplace_back("sha256 " + options_.machine, sha256(*bytes));
    }
    return out;
  }

  /// The night is what it is if something cannot be written.
  Answer write_reports(const NightRecord& record, ExitCode code) {
    FactsFiles facts = options_.facts;
    const std::filesystem::path& folder = files_.reports;
    // A dry run leaves traces only where they were asked for.
    if (!record.is_dry_run && !folder.empty()) {
      const std::string name = report_name(folder, record);
      if (facts.report.empty()) facts.report = in_folder(folder, name + ".html");
      if (facts.json.empty()) facts.json = in_folder(folder, name + ".json");
      std::error_code ignored;
      // If it cannot be made, writing says why.
      std::filesystem::create_directories(folder, ignored);
    }
    std::string text = nightly::night_text(record);
    if (!facts.report.empty()) text += "report: " + facts.report + "\n";
    const auto document = [&] { return facts::text(nightly::night_facts(record, provenance())); };
    Answer answer = state_facts(context_,
                                facts,
                                fmt::format("Night of {} on {}", record.night, record.machine),
                                document,
                                {std::move(text), code});
    if (options_.metrics.empty()) return answer;
    const auto written = write_file(
        options_.metrics, nightly::night_metrics(record, static_cast<int>(answer.code)).text());
    if (!written) {
      context_.console.print(written.error());
      answer.code = std::max(answer.code, exit_code(written.error()));
    }
    return answer;
  }

  /// "2026-11-21"; or "2026-11-21-2" and so on, so that a run that found out less does not take the
  /// place of one that measured, and the highest number is the newest.
  static std::string report_name(const std::filesystem::path& folder, const NightRecord& record) {
    const auto is_there = [&](const std::string& name) {
      std::error_code ignored;
      return std::filesystem::exists(folder / (name + ".html"), ignored) ||
             std::filesystem::exists(folder / (name + ".json"), ignored);
    };
    const auto numbered = [&](int i) { return fmt::format("{}-{}", record.night, i); };
    const bool has_measured = record.outcome != NightOutcome::Failed &&
                              !std::ranges::all_of(record.steps, &NightStep::is_from_earlier_run);
    if (!is_there(record.night)) return record.night;
    if (has_measured && !is_there(numbered(2)) && is_of_nights(folder / record.night)) {
      return record.night;
    }
    int i = 2;
    constexpr int kMostReports = 1000;  // a day of a run every two minutes
    while (i < kMostReports && is_there(numbered(i))) ++i;
    return numbered(i);
  }

  /// False if a job's report has the name of a night's page.
  static bool is_of_nights(const std::filesystem::path& stem) {
    std::filesystem::path page = stem;
    page += ".html";
    std::error_code ignored;
    return !std::filesystem::exists(page, ignored) || is_night_record(page);
  }

  /// "reports/2026-11-21.html", without the "./" of a machine file named without a folder.
  static std::string in_folder(const std::filesystem::path& folder, const std::string& name) {
    return (folder / name).lexically_normal().string();
  }

  const NightlyOptions& options_;
  CommandContext& context_;
  Clock clock_;
  NightFiles files_;
  MachineConfig config_;
  bool is_read_ = false;
  std::vector<std::string> notes_;
  bool another_runs_ = false;
};

}  // namespace

Expected<Answer> run_command(const NightlyOptions& options, CommandContext& context) {
  return NightlyRun(options, context).execute_all();
}

}  // namespace panelcal
