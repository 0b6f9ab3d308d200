// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "machine/calibrate/kinds/trials.h"
#include "machine/devices/cameras/camera_settings.h"
#include "machine/look/place_trials.h"
#include "machine/nightly/checks/self_test.h"
#include "tools/calibrate/devices.h"
#include "tools/calibrate/session.h"
#include <fmt/format.h>

// `panelcal calibrate focus|light|settle`: what is tried at one place with a mark.
namespace panelcal::calibrate {
namespace {

/// One call: the machine is locked before its devices are opened, and the result is recorded.
struct Trial {
  static Expected<Trial> begin(const CalibrateOptions& options, Console& console) {
    PANELCAL_TRY(Session session, Session::begin(options));
    PANELCAL_CHECK(session.lock(true));
    PANELCAL_CHECK(session.open_ledger());
    PANELCAL_TRY(PlaceDevices at, PlaceDevices::open(options, *session.config(), console));
    return Trial{options, std::move(session), std::move(at)};
  }

  const MachineConfig& config() const { return *session.config(); }

  /// Records it if that is wanted; `text` is what a person reads.
  Expected<Answer> answer(const TrialValue& found, std::string text, CommandContext& context) {
    facts::Json part = facts::Json::parse(found.details);
    if (options.install) text += read_the_temperature();
    PANELCAL_TRY(LedgerDraft draft,
                 trial_draft(config(), {at.place(), options.tool}, found, session.words()));
    PANELCAL_CHECK(session.finish(std::move(draft),
                                  *trial_kind(found.kind, session.config(), {}),
                                  found.value ? std::string() : found.reason));
    if (session.entry()) {
      text += fmt::format("  {} as ledger entry {}\n",
                          found.value ? "in force" : "refused, recorded",
                          *session.entry());
      if (found.value) {
        text += fmt::format("  the line for machine.toml: {}\n",
                            stated_line(found.kind, {*found.value, found.sigma}));
      }
    }
    // Lamp and focus stand where the last trial left them.
    if (!found.value && found.kind != LedgerKind::Settle) {
      PANELCAL_CHECK(set_camera_as_stated(config(), at.devices()));
    }
    PANELCAL_TRY(const std::string otherwise, otherwise_than_in_force(found.kind));
    if (!otherwise.empty()) {
      part["stated_otherwise"] = otherwise;
      text += "  " + otherwise + "\n";
    }
    return session.answer(std::move(text), std::move(part), context);
  }

  /// As a night reads it. One that cannot be read is said, and no reason to lose the rest.
  std::string read_the_temperature() {
    if (!config().nightly) return std::string();
    const auto read = read_temperature(*config().nightly);
    if (!read) return fmt::format("  the temperature is not known: {}\n", read.error().what);
    session.words().temperature_degC = *read;
    return std::string();
  }

  Expected<std::string> otherwise_than_in_force(LedgerKind kind) const {
    std::error_code ignored;
    const std::filesystem::path& file = config().ledger_file;
    if (file.empty() || !std::filesystem::exists(file, ignored)) return std::string();
    PANELCAL_TRY(const Ledger ledger, Ledger::open_to_read(file));
    return stated_otherwise(config(), ledger, kind);
  }

  const CalibrateOptions& options;
  Session session;
  PlaceDevices at;
};

Expected<FocusRange> range_of(const CalibrateOptions& options, const MachineConfig& config) {
  const std::optional<FocusRange>& may = config.vision.focus_range;
  if (options.range.size() == 2) {
    const FocusRange range = {mm(options.range[0]), mm(options.range[1])};
    if (!may || (range.low >= may->low && range.high <= may->high)) return range;
    return failure(usage(
        fmt::format("--range {:g},{:g} goes beyond where the focus axis may go",
                    options.range[0],
                    options.range[1]),
        fmt::format(
            "{:g} to {:g} mm, [camera] focus_range_mm", may->low.in_mm(), may->high.in_mm())));
  }
  if (may) return *may;
  return failure(
      usage("the range of heights is missing", "--range LOW,HIGH or [camera] focus_range_mm"));
}

std::string settle_text(const SettleRun& run, Length limit) {
  if (!run.settle) return fmt::format("no settle time: {}\n", run.reason);
  const SettleTime& settle = *run.settle;
  std::string text = fmt::format("settle_s = {:.3f}\n", settle.safe_wait().in_s());
  switch (settle.motion) {
    case SettleMotion::Still:
      text += "  at rest at once, as far as these views show\n";
      break;
    case SettleMotion::Creeping:
    case SettleMotion::Vibrating:
      text += fmt::format("  {}: {:.1f} um at most, time constant {:.3f} s",
                          settle.motion == SettleMotion::Creeping ? "creeping" : "swinging",
                          settle.amplitude.in_um(),
                          settle.time_constant.in_s());
      if (settle.frequency_hz > 0) text += fmt::format(", {:.1f} Hz", settle.frequency_hz);
      text += fmt::format("; below {:g} um after {:.3f} +- {:.3f} s\n",
                          limit.in_um(),
                          settle.wait.in_s(),
                          settle.sigma.in_s());
      for (const SettleAlias& alias : settle.aliases) {
        text +=
            fmt::format("  these views allow {:.1f} Hz as well: {:.3f} s, which settle_s covers\n",
                        alias.frequency_hz,
                        alias.wait.in_s());
      }
      break;
  }
  return text;
}

}  // namespace

Expected<Answer> focus(const CalibrateOptions& options, CommandContext& context) {
  PANELCAL_TRY(Trial trial, Trial::begin(options, context.console));
  const MachineConfig& config = trial.config();
  PANELCAL_TRY(const FocusRange range, range_of(options, config));
  PANELCAL_TRY(const FocusResult result,
               calibrate_focus(config, trial.at.devices(), trial.at.place(), options.tool, range));
  std::string text =
      result.is_found
          ? fmt::format("sharpest at {:.4f} +- {:.4f} mm\n", result.z.in_mm(), result.sigma.in_mm())
          : fmt::format("no sharpest height: {}\n", result.reason);
  for (const auto& sample : result.curve) {
    text += fmt::format("  {:>9.4f} mm  sharpness {:.5f}\n", sample.z.in_mm(), sample.sharpness);
  }
  return trial.answer(trial_value(result), std::move(text), context);
}

Expected<Answer> light(const CalibrateOptions& options, CommandContext& context) {
  const std::vector<double> range =
      options.range.size() == 2 ? options.range : std::vector<double>{10, 100};
  const std::vector<double> levels = lamp_levels(range[0], range[1], options.n_levels);
  PANELCAL_TRY(Trial trial, Trial::begin(options, context.console));
  PANELCAL_TRY(
      const LightRun run,
      calibrate_light(trial.config(), trial.at.devices(), trial.at.place(), options.tool, levels));
  std::string text =
      run.best ? fmt::format("best lamp level {:g}, contrast {:.3f} of full scale{}\n",
                             run.best->level,
                             run.best->contrast,
                             run.best->is_at_end ? "; it is the brightest that was tried" : "")
               : fmt::format("no lamp level will do: {}\n", run.reason);
  for (const LampSample& sample : run.samples) {
    text += fmt::format("  level {:>7g}  contrast {:.3f}  clipped {:.3f} %\n",
                        sample.level,
                        sample.contrast,
                        100 * sample.clipped_share);
  }
  return trial.answer(trial_value(run), std::move(text), context);
}

Expected<Answer> settle(const CalibrateOptions& options, CommandContext& context) {
  PANELCAL_TRY(Trial trial, Trial::begin(options, context.console));
  SettleTrial trial_options;
  trial_options.tool = options.tool;
  trial_options.limit = um(options.limit_um);
  trial_options.longest = seconds(options.longest_s);
  PANELCAL_TRY(
      const SettleRun run,
      calibrate_settle(trial.config(), trial.at.devices(), trial.at.place(), trial_options));
  return trial.answer(trial_value(run), settle_text(run, trial_options.limit), context);
}

}  // namespace panelcal::calibrate
