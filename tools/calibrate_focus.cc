// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "panelcal/machine/place_trials.h"
#include "panelcal/tools/calibrate.h"
#include "panelcal/tools/calibrate_place.h"

// `panelcal calibrate focus|light|settle`: what is tried at one place with a mark.
namespace panelcal::calibrate {
namespace {

Diagnostic usage(std::string what, std::string expected) {
  return {Code::Usage, {"panelcal calibrate", 0, 0}, std::move(what), std::move(expected)};
}

Time steady_now() {
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  return seconds(std::chrono::duration<double>(since).count());
}

/// Nothing was found, and nothing is to be used.
ExitCode code_of(bool is_found) {
  return is_found ? ExitCode::Done : ExitCode::GateFailed;
}

std::string line(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) + "\n";
}

Expected<FocusRange> range_of(const CalibrateOptions& options, const MachineConfig& config) {
  if (options.range.size() == 2) return FocusRange{mm(options.range[0]), mm(options.range[1])};
  if (config.vision.focus_range) return *config.vision.focus_range;
  return failure(usage("nothing says between which heights to look",
                       "--range LOW,HIGH or [camera] focus_range_mm"));
}

}  // namespace

Expected<Answer> focus(const CalibrateOptions& options, CommandContext& /*context*/) {
  PANELCAL_TRY(const MachineConfig config, read_machine_config(options.machine));
  PANELCAL_TRY(PlaceDevices at, PlaceDevices::open(options, config));
  PANELCAL_TRY(const FocusRange range, range_of(options, config));
  PANELCAL_TRY(const FocusResult result,
               calibrate_focus(config, at.devices(), at.place(), options.tool, range));
  if (options.json) {
    nlohmann::ordered_json json;
    json["found"] = result.is_found;
    if (result.is_found) {
      json["z_mm"] = result.z.in_mm();
      json["sigma_mm"] = result.sigma.in_mm();
    } else {
      json["reason"] = result.reason;
    }
    json["curve"] = nlohmann::ordered_json::array();
    for (const auto& sample : result.curve) {
      json["curve"].push_back({sample.z.in_mm(), sample.sharpness});
    }
    return Answer{line(json), code_of(result.is_found)};
  }
  std::string text =
      result.is_found
          ? fmt::format("sharpest at {:.4f} +- {:.4f} mm\n", result.z.in_mm(), result.sigma.in_mm())
          : fmt::format("no sharpest height: {}\n", result.reason);
  for (const auto& sample : result.curve) {
    text += fmt::format("  {:>9.4f} mm  sharpness {:.5f}\n", sample.z.in_mm(), sample.sharpness);
  }
  return Answer{std::move(text), code_of(result.is_found)};
}

Expected<Answer> light(const CalibrateOptions& options, CommandContext& /*context*/) {
  const std::vector<double> range =
      options.range.size() == 2 ? options.range : std::vector<double>{10, 100};
  std::vector<double> levels;
  for (int i = 0; i < options.n_levels; ++i) {
    levels.push_back(range[0] + (range[1] - range[0]) * i / (options.n_levels - 1));
  }
  PANELCAL_TRY(const MachineConfig config, read_machine_config(options.machine));
  PANELCAL_TRY(PlaceDevices at, PlaceDevices::open(options, config));
  PANELCAL_TRY(const LightRun run,
               calibrate_light(config, at.devices(), at.place(), options.tool, levels));
  if (options.json) {
    nlohmann::ordered_json json;
    json["found"] = run.best.has_value();
    if (run.best) {
      json["level"] = run.best->level;
      json["contrast"] = run.best->contrast;
      json["is_at_end"] = run.best->is_at_end;
    } else {
      json["reason"] = run.reason;
    }
    json["samples"] = nlohmann::ordered_json::array();
    for (const LampSample& sample : run.samples) {
      json["samples"].push_back({{"level", sample.level},
                                 {"contrast", sample.contrast},
                                 {"clipped_share", sample.clipped_share}});
    }
    return Answer{line(json), code_of(run.best.has_value())};
  }
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
  return Answer{std::move(text), code_of(run.best.has_value())};
}

Expected<Answer> settle(const CalibrateOptions& options, CommandContext& /*context*/) {
  PANELCAL_TRY(const MachineConfig config, read_machine_config(options.machine));
  PANELCAL_TRY(PlaceDevices at, PlaceDevices::open(options, config));
  SettleTrial trial;
  trial.tool = options.tool;
  trial.limit = um(options.limit_um);
  trial.longest = seconds(options.longest_s);
  CalibrationDevices devices = at.devices();
  PANELCAL_TRY(const SettleRun run,
               calibrate_settle(config, devices, at.place(), trial, steady_now));
  if (options.json) {
    nlohmann::ordered_json json;
    json["found"] = run.settle.has_value();
    if (run.settle) {
      json["settle_s"] = run.settle->safe_wait().in_s();
      json["wait_s"] = run.settle->wait.in_s();
      json["sigma_s"] = run.settle->sigma.in_s();
      json["time_constant_s"] = run.settle->time_constant.in_s();
      json["frequency_hz"] = run.settle->frequency_hz;
      json["amplitude_um"] = run.settle->amplitude.in_um();
    } else {
      json["reason"] = run.reason;
    }
    json["missed"] = run.n_missed;
    return Answer{line(json), code_of(run.settle.has_value())};
  }
  if (!run.settle) {
    return Answer{fmt::format("no settle time: {}\n", run.reason), ExitCode::GateFailed};
  }
  const SettleTime& settle = *run.settle;
  std::string text = fmt::format("settle_s = {:.3f}\n", settle.safe_wait().in_s());
  switch (settle.motion) {
    case SettleMotion::Still:
      text += "  at rest at once, as far as these views can tell\n";
      break;
    case SettleMotion::Creeping:
    case SettleMotion::Vibrating:
      text += fmt::format("  {}: {:.1f} um at most, time constant {:.3f} s",
                          settle.motion == SettleMotion::Creeping ? "creeping" : "swinging",
                          settle.amplitude.in_um(),
                          settle.time_constant.in_s());
      if (settle.frequency_hz > 0) text += fmt::format(", {:.1f} Hz", settle.frequency_hz);
      text += fmt::format("; below {:g} um after {:.3f} +- {:.3f} s\n",
                          options.limit_um,
                          settle.wait.in_s(),
                          settle.sigma.in_s());
      break;
  }
  return Answer{std::move(text), ExitCode::Done};
}

}  // namespace panelcal::calibrate
