// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/drift/night_gates.h"
#include "calib/ledger/ledger.h"
#include "calib/spindle/calibration_file.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/calibrate/spindle/camera_run.h"
#include "machine/calibrate/spindle/coupon.h"
#include "machine/devices/cameras/camera_settings.h"
#include "machine/job/spindle_age.h"
#include "machine/nightly/record/night_lock.h"
#include "machine/nightly/record/noted_heads.h"
#include "tools/calibrate/calibrate.h"
#include "tools/calibrate/spindle_answer.h"
#include "tools/cli/operator_prompt.h"
#include "tools/cli/process/version.h"
#include "tools/cli/provenance.h"
#include <fmt/format.h>
#include <unistd.h>

namespace panelcal::calibrate {
namespace {

constexpr const char* kCalibrateSpindleCamera = "panelcal calibrate spindle-camera";

Diagnostic spindle_camera_usage(std::string what, std::string expected) {
  return {Code::Usage, {kCalibrateSpindleCamera, 0, 0}, std::move(what), std::move(expected)};
}

/// One call of `panelcal calibrate spindle-camera`.
class SpindleCamera {
 public:
  SpindleCamera(const CalibrateOptions& options, CommandContext& context)
      : options_(options), context_(context) {}

  Expected<Answer> answer() {
    PANELCAL_CHECK(prepare());
    PANELCAL_TRY(const Prompt prompt, prompt_of());
    std::optional<NightLock> lock;
    PANELCAL_CHECK(lock_machine(options_, config_, lock));
    // Before a ledger is begun beside files that note entries of another.
    PANELCAL_CHECK(check_noted_heads(config_));
    PANELCAL_TRY(const DeviceSet set, open_devices(options_, config_));
    // Before a row of the coupon is used up.
    std::optional<Ledger> ledger;
    if (options_.install) {
      const auto date = words_.date;
      PANELCAL_TRY(ledger, Ledger::open(config_.ledger_file, [date] { return date; }));
      PANELCAL_CHECK(check_others(*ledger));
    }
    CalibrationDevices devices = set.devices(prompt);
    devices.observer = progress();
    devices.taken_by = {fixed_clock(words_.date), words_.asked_by, words_.software};
    PANELCAL_CHECK(set_camera_as_stated(config_, devices));
    PANELCAL_TRY(const SpindleCameraRun run, calibrate_spindle_camera(config_, devices));
    context_.console.end_progress();
    SpindleAnswer answer = compare(config_, run);
    if (!options_.output.empty()) {
      PANELCAL_TRY(
          const std::string text,
          text_with_head(
              config_, spindle_calibration_text(spindle_camera_calibration(config_, run, words_))));
      PANELCAL_CHECK(parse_spindle_calibration(text, options_.output));
      PANELCAL_CHECK(write_file(options_.output, text));
    }
    if (ledger) PANELCAL_CHECK(install(*ledger, run, answer));
    const bool is_refused = options_.install && !answer.is_installed;
    return Answer{options_.json ? json(answer, run) : text(answer, run),
                  is_refused ? ExitCode::GateFailed : ExitCode::Done};
  }

 private:
  Expected<void> prepare() {
    if (options_.install && !options_.output.empty()) {
      return failure(
          spindle_camera_usage("--install and --output together",
                               "one of them: --install writes the file that [spindle] names"));
    }
    PANELCAL_TRY(words_.date, time_of(options_));
    PANELCAL_TRY(config_, read_machine_config(options_.machine));
    const SpindleSetting& setting = config_.spindle_setting;
    PANELCAL_CHECK(select_spindle(
        config_,
        {options_.spindle.value_or(setting.spindle), options_.station.value_or(setting.station)}));
    PANELCAL_CHECK(check_begin());
    // An old date that is not valid does not prevent a new offset.
    static_cast<void>(age_offset(config_, words_.date));
    words_.reason = options_.reason;
    words_.asked_by = asking_person(options_.asked_by);
    words_.software = std::string("panelcal ") + kVersion;
    return options_.install ? check_install() : Expected<void>();
  }

  Expected<void> check_install() const {
    const Place place{config_.file.string(), 0, 0};
    if (config_.spindle_setting.file.empty()) {
      return failure({Code::ConfigValue,
                      place,
                      "[spindle] names no calibration that could be installed",
                      "[spindle] calibration = \"NAME.cal.json\""});
    }
    if (config_.ledger_file.empty()) {
      return failure({Code::ConfigValue,
                      place,
                      "there is no ledger to record what is installed",
                      "[ledger] file = \"NAME.ledger\""});
    }
    return {};
  }

  /// The file is written from the ledger, which would lose what it does not know.
  Expected<void> check_others(const Ledger& ledger) const {
    const SpindleSetting& setting = config_.spindle_setting;
    PANELCAL_TRY(const std::vector<SpindleAt> by_hand, spindles_by_hand(config_, ledger));
    for (const SpindleAt& at : by_hand) {
      if (at == SpindleAt{setting.spindle, setting.station}) continue;
      return failure({Code::ConfigValue,
                      {setting.file.string(), 0, 0},
                      "its " + subject(at) + " was put there by hand, past the ledger",
                      "that spindle installed first, or its old offset"});
    }
    return {};
  }

  /// Without a start value, the camera would look for another spindle's holes.
  Expected<void> check_begin() const {
    const SpindleSetting& setting = config_.spindle_setting;
    if (setting.is_calibrated || setting.stated_offset) return {};
    return failure({Code::ConfigValue,
                    {config_.file.string(), 0, 0},
                    "there is no start value for " + subject({setting.spindle, setting.station}),
                    "[spindle] camera_offset_mm"});
  }

  /// DeviceSet knows that no person lays anything on a simulated coupon.
  Expected<Prompt> prompt_of() const {
    const bool asks = config_.coupon && config_.coupon->has_entry_material && !options_.yes &&
                      options_.machine_driver.empty();
    if (options_.yes) return Prompt([](std::string_view) -> Expected<void> { return {}; });
    if (!asks) return Prompt();
    if (::isatty(STDIN_FILENO) != 1) {
      return failure(spindle_camera_usage(
          "the coupon needs entry material, and no person is at a terminal to lay it "
          "on",
          "--yes if it is dealt with"));
    }
    return Prompt([this](std::string_view what) {
      return ask_operator(kCalibrateSpindleCamera, "Enter, or --yes", context_.console, what);
    });
  }

  PictureObserver progress() {
    if (!config_.coupon) return {};
    const std::size_t n_pictures = config_.coupon->looking.size() *
                                   static_cast<std::size_t>(config_.coupon->columns) *
                                   static_cast<std::size_t>(config_.coupon->rows_per_run);
    return [this, n_pictures, i = std::size_t{0}](const SeenView&) mutable {
      context_.console.progress(fmt::format("looking at the coupon: {} of {}", ++i, n_pictures));
    };
  }

  /// The ledger first: whatever happens then, it says which file should be there.
  Expected<void> install(Ledger& ledger, const SpindleCameraRun& run, SpindleAnswer& answer) {
    if (!options_.force) {
      answer.refusal = trend_words(run.fit);
      if (answer.refusal.empty()) {
        PANELCAL_TRY(answer.refusal, gate_words(run));
      }
    }
    words_.verdict = answer.refusal.empty() ? LedgerVerdict::Installed : LedgerVerdict::Refused;
    if (!answer.refusal.empty()) words_.reason = answer.refusal;
    PANELCAL_TRY(LedgerDraft draft, spindle_camera_draft(config_, run, words_));
    PANELCAL_CHECK(note_head(ledger, draft));
    PANELCAL_TRY(const LedgerEntry entry, ledger.append(draft));
    answer.ledger_id = entry.id;
    answer.is_installed = answer.refusal.empty();
    if (answer.is_installed) PANELCAL_CHECK(install_spindle_camera(config_, ledger));
    return {};
  }

  /// The one of the nights' gates that refuses it; empty if none does. Neither the trend, which is
  /// judged already, nor the temperature, which is not read here, is among them.
  Expected<std::string> gate_words(const SpindleCameraRun& run) const {
    NightLimits limits = config_.nightly ? config_.nightly->limits : NightLimits();
    limits.min_temperature_c.reset();
    limits.max_temperature_c.reset();
    NightResult result;
    result.point.time = words_.date;
    result.point.value = run.fit.offset.offset.in_mm();
    result.point.cov = 0.5 * (run.fit.offset.cov_mm2 + run.fit.offset.cov_mm2.transpose());
    result.n_used = run.fit.n_used;
    // A hole that was not even seen is no better than one that does not fit.
    result.n_outliers = static_cast<int>(run.places.size()) - run.fit.n_used;
    std::optional<Eigen::VectorXd> in_force;
    if (config_.spindle_setting.is_calibrated) in_force = config_.spindle_camera.offset.in_mm();
    const DriftSeries no_history = {{"x", "y"}, "mm", {}};
    PANELCAL_TRY(const NightDecision decision,
                 decide_night(result, in_force, no_history, DriftOptions(), limits));
    std::string words;
    for (const NightGate& gate : decision.gates) {
      if (!gate.passed) words += (words.empty() ? "" : "; ") + gate.text;
    }
    return words;
  }

  const CalibrateOptions& options_;
  CommandContext& context_;
  MachineConfig config_;
  RecordWords words_;
};

}  // namespace

Expected<Answer> spindle_camera(const CalibrateOptions& options, CommandContext& context) {
  return SpindleCamera(options, context).answer();
}

}  // namespace panelcal::calibrate
