// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "machine/calibrate/place_record.h"
#include "machine/devices/cameras/camera_settings.h"
#include "machine/look/mark_sights.h"
#include "machine/look/place_trials.h"
#include "machine/nightly/calibrations/night_calibrations.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

Eigen::VectorXd only(double number) {
  return Eigen::VectorXd::Constant(1, number);
}

/// Focus, lamp level or settle time: one number of the mark, which no file has. To install it is to
/// record it; machine.toml stays what a person writes, and the night says where the two disagree.
class TrialNight final : public NightCalibration {
 public:
  TrialNight(TrialKind kind, std::shared_ptr<MachineConfig> config, const NightlyConfig& nightly)
      : kind_(kind),
        config_(std::move(config)),
        place_{*nightly.mark, nightly.mark_tool},
        mark_place_(nightly.mark_place),
        trials_(nightly.trials),
        stated_wait_(config_->settle) {}

  LedgerKey key() const override { return trial_key(*config_, kind_); }
  std::vector<std::string> axes() const override { return {trial_parameter(kind_)}; }
  std::string unit() const override { return trial_unit(kind_); }
  std::filesystem::path file() const override { return {}; }
  // machine.toml has a bound (a wait) or an operator's guess, and no estimate: what was
  // measured is only held against what was measured.
  std::optional<Eigen::VectorXd> present() const override { return std::nullopt; }
  Expected<std::vector<SelfTestCheck>> check() const override;
  int n_qualities() const override { return kind_ == TrialKind::Settle ? 0 : 1; }
  bool may_explain_pictures() const override { return kind_ != TrialKind::Settle; }
  NightlyConfig held_to(const NightlyConfig& nightly) const override;
  std::optional<LedgerValues> value_of(const LedgerEntry& entry) const override {
    const auto number = trial_number(entry);
    if (!number) return std::nullopt;
    return LedgerValues{only(number->value), only(number->sigma * number->sigma)};
  }
  Expected<NightMeasurement> measure(const CalibrationDevices& devices,
                                     const RecordWords& words) override;
  Expected<std::string> stated_otherwise(const Ledger& ledger) const override {
    MachineConfig as_written = *config_;
    as_written.settle = stated_wait_;
    return panelcal::stated_otherwise(as_written, ledger, kind_);
  }
  // There is no file that could say anything else.
  Expected<bool> is_installed(const Ledger& /*ledger*/) const override { return true; }
  Expected<std::string> by_hand(const Ledger& /*ledger*/) const override { return std::string(); }
  Expected<bool> install(const Ledger& ledger) override;

 private:
  /// The steps after this wait so long, if machine.toml waits less: more costs time and nothing
  /// else, and of a table that swings nothing is measured.
  void wait_at_least(Time wait) { config_->settle = std::max(config_->settle, wait); }
  double tolerance() const { return trial_tolerance(trials_, kind_); }
  SettleTrial settle_trial() const;
  Expected<TrialValue> find(const CalibrationDevices& devices, NightMeasurement& out);
  Expected<TrialValue> find_focus(const CalibrationDevices& devices, NightMeasurement& out) const;
  Expected<TrialValue> find_light(const CalibrationDevices& devices, NightMeasurement& out) const;
  Expected<TrialValue> find_settle(const CalibrationDevices& devices, NightMeasurement& out);

  TrialKind kind_;
  std::shared_ptr<MachineConfig> config_;
  TrialPlace place_;
  Place mark_place_;
  NightTrials trials_;
  Time stated_wait_;  ///< [machine] settle_s
};

SettleTrial TrialNight::settle_trial() const {
  SettleTrial trial;
  trial.tool = place_.tool;
  trial.limit = trials_.settle_limit;
  trial.longest = trials_.settle_longest;
  return trial;
}

Expected<std::vector<SelfTestCheck>> TrialNight::check() const {
  const std::vector<SelfTestCheck> none;
  if (kind_ != TrialKind::Settle) return none;
  const Length way = settle_trial().way;
  for (const double direction : {-1.0, 1.0}) {
    const Position<frame::Machine> from =
        config_->spindle_camera.spindle_to_see(place_.mark) +
        displacement_mm<frame::Machine>(Eigen::Vector2d::Constant(direction * way.in_mm()));
    if (is_in_travel(*config_, from)) continue;
    return failure({Code::ConfigValue,
                    mark_place_,
                    fmt::format("[nightly] calibrates the settle time with moves of {:g} mm to the "
                                "mark, which lies too near to the end of the travel",
                                way.in_mm()),
                    "mark_mm farther inside"});
  }
  return none;
}

/// Lengths at a hole mean nothing here: the defaults of [nightly.gates] and [nightly.drift], in the
/// proportion of this tolerance to theirs.
NightlyConfig TrialNight::held_to(const NightlyConfig& nightly) const {
  const NightlyConfig usual;
  const double factor = tolerance() / usual.limits.old.tolerance;
  NightlyConfig out = nightly;
  out.limits.sigma = factor * usual.limits.sigma;
  out.limits.change = factor * usual.limits.change;
  out.limits.old.tolerance = tolerance();
  out.limits.min_used = 1;
  if (kind_ == TrialKind::Settle) {
    // Two sigmas are added to what machine.toml should wait: a wide one costs time and nothing
    // else.
    out.limits.sigma = tolerance();
    // Of a table that still swings the first pictures may show no mark.
    const SettleTrial trial = settle_trial();
    const int n_views = trial.n_delays * trial.n_moves;
    out.limits.min_used = n_views / 2;
    out.limits.max_outliers = n_views / 4;
  }
  DriftPriors& priors = out.drift.priors;
  priors.drift = factor * usual.drift.priors.drift;
  priors.repeatability = factor * usual.drift.priors.repeatability;
  priors.per_kelvin = factor * usual.drift.priors.per_kelvin;
  out.watch.moved = factor * *usual.watch.moved;
  return out;
}

Expected<TrialValue> TrialNight::find_focus(const CalibrationDevices& devices,
                                            NightMeasurement& out) const {
  PANELCAL_TRY(
      const FocusResult result,
      calibrate_focus(*config_, devices, place_.mark, place_.tool, *config_->vision.focus_range));
  out.result.n_used = static_cast<int>(result.curve.size());
  double sharpest = 0;
  for (const auto& sample : result.curve) sharpest = std::max(sharpest, sample.sharpness);
  if (sharpest > 0) out.levels = {{"sharpness of the mark", "1", sharpest, true}};
  return trial_value(result);
}

Expected<TrialValue> TrialNight::find_light(const CalibrationDevices& devices,
                                            NightMeasurement& out) const {
  const auto levels = lamp_levels(trials_.lamp_low, trials_.lamp_high, trials_.n_lamp_levels);
  PANELCAL_TRY(const LightRun run,
               calibrate_light(*config_, devices, place_.mark, place_.tool, levels));
  out.result.n_used = static_cast<int>(run.samples.size());
  // The level that jobs look with: that of the best one jumps with it.
  const auto stated = std::ranges::min_element(run.samples, {}, [&](const LampSample& sample) {
    return std::abs(sample.level - *config_->vision.lamp);
  });
  if (stated != run.samples.end() && stated->contrast > 0) {
    out.levels = {{"contrast of the mark", "1", stated->contrast, true}};
  }
  if (run.best) {
    if (run.best->is_at_end) out.report.emplace_back("it is the brightest that was tried");
  }
  return trial_value(run);
}

Expected<TrialValue> TrialNight::find_settle(const CalibrationDevices& devices,
                                             NightMeasurement& out) {
  PANELCAL_TRY(const SettleRun run,
               calibrate_settle(*config_, devices, place_.mark, settle_trial()));
  wait_at_least(run.settle ? run.settle->safe_wait() : trials_.settle_longest);
  if (config_->settle > stated_wait_) {
    out.report.push_back(fmt::format("the rest of this night waits {:.3f} s, not {:.3f} s",
                                     config_->settle.in_s(),
                                     stated_wait_.in_s()));
  }
  out.result.n_used = static_cast<int>(run.views.size());
  out.result.n_outliers = run.n_missed;
  return trial_value(run);
}

Expected<TrialValue> TrialNight::find(const CalibrationDevices& devices, NightMeasurement& out) {
  switch (kind_) {
    case TrialKind::Focus:
      return find_focus(devices, out);
    case TrialKind::Light:
      return find_light(devices, out);
    case TrialKind::Settle:
      break;
  }
  return find_settle(devices, out);
}

Expected<NightMeasurement> TrialNight::measure(const CalibrationDevices& devices,
                                               const RecordWords& words) {
  NightMeasurement out;
  out.result.used = "pictures";
  const Expected<TrialValue> found = find(devices, out);
  // Whatever came of it: the next calibration, and the first job, see as they did before.
  const Expected<void> is_back = set_camera_as_stated(*config_, devices);
  PANELCAL_CHECK(is_back);
  if (!found) return failure(found.error());
  if (!found->value) {
    return failure(
        {Code::CalibrationData, {config_->file.string(), 0, 0}, found->reason, "a number"});
  }
  out.result.point.value = only(*found->value);
  out.result.point.cov = only(found->sigma * found->sigma);
  PANELCAL_TRY(out.draft, trial_draft(*config_, place_, *found, words));
  out.report.insert(out.report.begin(),
                    fmt::format("{} {:.4g} +- {:.2g} {}; in machine.toml {}",
                                trial_parameter(kind_),
                                *found->value,
                                found->sigma,
                                trial_unit(kind_),
                                stated_line(kind_, {*found->value, found->sigma})));
  return out;
}

/// There is no file; but this night waits at least as long as the value in force.
Expected<bool> TrialNight::install(const Ledger& ledger) {
  if (kind_ != TrialKind::Settle) return false;
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key()));
  const auto number = in_force ? trial_number(*in_force) : std::nullopt;
  if (number) wait_at_least(seconds(number->value + 2 * number->sigma));
  return false;
}

std::string_view trial_words(TrialKind kind) {
  switch (kind) {
    case TrialKind::Focus:
      return "focus";
    case TrialKind::Light:
      return "light";
    case TrialKind::Settle:
      break;
  }
  return "settle time";
}

/// Problem of a missing key, by kind; empty if there is none.
Diagnostic missing(TrialKind kind, const MachineConfig& config, const NightlyConfig& nightly) {
  Diagnostic out = {Code::ConfigValue, nightly.place, {}, {}};
  const VisionOptions& vision = config.vision;
  const SimConfig* const sim = nightly.is_simulated && config.sim ? &*config.sim : nullptr;
  const auto virtual_lacks = [&](std::string_view what, std::string_view key) {
    out.what = fmt::format(
        "[nightly] calibrates the {}, and the virtual machine {}", trial_words(kind), what);
    out.expected = key;
  };
  if (sim != nullptr && !sim->coupon.mark) {
    virtual_lacks("has no mark", "[sim.coupon] mark_mm");
  } else if (sim != nullptr && kind == TrialKind::Focus && !sim->focus_z) {
    virtual_lacks("is sharp at any height", "[sim] focus_z_mm");
  } else if (sim != nullptr && kind == TrialKind::Light && !sim->lamp) {
    virtual_lacks("sees the same with any lamp", "[sim] lamp");
  } else if (kind == TrialKind::Focus && !vision.focus_range) {
    out.what = "[nightly] calibrates the focus, and the range of heights is missing";
    out.expected = "[camera] focus_range_mm";
  } else if (kind == TrialKind::Focus && !vision.focus) {
    out.what = "[nightly] calibrates the focus, and the height to go back to is missing";
    out.expected = "[camera] focus_mm";
  } else if (kind == TrialKind::Light && !vision.lamp) {
    out.what = "[nightly] calibrates the light, and the lamp level to go back to is missing";
    out.expected = "[camera] lamp";
  }
  return out;
}

}  // namespace

namespace internal {

Expected<std::unique_ptr<NightCalibration>> trial_night(TrialKind kind,
                                                        std::shared_ptr<MachineConfig> config,
                                                        const NightlyConfig& nightly) {
  Diagnostic problem = missing(kind, *config, nightly);
  if (problem.what.empty() && !nightly.mark) {
    problem.what = "[nightly] calibrates at a mark, and mark_mm is missing";
    problem.expected = "mark_mm = [x, y]";
  } else if (problem.what.empty() && !config->camera) {
    problem.what = "[nightly] calibrates at a mark, and there is no camera to see it";
    problem.expected = "[camera] calibration";
  } else if (problem.what.empty() && !config->vision_tools.contains(nightly.mark_tool)) {
    problem.what = fmt::format("there is no vision tool {} to find the mark", nightly.mark_tool);
    problem.expected = "a [[vision.tool]] of that number";
  }
  if (!problem.what.empty()) return failure(std::move(problem));
  return std::make_unique<TrialNight>(kind, std::move(config), nightly);
}

}  // namespace internal

}  // namespace panelcal
