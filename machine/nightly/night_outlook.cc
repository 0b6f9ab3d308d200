// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/night_outlook.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/drift/forecast.h"
#include "calib/drift/monitor.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::size_t kPlotted = 60;

std::vector<double> list(const Eigen::VectorXd& v) {
  return {v.data(), v.data() + v.size()};
}

NightPlotPoint plot_point(const DriftPoint& point) {
  NightPlotPoint out;
  out.time = point.time;
  out.value = list(point.value);
  if (point.cov.rows() == point.value.size()) {
    out.sigma = list(point.cov.diagonal().cwiseMax(0).cwiseSqrt());
  }
  out.is_refused = point.is_left_out;
  out.is_fresh_start = point.is_fresh_start;
  return out;
}

/// All nights with tonight as the last, which may have found nothing.
DriftSeries with_tonight(const NightHistory& history, const NightPlace& tonight) {
  DriftSeries series = history.series;
  if (!tonight.is_in_series) series.points.push_back(tonight.point);
  return series;
}

void fill_series(const NightHistory& history,
                 const DriftSeries& series,
                 const std::vector<WatchedNight>& watched,
                 const std::optional<Eigen::VectorXd>& in_force,
                 NightStep& step) {
  const std::size_t first = series.points.size() > kPlotted ? series.points.size() - kPlotted : 0;
  for (std::size_t i = first; i < series.points.size(); ++i) {
    const DriftPoint& point = series.points[i];
    if (point.value.size() == 0 || !point.value.allFinite()) continue;
    NightPlotPoint out = plot_point(point);
    out.is_alarm = !watched[i].alarms.empty();
    const bool is_last = i + 1 == series.points.size();
    if (is_last && in_force) out.in_force = list(*in_force);
    if (!is_last && i < history.in_force_values.size() && history.in_force_values[i]) {
      out.in_force = list(*history.in_force_values[i]);
    }
    if (i < history.ids.size()) {
      out.ledger_id = history.ids[i];
      out.asked_by = history.asked_by[i];
      out.is_by_hand = history.is_by_hand[i];
    }
    step.series.push_back(std::move(out));
  }
}

void fill_expected(const DriftModel& before, const DriftPoint& tonight, NightStep& step) {
  if (!before.has_enough() || before.last() >= tonight.time) return;
  DriftPoint asked = tonight;
  const auto n = static_cast<Eigen::Index>(before.n_axes());
  if (asked.cov.rows() != n || asked.cov.cols() != n) asked.cov = Eigen::MatrixXd::Zero(n, n);
  if (!asked.cov.allFinite()) return;
  const DriftPrediction prediction = before.predict(asked);
  const Eigen::VectorXd mean = prediction.mean();
  const Eigen::VectorXd variance = prediction.cov().diagonal();
  for (std::size_t i = 0; i < step.axes.size() && i < static_cast<std::size_t>(n); ++i) {
    step.axes[i].expected = mean(static_cast<Eigen::Index>(i));
    step.axes[i].expected_sigma = std::sqrt(variance(static_cast<Eigen::Index>(i)));
  }
}

/// The last alarm, back to a fresh start and as far as nights are plotted.
void fill_since_when(const DriftSeries& series,
                     const std::vector<WatchedNight>& watched,
                     NightStep& step) {
  const std::size_t n_told = std::min(watched.size(), kPlotted);
  for (std::size_t i = watched.size(); i > watched.size() - n_told; --i) {
    if (!watched[i - 1].alarms.empty()) {
      step.since_when = words_of(watched[i - 1], series.names, series.unit);
      return;
    }
    if (series.points[i - 1].is_fresh_start) return;
  }
}

Expected<void> fill_forecast(const DriftModel& model,
                             const DriftPoint& tonight,
                             const std::optional<Eigen::VectorXd>& in_force,
                             const NightlyConfig& config,
                             const std::string& unit,
                             NightStep& step) {
  if (!in_force) {
    step.forecast_text = "no calibration is in force";
    return {};
  }
  const std::chrono::sys_seconds now =
      model.last() ? std::max(tonight.time, *model.last()) : tonight.time;
  PANELCAL_TRY(step.forecast, may_drill(model, *in_force, now, config.limits.old));
  if (tonight.is_left_out) limit_to_trust(model, config.limits.old, *step.forecast);
  step.forecast_text = words_of(*step.forecast, config.limits.old, unit);
  step.tolerance = config.limits.old.tolerance;
  return {};
}

}  // namespace

Expected<DriftSeries> series_as_learned(const NightHistory& history, const NightlyConfig& config) {
  DriftSeries series = history.series;
  const int n_axes = static_cast<int>(series.names.size());
  PANELCAL_TRY(DriftMonitor monitor, DriftMonitor::make(n_axes, config.drift, config.watch));
  for (DriftPoint& point : series.points) {
    PANELCAL_TRY(const WatchedNight night, monitor.add(point));
    point.is_fresh_start = point.is_fresh_start || night.is_step();
  }
  return series;
}

Expected<void> fill_outlook(const NightHistory& history,
                            const NightPlace& tonight,
                            const std::optional<Eigen::VectorXd>& in_force,
                            const NightlyConfig& config,
                            NightStep& step) {
  const DriftSeries series = with_tonight(history, tonight);
  const int n_axes = static_cast<int>(series.names.size());
  PANELCAL_TRY(DriftMonitor monitor, DriftMonitor::make(n_axes, config.drift, config.watch));
  std::vector<WatchedNight> watched;
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    const bool is_last = i + 1 == series.points.size();
    if (is_last) fill_expected(monitor.model(), series.points[i], step);
    PANELCAL_TRY(WatchedNight night, monitor.add(series.points[i]));
    watched.push_back(std::move(night));
  }
  if (!watched.empty()) {
    for (const DriftAlarm& alarm : watched.back().alarms) {
      step.alarms.push_back(words_of(alarm, series.names, series.unit));
    }
  }
  fill_series(history, series, watched, in_force, step);
  fill_since_when(series, watched, step);
  if (history.ahead) {
    step.forecast_text = "no forecast: the clock is wrong, or was";
    return {};
  }
  return fill_forecast(monitor.model(), tonight.point, in_force, config, series.unit, step);
}

}  // namespace panelcal
