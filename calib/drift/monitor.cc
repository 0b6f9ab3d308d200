// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/monitor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/statistics/linear_algebra.h"
#include "calib/charts/run_length.h"
#include "calib/drift/amount.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Shares of the false alarms; they add up to 1.
constexpr double kMonitoredShareOfNights = 0.5;
constexpr double kShareOfAverage = 0.25;
constexpr double kShareOfSums = 0.25;

/// Limits are for this multiple of the stated nights; measured by drift_monitor_slow_test.cc. A
/// single night suffers less from learned parameters than sums of many do.
constexpr double kForLearningOfNights = 1.2;
constexpr double kForLearning = 2;

/// Correlations of forecasts stay this far from 1, so that scores stay finite.
constexpr double kMostCorrelation = 0.999;

}  // namespace

Eigen::VectorXd independent_scores(const DriftPrediction& prediction,
                                   const Eigen::VectorXd& value) {
  Eigen::VectorXd scores(value.size());
  for (Eigen::Index i = 0; i < value.size(); ++i) {
    scores(i) = prediction.axes[static_cast<std::size_t>(i)].score(value(i));
  }
  Eigen::MatrixXd correlation = kMostCorrelation * prediction.correlation;
  correlation.diagonal().setOnes();
  const internal::Cholesky root(correlation);
  return root.is_definite() ? root.whiten(scores) : scores;
}

bool WatchedNight::is_step() const {
  return std::ranges::find(alarms, DriftChart::Night, &DriftAlarm::chart) != alarms.end();
}

Expected<void> WatchOptions::validate() const {
  const auto between =
      [](std::string_view field, double value, double low, double high) -> Expected<void> {
    if (value >= low && value <= high) return {};
    return failure({Code::CalibrationInvalid,
                    {},
                    fmt::format("{} is {}", field, value),
                    fmt::format("a number from {} to {}", low, high)});
  };
  PANELCAL_CHECK(between("nights_per_false_alarm", nights_per_false_alarm, 20, 1e5));
  if (moved) PANELCAL_CHECK(between("moved", *moved, 1e-12, 1e12));
  PANELCAL_CHECK(between("average_weight", average_weight, 0.02, 1));
  return between("allowance", allowance, 0.05, 2);
}

Expected<DriftMonitor> DriftMonitor::make(int n_axes,
                                          const DriftOptions& options,
                                          const WatchOptions& watch) {
  PANELCAL_CHECK(watch.validate());
  PANELCAL_TRY(DriftModel model, DriftModel::make(n_axes, options));
  return DriftMonitor(std::move(model), n_axes, watch);
}

DriftMonitor::DriftMonitor(DriftModel model, int n_axes, const WatchOptions& watch)
    : model_(std::move(model)),
      moved_(watch.moved),
      night_limit_(ewma_limit(
          n_axes,
          1,
          kForLearningOfNights * watch.nights_per_false_alarm / kMonitoredShareOfNights)),
      average_(n_axes,
               watch.average_weight,
               kForLearning * watch.nights_per_false_alarm / kShareOfAverage),
      sums_(static_cast<std::size_t>(n_axes),
            CusumChart(Shift::Both,
                       watch.allowance,
                       kForLearning * n_axes * watch.nights_per_false_alarm / kShareOfSums)) {
}

void DriftMonitor::restart_charts() {
  average_.restart();
  for (CusumChart& sum : sums_) sum.restart();
}

/// The nights for which the largest sum has been above zero.
int DriftMonitor::nights_of_sums() const {
  return std::ranges::max_element(sums_, {}, &CusumChart::statistic)->n_nights();
}

/// In     n_changed: the nights since the change that the charts alarm about; 0 if they do not
void DriftMonitor::compare_levels(WatchedNight& night, int n_changed) {
  levels_.push_back({night.time, model_.forecast(night.time, std::nullopt).mean()});
  const std::size_t i_here = levels_.size() - 1;
  const Eigen::VectorXd& here = levels_.back().value;
  if (i_anchor_ && moved_ && night.is_judged) {
    const double distance = (here - levels_[*i_anchor_].value).norm();
    if (distance > *moved_) {
      night.alarms.push_back({DriftChart::Moved, distance, *moved_, std::nullopt});
      if (n_changed == 0) {
        // Sums know better when it began, unless most of the way is older than they are.
        const auto i_sums = i_here - static_cast<std::size_t>(nights_of_sums());
        const bool is_most = 2 * (here - levels_[i_sums].value).norm() > distance;
        n_changed = static_cast<int>(i_here - (is_most ? i_sums : *i_anchor_));
      }
      i_anchor_.reset();
    }
  }
  if (!i_anchor_ && model_.has_enough()) i_anchor_ = i_here;
  if (n_changed == 0) return;
  const std::size_t i_before = i_here - static_cast<std::size_t>(n_changed);
  night.since = levels_[i_before + 1].time;
  night.moved = here - levels_[i_before].value;
}

/// Out    the nights since the change that the charts alarm about; 0 if they do not
int DriftMonitor::judge(WatchedNight& night) {
  const double distance = night.scores.norm();
  if (!(distance <= night_limit_)) {
    night.alarms.push_back({DriftChart::Night, distance, night_limit_, std::nullopt});
  }
  if (average_.add(night.scores)) {
    night.alarms.push_back(
        {DriftChart::Average, average_.statistic(), average_.limit(), std::nullopt});
  }
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    if (!sums_[i].add(night.scores(static_cast<Eigen::Index>(i)))) continue;
    night.alarms.push_back({DriftChart::Sum, sums_[i].statistic(), sums_[i].limit(), i});
  }
  if (night.alarms.empty()) return 0;
  const int n_changed = night.is_step() ? 1 : std::max(1, nights_of_sums());
  restart_charts();
  return n_changed;
}

Expected<WatchedNight> DriftMonitor::add(const DriftPoint& point) {
  WatchedNight night;
  night.time = point.time;
  DriftModel before = model_;
  PANELCAL_CHECK(model_.add(point));
  if (point.is_left_out || before.n_nights() == 0) return night;
  const DriftPrediction prediction = before.predict(point);
  night.expected = prediction.mean();
  night.expected_cov = prediction.cov();
  night.scores = independent_scores(prediction, point.value);
  night.is_judged = before.has_enough() && !point.is_fresh_start;
  if (point.is_fresh_start) {
    restart_charts();
    i_anchor_.reset();
  }
  const int n_changed = night.is_judged ? judge(night) : 0;
  if (night.is_step()) {
    // A step says nothing about how the machine drifts.
    model_ = std::move(before);
    DriftPoint fresh = point;
    fresh.is_fresh_start = true;
    PANELCAL_CHECK(model_.add(fresh));
    i_anchor_.reset();
  }
  compare_levels(night, n_changed);
  return night;
}

std::string words_of(const WatchedNight& night,
                     const std::vector<std::string>& names,
                     const std::string& unit) {
  constexpr double kShown = 1.0 / 3;
  const auto day_of = [](std::chrono::sys_seconds time) {
    constexpr std::size_t kLength = 10;  // 2026-11-21
    return iso_8601(time).substr(0, kLength);
  };
  std::string out;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double moved = night.moved(static_cast<Eigen::Index>(i));
    if (std::abs(moved) < kShown * night.moved.lpNorm<Eigen::Infinity>()) continue;
    const std::string_view verb = out.empty() ? " moved by " : " by ";
    out += (out.empty() ? "" : ", ") + names[i] + std::string(verb) + signed_amount(moved, unit);
  }
  if (night.is_step()) return out + " in the night of " + day_of(night.time);
  return fmt::format("{} since about the night of {}, as the alarm in the night of {} says",
                     out,
                     day_of(night.since),
                     day_of(night.time));
}

std::string words_of(const DriftAlarm& alarm,
                     const std::vector<std::string>& names,
                     const std::string& unit) {
  switch (alarm.chart) {
    case DriftChart::Night:
      return fmt::format(
          "a step: tonight is {:.1f} sigma from the prediction of the nights before, "
          "limit {:.1f}",
          alarm.statistic,
          alarm.limit);
    case DriftChart::Average:
      return fmt::format(
          "a shift that stays: the last nights together are {:.1f} sigma from "
          "the prediction, limit {:.1f}",
          alarm.statistic,
          alarm.limit);
    case DriftChart::Moved:
      return fmt::format("it has moved by {} since the last alarm, limit {}",
                         amount(alarm.statistic, unit),
                         amount(alarm.limit, unit));
    case DriftChart::Sum:
      break;
  }
  const bool is_named = alarm.i_axis && *alarm.i_axis < names.size();
  return fmt::format(
      "a slow drift of {}: night after night on the same side, the sum is {:.1f}, "
      "limit {:.1f}",
      is_named ? names[*alarm.i_axis] : "an axis",
      alarm.statistic,
      alarm.limit);
}

}  // namespace panelcal
