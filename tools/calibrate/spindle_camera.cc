// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/kinds/spindle_camera.h"

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include "calib/drift/night_gates.h"
#include "machine/devices/cameras/camera_settings.h"
#include "machine/job/spindle_age.h"
#include "machine/nightly/record/noted_heads.h"
#include "tools/calibrate/devices.h"
#include "tools/calibrate/session.h"
#include "tools/calibrate/spindle_answer.h"
#include "tools/cli/operator_prompt.h"
#include "tools/cli/provenance.h"
#include <fmt/format.h>
#include <unistd.h>

namespace panelcal::calibrate {
namespace {

constexpr const char* kCalibrateSpindleCamera = "panelcal calibrate spindle-camera";

/// One call of `panelcal calibrate spindle-camera`.
class SpindleCamera {
 public:
  SpindleCamera(const CalibrateOptions& options, CommandContext& context, Session session)
      : options_(options), context_(context), session_(std::move(session)) {}

  Expected<Answer> answer() {
    PANELCAL_CHECK(prepare());
    PANELCAL_TRY(const Prompt prompt, prompt_of());
    PANELCAL_CHECK(session_.lock(true));
    // Before a ledger is begun beside files that note entries of another.
    PANELCAL_CHECK(check_noted_heads(config()));
    PANELCAL_TRY(const DeviceSet set, open_devices(options_, config(), context_.console));
    // Before a row of the coupon is used up.
    PANELCAL_CHECK(session_.open_ledger());
    if (session_.ledger() != nullptr) PANELCAL_CHECK(check_others(*session_.ledger()));
    const RecordWords& words = session_.words();
    CalibrationDevices devices = set.devices(prompt);
    devices.observer = progress();
    devices.taken_by = {fixed_clock(words.date), words.asked_by, words.software};
    PANELCAL_CHECK(set_camera_as_stated(config(), devices));
    PANELCAL_TRY(std::vector<LedgerInput> inputs, spindle_camera_inputs(config()));
    PANELCAL_TRY(const SpindleCameraRun run, calibrate_spindle_camera(config(), devices));
    context_.console.end_progress();
    SpindleAnswer answer = compare(config(), run);
    std::string refusal;
    if (options_.install) {
      refusal = trend_words(run.fit);
      if (refusal.empty()) {
        PANELCAL_TRY(refusal, gate_words(run, answer.gates));
      }
    }
    PANELCAL_TRY(LedgerDraft draft, spindle_camera_draft(config(), run, words, std::move(inputs)));
    PANELCAL_CHECK(
        session_.finish(std::move(draft), *spindle_camera_kind(session_.config()), refusal));
    answer.refusal = session_.refusal();
    answer.ledger_id = session_.entry();
    answer.is_installed = answer.ledger_id && answer.refusal.empty();
    return session_.answer(text(answer, run), spindle_facts(answer, run), context_);
  }

 private:
  MachineConfig& config() const { return *session_.config(); }

  Expected<void> prepare() {
    const SpindleSetting& setting = config().spindle_setting;
    PANELCAL_CHECK(select_spindle(
        config(),
        {options_.spindle.value_or(setting.spindle), options_.station.value_or(setting.station)}));
    PANELCAL_CHECK(check_begin());
    // An old date that is not valid does not prevent a new offset.
    static_cast<void>(age_offset(config(), session_.words().date));
    return session_.check_install("spindle", config().spindle_setting.file);
  }

  /// The file is written from the ledger, which would lose what it does not know.
  Expected<void> check_others(const Ledger& ledger) const {
    const SpindleSetting& setting = config().spindle_setting;
    PANELCAL_TRY(const std::vector<SpindleAt> by_hand, spindles_by_hand(config(), ledger));
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
    const SpindleSetting& setting = config().spindle_setting;
    if (setting.is_calibrated || setting.stated_offset) return {};
    return failure({Code::ConfigValue,
                    {config().file.string(), 0, 0},
                    "there is no start value for " + subject({setting.spindle, setting.station}),
                    "[spindle] camera_offset_mm"});
  }

  /// DeviceSet knows that no person lays anything on a simulated coupon.
  Expected<Prompt> prompt_of() const {
    const bool asks = config().coupon && config().coupon->has_entry_material && !options_.yes &&
                      options_.machine_driver.empty();
    if (options_.yes) return Prompt([](std::string_view) -> Expected<void> { return {}; });
    if (!asks) return Prompt();
    if (::isatty(STDIN_FILENO) != 1) {
      return failure(
          usage("the coupon needs entry material, and no person is at a terminal to lay it on",
                "--yes if it is dealt with",
                kCalibrateSpindleCamera));
    }
    return Prompt([this](std::string_view what) {
      return ask_operator(kCalibrateSpindleCamera, "Enter, or --yes", context_.console, what);
    });
  }

  PictureObserver progress() {
    if (!config().coupon) return {};
    const std::size_t n_pictures = config().coupon->looking.size() *
                                   static_cast<std::size_t>(config().coupon->columns) *
                                   static_cast<std::size_t>(config().coupon->rows_per_run);
    return [this, n_pictures, i = std::size_t{0}](const SeenView&) mutable {
      context_.console.progress(fmt::format("looking at the coupon: {} of {}", ++i, n_pictures));
    };
  }

  /// The one of the nights' gates that refuses it; empty if none does. Neither the trend, which is
  /// judged already, nor the temperature, which is not read here, is among them.
  Expected<std::string> gate_words(const SpindleCameraRun& run, facts::Json& gates) {
    NightLimits limits = config().nightly ? config().nightly->limits : NightLimits();
    limits.min_temperature_c.reset();
    limits.max_temperature_c.reset();
    NightResult result = spindle_camera_result(run);
    result.point.time = session_.words().date;
    result.structure_chance.reset();
    std::optional<Eigen::VectorXd> in_force;
    if (config().spindle_setting.is_calibrated) in_force = config().spindle_camera.offset.in_mm();
    const DriftSeries no_history = {{"x", "y"}, "mm", {}};
    PANELCAL_TRY(const NightDecision decision,
                 decide_night(result, in_force, no_history, DriftOptions(), limits));
    std::string words;
    for (const NightGate& gate : decision.gates) {
      gates.push_back({{"name", gate.name}, {"passed", gate.passed}, {"text", gate.text}});
      if (!gate.passed) words += (words.empty() ? "" : "; ") + gate.text;
    }
    return words;
  }

  const CalibrateOptions& options_;
  CommandContext& context_;
  Session session_;
};

}  // namespace

Expected<Answer> spindle_camera(const CalibrateOptions& options, CommandContext& context) {
  PANELCAL_TRY(Session session, Session::begin(options));
  // The rows of a coupon have a name, too.
  session.words().asked_by = asking_person(options.asked_by);
  return SpindleCamera(options, context, std::move(session)).answer();
}

}  // namespace panelcal::calibrate
