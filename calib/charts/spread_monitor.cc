// SPDX-License-Identifier: Apache-2.0
#include "calib/charts/spread_monitor.h"

#include <cmath>

#include "calib/base/statistics/distributions.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// A cumulative sum with this allowance is best against a shift of one standard deviation, which
/// with 16 degrees of freedom is a scatter grown by a fifth.
constexpr double kAllowance = 0.5;

Diagnostic invalid_spread(std::string what, std::string expected) {
  return {Code::CalibrationInvalid, {}, std::move(what), std::move(expected)};
}

}  // namespace

Expected<SpreadMonitor> SpreadMonitor::make(double nights_per_false_alarm, int min_nights) {
  if (!(nights_per_false_alarm >= 20 && nights_per_false_alarm <= 1e5)) {
    return failure(
        invalid_spread(fmt::format("nights_per_false_alarm is {}", nights_per_false_alarm),
                       "a number from 20 to 100000"));
  }
  if (min_nights < 1) {
    return failure(invalid_spread(fmt::format("min_nights is {}", min_nights), "1 or more"));
  }
  return SpreadMonitor(nights_per_false_alarm, min_nights);
}

SpreadMonitor::SpreadMonitor(double nights_per_false_alarm, int min_nights)
    : min_nights_(min_nights),
      night_limit_(normal_of_exceedance(0.5 / nights_per_false_alarm)),
      sum_(Shift::Up, kAllowance, 2 * nights_per_false_alarm) {
}

Expected<WatchedSpread> SpreadMonitor::add(const SpreadPoint& point) {
  if (!(point.variance >= 0) || !std::isfinite(point.variance)) {
    return failure(
        invalid_spread(fmt::format("a night's variance is {}", point.variance), "0 or more"));
  }
  if (!(point.degrees_of_freedom > 0) || !std::isfinite(point.degrees_of_freedom)) {
    return failure(invalid_spread(
        fmt::format("a night's variance has {} degrees of freedom", point.degrees_of_freedom),
        "more than 0"));
  }
  if (last_ && point.time <= *last_) {
    return failure(
        invalid_spread("a night is not after the one before it", "nights in order of time"));
  }
  last_ = point.time;
  if (point.is_fresh_start) {
    n_nights_ = 0;
    sum_of_squares_ = degrees_of_freedom_ = 0;
    sum_.restart();
  }
  WatchedSpread night;
  night.time = point.time;
  if (n_nights_ > 0 && sum_of_squares_ > 0) {
    night.expected_variance = sum_of_squares_ / degrees_of_freedom_;
    night.ratio = point.variance / night.expected_variance;
    night.score = normal_score(
        point.variance > 0 ? variance_ratio_exceedance(
                                 1 / night.ratio, degrees_of_freedom_, point.degrees_of_freedom)
                           : 0,
        variance_ratio_exceedance(night.ratio, point.degrees_of_freedom, degrees_of_freedom_));
    night.is_judged = n_nights_ >= min_nights_;
  }
  if (night.is_judged) {
    night.is_alarm_of_night = night.score > night_limit_;
    night.is_alarm_of_sum = sum_.add(night.score);
    if (night.is_alarm()) sum_.restart();
  }
  if (night.is_alarm_of_night) return night;
  ++n_nights_;
  sum_of_squares_ += point.variance * point.degrees_of_freedom;
  degrees_of_freedom_ += point.degrees_of_freedom;
  return night;
}

}  // namespace panelcal
