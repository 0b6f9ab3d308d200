// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/kinds/trials.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal {
namespace {

using internal::trial_of;
using internal::trial_tolerance;
using internal::TrialRow;

constexpr std::array<TrialRow, 3> kTrials = {{
    {LedgerKind::Focus, "focus", "camera", "height", "mm", "camera", "focus_mm"},
    {LedgerKind::Light, "light", "camera", "level", "level", "camera", "lamp"},
    {LedgerKind::Settle, "settle time", "stage", "wait", "s", "machine", "settle_s"},
}};

/// The value in machine.toml now.
std::optional<double> stated_number(const MachineConfig& config, LedgerKind kind) {
  if (kind == LedgerKind::Settle) return config.settle.in_s();
  if (kind == LedgerKind::Light) return config.vision.lamp;
  return config.vision.focus ? std::optional(config.vision.focus->in_mm()) : std::nullopt;
}

std::string place_json_text(const nlohmann::ordered_json& json, int indent = -1) {
  // Text that is no UTF-8 must not throw.
  return json.dump(indent, ' ', true, nlohmann::json::error_handler_t::replace);
}

/// The wider step from the best level to one that was tried beside it.
double step_about(const LightRun& run) {
  double wider = 0;
  for (std::size_t i = 1; i < run.samples.size(); ++i) {
    const double low = run.samples[i - 1].level;
    const double high = run.samples[i].level;
    if (low == run.best->level || high == run.best->level) wider = std::max(wider, high - low);
  }
  return wider;
}

/// A time on the safe side of its milliseconds.
double up_to_ms(double time_s) {
  return std::ceil(time_s * 1e3) * 1e-3;
}

bool keeps_to(const MachineConfig& config, const TrialRow& trial, const TrialNumber& number) {
  const std::optional<double> stated = stated_number(config, trial.kind);
  if (!stated) return false;
  // A longer wait costs time and nothing else; the two sigmas are there to be used up.
  if (trial.kind == LedgerKind::Settle) return *stated >= number.value;
  const NightTrials trials = config.nightly ? config.nightly->trials : NightTrials();
  return std::abs(*stated - number.value) <= trial_tolerance(trials, trial.kind);
}

}  // namespace

const internal::TrialRow& internal::trial_of(LedgerKind kind) {
  return *std::ranges::find(kTrials, kind, &TrialRow::kind);
}

TrialValue trial_value(const FocusResult& result) {
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
  TrialValue out = {LedgerKind::Focus, {}, 0, result.reason, place_json_text(json)};
  if (!result.is_found) return out;
  out.value = result.z.in_mm();
  out.sigma = result.sigma.in_mm();
  return out;
}

TrialValue trial_value(const LightRun& run) {
  TrialValue out = {LedgerKind::Light, {}, 0, run.reason, {}};
  nlohmann::ordered_json json;
  json["found"] = run.best.has_value();
  if (run.best) {
    out.value = run.best->level;
    out.sigma = step_about(run) / std::sqrt(12.0);
    json["level"] = run.best->level;
    json["sigma"] = out.sigma;
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
  out.details = place_json_text(json);
  return out;
}

TrialValue trial_value(const SettleRun& run) {
  TrialValue out = {LedgerKind::Settle, {}, 0, run.reason, {}};
  nlohmann::ordered_json json;
  json["found"] = run.settle.has_value();
  if (run.settle) {
    out.value = run.settle->wait.in_s();
    // The value for machine.toml is two sigmas more, and is to reach the bound.
    out.sigma = 0.5 * (run.settle->safe_wait() - run.settle->wait).in_s();
    json["settle_s"] = run.settle->safe_wait().in_s();
    json["wait_s"] = run.settle->wait.in_s();
    json["sigma_s"] = run.settle->sigma.in_s();
    json["time_constant_s"] = run.settle->time_constant.in_s();
    json["frequency_hz"] = run.settle->frequency_hz;
    json["amplitude_um"] = run.settle->amplitude.in_um();
    json["aliases"] = nlohmann::ordered_json::array();
    for (const SettleAlias& alias : run.settle->aliases) {
      json["aliases"].push_back(
          {{"wait_s", alias.wait.in_s()}, {"frequency_hz", alias.frequency_hz}});
    }
  } else {
    json["reason"] = run.reason;
  }
  json["missed"] = run.n_missed;
  out.details = place_json_text(json);
  return out;
}

LedgerKey trial_key(const MachineConfig& config, LedgerKind kind) {
  return {machine_name(config), kind, std::string(trial_of(kind).subject)};
}

Expected<LedgerDraft> trial_draft(const MachineConfig& config,
                                  const TrialPlace& place,
                                  const TrialValue& found,
                                  const RecordWords& words) {
  const TrialRow& trial = trial_of(found.kind);
  PANELCAL_TRY(LedgerDraft draft, draft_of(config, trial_key(config, found.kind), words));
  LedgerRecord& record = draft.record;
  PANELCAL_CHECK(add_inputs({config.camera_file}, record.inputs));
  if (found.value) {
    record.parameters = {{std::string(trial.parameter), *found.value, std::string(trial.unit)}};
    record.covariance = Eigen::MatrixXd::Constant(1, 1, found.sigma * found.sigma);
  } else {
    record.verdict = LedgerVerdict::Refused;
    record.reason = found.reason;
  }
  const Eigen::Vector2d& mark_mm = place.mark.in_mm();
  nlohmann::ordered_json result = {{"kind", word(trial.kind)},
                                   {"version", 1},
                                   {"date", iso_8601(words.date)},
                                   {"provenance", words.software},
                                   {"mark_mm", {mark_mm.x(), mark_mm.y()}},
                                   {"tool", place.tool}};
  result.update(nlohmann::ordered_json::parse(found.details));
  draft.result = place_json_text(result, 2) + "\n";
  return draft;
}

std::optional<TrialNumber> trial_number(const LedgerEntry& entry) {
  const auto trial = std::ranges::find(kTrials, entry.record.key.kind, &TrialRow::kind);
  if (trial == kTrials.end()) return std::nullopt;
  const std::string_view name = trial->parameter;
  const auto found = values_of(entry.record, {&name, 1});
  const auto i = entry.record.find(name);
  if (!found || entry.record.parameters[*i].unit != trial->unit) return std::nullopt;
  return TrialNumber{found->value[0], std::sqrt(found->cov(0, 0))};
}

double internal::trial_tolerance(const NightTrials& trials, LedgerKind kind) {
  if (kind == LedgerKind::Focus) return trials.focus_tolerance.in_mm();
  // Luck decides which of two levels side by side is the better one.
  if (kind == LedgerKind::Light) return 2 * trials.lamp_step();
  return trials.settle_tolerance.in_s();
}

std::string stated_line(LedgerKind kind, const TrialNumber& number) {
  const TrialRow& trial = trial_of(kind);
  std::string value = fmt::format("{:g}", number.value);
  if (kind == LedgerKind::Focus) value = fmt::format("{:.3f}", number.value);
  if (kind == LedgerKind::Settle) {
    value = fmt::format("{:.3f}", up_to_ms(number.value + 2 * number.sigma));
  }
  return fmt::format("[{}] {} = {}", trial.table, trial.key, value);
}

Expected<std::string> stated_otherwise(const MachineConfig& config,
                                       const Ledger& ledger,
                                       LedgerKind kind) {
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(trial_key(config, kind)));
  const auto number = in_force ? trial_number(*in_force) : std::nullopt;
  const TrialRow& trial = trial_of(kind);
  if (!number || keeps_to(config, trial, *number)) return std::string();
  const std::optional<double> stated = stated_number(config, trial.kind);
  return fmt::format(
      "machine.toml says {}, and entry {} of the ledger, in force since {}, {} {}: "
      "write {}; or, if machine.toml is newer, calibrate {} --install",
      stated ? fmt::format("{} = {:g}", trial.key, *stated) : fmt::format("no {}", trial.key),
      in_force->id,
      iso_8601(in_force->time),
      kind == LedgerKind::Settle ? "waits at least" : "says",
      fmt::format("{:.4g} +- {:.2g} {}", number->value, number->sigma, trial.unit),
      stated_line(kind, *number),
      word(trial.kind));
}

}  // namespace panelcal
