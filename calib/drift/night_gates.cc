// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/night_gates.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/charts/run_length.h"
#include "calib/drift/amount.h"
#include "calib/drift/monitor.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal {
namespace {

/// Largest standard deviation in any direction; NaN where the covariance is not positive
/// semidefinite.
double largest_sigma(const Eigen::MatrixXd& cov) {
  const Eigen::VectorXd variances = internal::eigenvalues(cov).values;
  constexpr double kRounding = 1e-9;
  const double largest = variances.maxCoeff();
  if (variances.minCoeff() < -kRounding * std::abs(largest)) return std::nan("");
  return std::sqrt(largest);
}

/// Examines one night; collects its gates.
class Examination {
 public:
  Examination(const NightResult& result, const DriftSeries& history, const NightLimits& limits)
      : result_(result), history_(history), limits_(limits) {}

  /// False if there is nothing that could be judged further.
  bool numbers(const DriftModel& model) {
    const DriftPoint& p = result_.point;
    DriftModel trial = model;
    const Expected<void> learned = trial.add(p);
    const bool passed = learned.has_value() && !p.is_left_out;
    add("numbers",
        passed,
        passed    ? "the result is a value with a covariance"
        : learned ? std::string("no result this night")
                  : fmt::format("no usable result: {}", learned.error().what));
    return passed;
  }

  void quality() {
    const DriftPoint& p = result_.point;
    const double sigma = largest_sigma(p.cov);
    add("uncertainty",
        sigma <= limits_.sigma,
        fmt::format("sigma of the result is {}, limit {}",
                    amount(sigma, history_.unit),
                    amount(limits_.sigma, history_.unit)));
    add("holes",
        result_.n_used >= limits_.min_used,
        fmt::format("{} {} were used, at least {} are needed",
                    result_.n_used,
                    result_.used,
                    limits_.min_used));
    add("outliers",
        result_.n_outliers <= limits_.max_outliers,
        fmt::format("{} {} were left out as outliers, limit {}",
                    result_.n_outliers,
                    result_.used,
                    limits_.max_outliers));
    if (result_.structure_chance) {
      add("structure",
          *result_.structure_chance >= limits_.structure_chance,
          fmt::format("residuals show a structure that chance gives with a probability of {:.2g}, "
                      "limit {:.2g}",
                      *result_.structure_chance,
                      limits_.structure_chance));
    }
    temperature();
    gates_.insert(gates_.end(), result_.further.begin(), result_.further.end());
  }

  /// Against the forecast if there is enough history, and against what is in force.
  void change(const DriftModel& model, const std::optional<Eigen::VectorXd>& in_force) {
    const DriftPoint& p = result_.point;
    if (in_force) {
      const double away = (p.value - *in_force).norm();
      add("change",
          away <= limits_.change,
          fmt::format("the result is {} from the one in force, limit {}",
                      amount(away, history_.unit),
                      amount(limits_.change, history_.unit)));
    }
    if (p.is_fresh_start || !model.has_enough()) return;
    const DriftPrediction expected = model.predict(p);
    const double sigmas = independent_scores(expected, p.value).norm();
    const double limit = ewma_limit(model.n_axes(), 1, limits_.nights_per_refusal);
    add("change",
        sigmas <= limit,
        fmt::format("the result is {} from the prediction of {} nights, {:.1f} sigma, limit {:.1f}",
                    amount((p.value - expected.mean()).norm(), history_.unit),
                    model.n_nights(),
                    sigmas,
                    limit));
  }

  std::vector<NightGate> take_gates() { return std::move(gates_); }

 private:
  void add(std::string name, bool passed, std::string text) {
    gates_.push_back({std::move(name), passed, std::move(text)});
  }

  void temperature() {
    if (!limits_.min_temperature_c && !limits_.max_temperature_c) return;
    if (!result_.point.temperature_c) {
      add("temperature", false, "the temperature is not known, and it has limits");
      return;
    }
    const double t = *result_.point.temperature_c;
    const bool passed = !(limits_.min_temperature_c && !(t >= *limits_.min_temperature_c)) &&
                        !(limits_.max_temperature_c && !(t <= *limits_.max_temperature_c));
    const auto bound = [](const std::optional<double>& b) {
      return b ? fmt::format("{:.1f}", *b) : std::string("any");
    };
    add("temperature",
        passed,
        fmt::format("the temperature is {:.1f} C, allowed {} to {}",
                    t,
                    bound(limits_.min_temperature_c),
                    bound(limits_.max_temperature_c)));
  }

  const NightResult& result_;
  const DriftSeries& history_;
  const NightLimits& limits_;
  std::vector<NightGate> gates_;
};

/// True if the one in force may stay, with the reason appended.
Expected<bool> may_keep(const DriftModel& model,
                        const NightResult& result,
                        const std::optional<Eigen::VectorXd>& in_force,
                        const DriftSeries& history,
                        const NightLimits& limits,
                        NightDecision& decision) {
  if (!in_force) {
    decision.reasons.emplace_back("there is no calibration in force that could stay");
    return false;
  }
  const bool is_contradicted = std::ranges::any_of(
      decision.gates, [](const NightGate& g) { return g.name == "change" && !g.passed; });
  if (is_contradicted) {
    decision.reasons.emplace_back(
        "the one in force may be wrong: the machine has moved, or tonight was measured badly");
    return false;
  }
  ForecastLimits old = limits.old;
  old.horizon = limits.until_next;
  // A night that has no time of its own is judged by the last one that has.
  const std::chrono::sys_seconds now =
      model.last() ? std::max(result.point.time, *model.last()) : result.point.time;
  PANELCAL_TRY(decision.old, may_drill(model, *in_force, now, old));
  limit_to_trust(model, old, *decision.old);
  std::string reason = "the one in force: " + words_of(*decision.old, old, history.unit);
  if (decision.old->answer == DrillAnswer::Until) reason += "; that is before the next night";
  decision.reasons.push_back(std::move(reason));
  return decision.old->answer == DrillAnswer::BeyondHorizon;
}

}  // namespace

Expected<void> NightLimits::validate() const {
  const auto check = [](std::string_view field, double value, bool is_good) -> Expected<void> {
    if (is_good) return {};
    return failure({Code::CalibrationInvalid,
                    {},
                    fmt::format("the night's limit {} is {}", field, value),
                    "a number in its range"});
  };
  PANELCAL_CHECK(check("sigma", sigma, sigma > 0));
  PANELCAL_CHECK(check("min_used", min_used, min_used >= 1));
  PANELCAL_CHECK(check("max_outliers", max_outliers, max_outliers >= 0));
  PANELCAL_CHECK(
      check("structure_chance", structure_chance, structure_chance >= 0 && structure_chance < 1));
  PANELCAL_CHECK(check("nights_per_refusal",
                       nights_per_refusal,
                       nights_per_refusal >= 20 && nights_per_refusal <= 1e5));
  PANELCAL_CHECK(check("change", change, change > 0));
  PANELCAL_CHECK(check("until_next", until_next.in_s(), until_next > seconds(0)));
  return old.validate();
}

std::string_view name(NightVerdict verdict) {
  switch (verdict) {
    case NightVerdict::Install:
      return "install";
    case NightVerdict::KeepOld:
      return "keep the old one";
    case NightVerdict::Hold:
      break;
  }
  return "hold";
}

std::string NightDecision::summary() const {
  if (reasons.empty()) return std::string(name(verdict));
  return fmt::format("{}: {}", name(verdict), fmt::join(reasons, "; "));
}

Expected<NightDecision> decide_night(const NightResult& result,
                                     const std::optional<Eigen::VectorXd>& in_force,
                                     const DriftSeries& history,
                                     const DriftOptions& options,
                                     const NightLimits& limits) {
  PANELCAL_CHECK(limits.validate());
  const int n_axes = static_cast<int>(history.names.size());
  PANELCAL_TRY(DriftModel model, DriftModel::make(n_axes, options));
  for (const DriftPoint& point : history.points) PANELCAL_CHECK(model.add(point));
  if (in_force && (in_force->size() != n_axes || !in_force->allFinite())) {
    return failure({Code::CalibrationInvalid,
                    {},
                    "the value in force does not have the history's axes",
                    "as many numbers"});
  }
  NightDecision decision;
  Examination examination(result, history, limits);
  if (examination.numbers(model)) {
    examination.quality();
    examination.change(model, in_force);
  }
  decision.gates = examination.take_gates();
  for (const NightGate& gate : decision.gates) {
    if (!gate.passed) decision.reasons.push_back(gate.text);
  }
  if (decision.reasons.empty()) {
    decision.verdict = NightVerdict::Install;
    return decision;
  }
  PANELCAL_TRY(const bool keeps, may_keep(model, result, in_force, history, limits, decision));
  decision.verdict = keeps ? NightVerdict::KeepOld : NightVerdict::Hold;
  return decision;
}

}  // namespace panelcal
