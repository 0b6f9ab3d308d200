// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>

#include "calib/base/expected.h"
#include "calib/charts/cusum.h"

namespace panelcal {

/// Scatter that a night showed: of detections about a hole (a dirty lens), or of holes about the
/// fit (a worn drill).
struct SpreadPoint {
  std::chrono::sys_seconds time{};
  double variance = 0;            ///< as estimated that night, in a unit of the caller's
  double degrees_of_freedom = 0;  ///< of that estimate, above 0
  bool is_fresh_start = false;    ///< cleaned, or a new drill: nights before say nothing
};

/// A night as the charts of scatter see it.
struct WatchedSpread {
  std::chrono::sys_seconds time{};
  bool is_judged = false;
  double expected_variance = 0;  ///< of the nights before, 0 if there are none
  double ratio = 1;              ///< tonight's variance to that
  double score = 0;              ///< standard normal while nothing happens
  bool is_alarm_of_night = false;
  bool is_alarm_of_sum = false;

  bool is_alarm() const { return is_alarm_of_night || is_alarm_of_sum; }
};

/// Watches whether scatter grows, and alarms falsely once in the stated number of nights.
///
/// While the variance is the same every night, its ratio to that of all nights before is
/// distributed as F, and these ratios are independent (sums of chi squares are, of their shares).
/// So scores are standard normal exactly, however short the history. They are charted night by
/// night and as a cumulative sum, upwards; each with half of the false alarms. Nights that alarm by
/// themselves are not counted into what is usual.
///
/// The normal distribution of the errors is taken for granted: estimates that a few broken-out
/// holes make vary more than their degrees of freedom say, and have to be made robustly. See
/// tests/calib/charts/spread_monitor_test.cc
class SpreadMonitor {
 public:
  /// In     nights between false alarms, 20 to 1e5; nights before there is a judgement, 1 or more
  /// Fails  calibration-invalid
  static Expected<SpreadMonitor> make(double nights_per_false_alarm, int min_nights);

  /// Fails  calibration-invalid: what is not finite, negative, or not after the last night
  Expected<WatchedSpread> add(const SpreadPoint& point);

 private:
  SpreadMonitor(double nights_per_false_alarm, int min_nights);

  int min_nights_;
  double night_limit_;
  CusumChart sum_;
  std::optional<std::chrono::sys_seconds> last_;
  int n_nights_ = 0;
  double sum_of_squares_ = 0;
  double degrees_of_freedom_ = 0;
};

}  // namespace panelcal
