// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/charts/cusum.h"
#include "calib/charts/ewma.h"
#include "calib/drift/model.h"
#include "calib/drift/series.h"
#include <Eigen/Core>

namespace panelcal {

/// The chart that alarms, and so the kind of change that it looks like.
enum class DriftChart : std::uint8_t {
  Night,    ///< this night by itself: a step
  Average,  ///< the last nights together, in any direction: a shift that stays
  Sum,      ///< one axis over weeks: a slow drift
  Moved,    ///< no chart: it is farther than a limit from where it was
};

/// A chart outside its limit; both in standard deviations, or for Moved in the series' unit.
struct DriftAlarm {
  DriftChart chart = DriftChart::Night;
  double statistic = 0;
  double limit = 0;
  std::optional<std::size_t> i_axis;  ///< of a sum
};

/// A night as the charts see it.
struct WatchedNight {
  std::chrono::sys_seconds time{};
  bool is_judged = false;  ///< false where there was not enough history, or nothing to compare with
  Eigen::VectorXd expected;
  Eigen::MatrixXd expected_cov;  ///< of what would be found, the night's own error included
  Eigen::VectorXd scores;        ///< independent and standard normal while nothing happens
  std::vector<DriftAlarm> alarms;
  /// Likely first night of the change that `alarms` are about: this one of a step, else the first
  /// of those for which the largest sum has been above zero. Without alarms it has no meaning.
  std::chrono::sys_seconds since{};
  Eigen::VectorXd moved;  ///< from before that night until now, without what temperature does

  /// The night by itself is out: the level after it is new.
  bool is_step() const;
};

/// Rate of false alarms, and the changes that the monitor looks for.
struct WatchOptions {
  double nights_per_false_alarm = 1000;  ///< on the average, of all charts together; 20 to 1e5
  double average_weight = 0.1;           ///< of tonight; smaller sees smaller shifts, later
  double allowance = 0.25;               ///< of the sums, in standard deviations
  /// Greatest move that is not reported, in the series' unit (here mm), however slowly and however
  /// usual that is of this machine. No false alarm when it comes, so not in the rate.
  std::optional<double> moved = 0.006;

  /// Fails  calibration-invalid: the message names field, value and bound
  Expected<void> validate() const;
};

/// Standard scores of a value among what was predicted, one an axis: that of the first, and of each
/// further one what those before do not tell of it.
Eigen::VectorXd independent_scores(const DriftPrediction& prediction, const Eigen::VectorXd& value);

/// Watches a calibrated value night by night, and alarms falsely once in the stated number of
/// nights.
///
/// Each night is held against what the nights before it predict (DriftModel), so what is usual for
/// this machine, its drift and the temperature included, is no alarm. Half of the
/// false alarms go to the chart of single nights, a quarter to the average's and a quarter to the
/// sums'. Rates are added, so the true one is rather below.
///
/// After a step the level is taken as new: the next night is judged by the new one. After any alarm
/// averages and sums begin anew. A value that moves steadily is in time taken for a machine that
/// drifts more, and the alarms become rarer. So what it has moved in all is watched as well: since
/// the first judged night, the last step or the last time this was said.
///
/// That parameters are learned and not known makes the scores of a run a little too large or too
/// small together, and alarms more frequent; limits are for up to twice as many nights to make up
/// for it.
///
/// See    tests/calib/drift/monitor_slow_test.cc (rates and detections over simulated nights)
class DriftMonitor {
 public:
  /// Fails  as DriftModel::make; calibration-invalid: watch
  static Expected<DriftMonitor> make(int n_axes,
                                     const DriftOptions& options,
                                     const WatchOptions& watch);

  /// Judges a night and learns from it. Points left out are not judged.
  ///
  /// Fails  as DriftModel::add
  Expected<WatchedNight> add(const DriftPoint& point);

  const DriftModel& model() const { return model_; }

 private:
  DriftMonitor(DriftModel model, int n_axes, const WatchOptions& watch);
  /// The model's value after a night.
  struct Level {
    std::chrono::sys_seconds time{};
    Eigen::VectorXd value;
  };
  int judge(WatchedNight& night);
  int nights_of_sums() const;
  void restart_charts();
  void compare_levels(WatchedNight& night, int n_changed);

  DriftModel model_;
  std::optional<double> moved_;
  std::vector<Level> levels_;
  std::optional<std::size_t> i_anchor_;  ///< the level that Moved is measured from
  double night_limit_;
  EwmaChart average_;
  std::vector<CusumChart> sums_;
};

/// "x moved by +6.2 um, y by -3.1 um since about the night of 2026-11-03, as the alarm in the night
/// of 2026-11-12 says": axes that moved by a third or more of what the farthest did.
///
/// Precondition: night.alarms is not empty
std::string words_of(const WatchedNight& night,
                     const std::vector<std::string>& names,
                     const std::string& unit);

/// "a step: tonight is 7.2 sigma from what the nights before predicted, limit 3.9".
///
/// In     names: of the axes; unit: of the series
std::string words_of(const DriftAlarm& alarm,
                     const std::vector<std::string>& names,
                     const std::string& unit);

}  // namespace panelcal
