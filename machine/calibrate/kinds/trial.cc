// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "machine/calibrate/kinds/parts.h"
#include "machine/calibrate/kinds/trials.h"
#include "machine/devices/cameras/camera_settings.h"
#include "machine/look/mark_sights.h"
#include "machine/look/place_trials.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::trial_of;
using internal::TrialRow;

Eigen::VectorXd only(double number) {
  return Eigen::VectorXd::Constant(1, number);
}

/// Focus, lamp level or settle time: one number of the mark, which no file has. To install it is to
/// record it; machine.toml stays what a person writes, and the night says where the two disagree.
class TrialKind final : public Calibration {
 public:
  TrialKind(LedgerKind kind, std::shared_ptr<MachineConfig> config, const NightlyConfig& nightly)
      : trial_(trial_of(kind)),
        config_(std::move(config)),
        place_{nightly.mark.value_or(Position<frame::Machine>()), nightly.mark_tool},
        mark_place_(nightly.mark_place),
        trials_(nightly.trials),
        stated_wait_(config_->settle) {}

  LedgerKey key() const override { return trial_key(*config_, trial_.kind); }
  std::vector<std::string> axes() const override { return {std::string(trial_.parameter)}; }
  std::string unit() const override { return std::string(trial_.unit); }
  // present() is absent: machine.toml has a bound (a wait) or an operator's guess, and no estimate.
  // What was measured is only held against what was measured.
  Expected<std::vector<SelfTestCheck>> check() const override;
  int n_qualities() const override { return trial_.kind == LedgerKind::Settle ? 0 : 1; }
  bool may_explain_pictures() const override { return trial_.kind != LedgerKind::Settle; }
  NightlyConfig held_to(const NightlyConfig& nightly) const override;
  std::optional<LedgerValues> value_of(const LedgerEntry& entry) const override {
    const auto number = trial_number(entry);
    if (!number) return std::nullopt;
    return LedgerValues{only(number->value), only(number->sigma * number->sigma)};
  }
  Expected<CalibrationResult> measure(const CalibrationDevices& devices,
                                      const RecordWords& words) override;
  Expected<std::string> stated_otherwise(const Ledger& ledger) const override {
    MachineConfig as_written = *config_;
    as_written.settle = stated_wait_;
    return panelcal::stated_otherwise(as_written, ledger, trial_.kind);
  }

 protected:
  Expected<void> begin_there(const Ledger& ledger) override;

 private:
  /// The steps after this wait so long, if machine.toml waits less: more costs time and nothing
  /// else, and of a table that swings nothing is measured.
  void wait_at_least(Time wait) { config_->settle = std::max(config_->settle, wait); }
  double tolerance() const { return internal::trial_tolerance(trials_, trial_.kind); }
  SettleTrial settle_trial() const;
  Expected<TrialValue> find(const CalibrationDevices& devices, CalibrationResult& out);
  Expected<TrialValue> find_focus(const CalibrationDevices& devices, CalibrationResult& out) const;
  Expected<TrialValue> find_light(const CalibrationDevices& devices, CalibrationResult& out) const;
  Expected<TrialValue> find_settle(const CalibrationDevices& devices, CalibrationResult& out);

  const TrialRow& trial_;
  std::shared_ptr<MachineConfig> config_;
  TrialPlace place_;
  Place mark_place_;
  NightTrials trials_;
  Time stated_wait_;  ///< [machine] settle_s
};

SettleTrial TrialKind::settle_trial() const {
  SettleTrial trial;
  trial.tool = place_.tool;
  trial.limit = trials_.settle_limit;
  trial.longest = trials_.settle_longest;
  return trial;
}

Expected<std::vector<SelfTestCheck>> TrialKind::check() const {
  const std::vector<SelfTestCheck> none;
  if (trial_.kind != LedgerKind::Settle) return none;
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
NightlyConfig TrialKind::held_to(const NightlyConfig& nightly) const {
  const NightlyConfig usual;
  const double factor = tolerance() / usual.limits.old.tolerance;
  NightlyConfig out = nightly;
  out.limits.sigma = factor * usual.limits.sigma;
  out.limits.change = factor * usual.limits.change;
  out.limits.old.tolerance = tolerance();
  out.limits.min_used = 1;
  if (trial_.kind == LedgerKind::Settle) {
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

Expected<TrialValue> TrialKind::find_focus(const CalibrationDevices& devices,
                                           CalibrationResult& out) const {
  PANELCAL_TRY(
      const FocusResult result,
      calibrate_focus(*config_, devices, place_.mark, place_.tool, *config_->vision.focus_range));
  out.result.n_used = static_cast<int>(result.curve.size());
  double sharpest = 0;
  for (const auto& sample : result.curve) sharpest = std::max(sharpest, sample.sharpness);
  if (sharpest > 0) out.levels = {{"sharpness of the mark", "1", sharpest, true}};
  return trial_value(result);
}

Expected<TrialValue> TrialKind::find_light(const CalibrationDevices& devices,
                                           CalibrationResult& out) const {
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

Expected<TrialValue> TrialKind::find_settle(const CalibrationDevices& devices,
                                            CalibrationResult& out) {
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

Expected<TrialValue> TrialKind::find(const CalibrationDevices& devices, CalibrationResult& out) {
  if (trial_.kind == LedgerKind::Focus) return find_focus(devices, out);
  if (trial_.kind == LedgerKind::Light) return find_light(devices, out);
  return find_settle(devices, out);
}

Expected<CalibrationResult> TrialKind::measure(const CalibrationDevices& devices,
                                               const RecordWords& words) {
  CalibrationResult out;
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
                                trial_.parameter,
                                *found->value,
                                found->sigma,
                                trial_.unit,
                                stated_line(trial_.kind, {*found->value, found->sigma})));
  return out;
}

/// There is no file; but this night waits at least as long as the value in force.
Expected<void> TrialKind::begin_there(const Ledger& ledger) {
  if (trial_.kind != LedgerKind::Settle) return {};
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key()));
  const auto number = in_force ? trial_number(*in_force) : std::nullopt;
  if (number) wait_at_least(seconds(number->value + 2 * number->sigma));
  return {};
}

}  // namespace

std::unique_ptr<Calibration> trial_kind(LedgerKind kind,
                                        std::shared_ptr<MachineConfig> config,
                                        const NightlyConfig& nightly) {
  return std::make_unique<TrialKind>(kind, std::move(config), nightly);
}

namespace internal {

Expected<Calibrations> trial_calibrations(LedgerKind kind,
                                          const std::shared_ptr<MachineConfig>& config,
                                          const NightlyConfig& nightly) {
  const std::string begin = fmt::format("[nightly] calibrates the {}, and ", trial_of(kind).words);
  const Missing missing = {nightly, begin};
  const VisionOptions& vision = config->vision;
  const bool is_focus = kind == LedgerKind::Focus;
  const bool is_light = kind == LedgerKind::Light;
  if (nightly.is_simulated && config->sim) {
    const SimConfig& sim = *config->sim;
    if (!sim.coupon.mark) return missing("the virtual machine has no mark", "[sim.coupon] mark_mm");
    if (is_focus && !sim.focus_z) {
      return missing("the virtual machine is sharp at any height", "[sim] focus_z_mm");
    }
    if (is_light && !sim.lamp) {
      return missing("the virtual machine sees the same with any lamp", "[sim] lamp");
    }
  }
  if (is_focus && !vision.focus_range) {
    return missing("the range of heights is missing", "[camera] focus_range_mm");
  }
  if (is_focus && !vision.focus) {
    return missing("the height to go back to is missing", "[camera] focus_mm");
  }
  if (is_light && !vision.lamp) {
    return missing("the lamp level to go back to is missing", "[camera] lamp");
  }
  const Missing at_mark = {nightly, "[nightly] calibrates at a mark, and "};
  if (!nightly.mark) return at_mark("mark_mm is missing", "mark_mm = [x, y]");
  if (!config->camera) return at_mark("there is no camera to see it", "[camera] calibration");
  if (!config->vision_tools.contains(nightly.mark_tool)) {
    return Missing{nightly, ""}(
        fmt::format("there is no vision tool {} to find the mark", nightly.mark_tool),
        "a [[vision.tool]] of that number");
  }
  return only_calibration(trial_kind(kind, config, nightly));
}

}  // namespace internal

}  // namespace panelcal
