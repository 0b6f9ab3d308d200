// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "calib/charts/normal_mixture.h"
#include "calib/drift/series.h"
#include <Eigen/Core>

namespace panelcal {

/// The prior of a machine before its first night; lengths in the series' unit, here mm.
///
/// The first four make a log-normal each: a factor is one standard deviation of the logarithm.
/// A hundred nights hardly remember them, twenty do.
struct DriftPriors {
  double drift = 0.0005;  ///< median standard deviation of a day's random walk
  double drift_factor = 3;
  double repeatability = 0.0007;  ///< median, of a night beyond what its covariance says
  double repeatability_factor = 3;
  double per_kelvin = 0.001;  ///< standard deviation of the change with temperature, mean zero
};

/// Model of a series.
struct DriftOptions {
  DriftPriors priors;
  double reference_c = 20;  ///< to which values are reduced
  /// Standard deviation of a temperature that was not noted; counts as two nights on top of those
  /// that were. If none ever is, what temperature does is part of drift and repeatability.
  double unknown_kelvin = 3;
  int min_nights = 14;  ///< with fewer there is no judgement, only learning

  /// Fails  calibration-invalid: the message names field, value and bound
  Expected<void> validate() const;
};

/// A value predicted.
struct DriftPrediction {
  std::vector<NormalMixture> axes;
  Eigen::MatrixXd correlation;  ///< between the axes

  Eigen::VectorXd mean() const;
  Eigen::MatrixXd cov() const;
};

/// Learns night by night how a calibrated value moves, and predicts it with honest uncertainty.
///
///   value_t = level_t + b (T_t - T0) + e_t,   e_t ~ N(0, cov_t + rep^2)
///   level_t = level_t-1 + w_t,   w_t ~ N(0, drift^2 days)
///
/// A local level model with regression (Durbin and Koopman 2012, 2.1 and 6.2). Level and b are the
/// state of a Kalman filter. A night calibrates a warm machine, so that warming up is no part of
/// it. drift and rep are not set to their likeliest values, which a short
/// history knows badly, but averaged over: a filter each for a grid of them, weighted by prior and
/// likelihood (Magill 1965). What is predicted has the wide tails that go with that, and so false
/// alarms keep their rate from the first judged night on.
///
/// rep counts as the calibrations' own error and not as the machine's: it is no part of a forecast
/// of the true value. Axes are filtered one by one; that errors of a night are correlated between
/// them shows in DriftPrediction::correlation.
///
/// Cost   0.1 ms a night and axis
/// See    tests/calib/drift/model_test.cc
class DriftModel {
 public:
  /// In     n_axes 1 to 12
  /// Fails  calibration-invalid: options, n_axes
  static Expected<DriftModel> make(int n_axes, const DriftOptions& options);

  /// The prediction of a calibration's result, its own error included; `point` without its value.
  ///
  /// Precondition: point.cov has the model's size
  DriftPrediction predict(const DriftPoint& point) const;
  /// The true value then. Without a temperature it is that at the mean of those noted, give or take
  /// their scatter.
  DriftPrediction forecast(std::chrono::sys_seconds time,
                           std::optional<double> temperature_c) const;

  /// Learns a night. Points left out may hold anything.
  ///
  /// Fails  calibration-invalid: number of axes; what is not finite; a covariance that is not
  ///        positive semidefinite; a time not after the last one's
  Expected<void> add(const DriftPoint& point);

  int n_axes() const { return static_cast<int>(banks_.size()); }
  int n_nights() const { return n_nights_; }  ///< learned
  /// The last night learned.
  const std::optional<std::chrono::sys_seconds>& last() const { return last_; }
  bool has_enough() const { return n_nights_ >= options_.min_nights; }
  const DriftOptions& options() const { return options_; }

 private:
  /// One filter: of level, per kelvin.
  struct Filter {
    double drift = 0;
    double repeatability = 0;
    double log_weight = 0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Matrix2d cov = Eigen::Matrix2d::Zero();
  };
  using Bank = std::vector<Filter>;
  struct Look {
    Eigen::Vector2d row;  ///< of the state, in the value
    double unknown = 0;   ///< kelvin that the temperature is uncertain by
    double days = 0;      ///< since the last night
  };

  DriftModel(int n_axes, const DriftOptions& options);
  Look look(std::chrono::sys_seconds time, const std::optional<double>& temperature_c) const;
  Expected<void> check(const DriftPoint& point) const;
  void start_anew(const DriftPoint& point, const Look& look);
  NormalMixture mixture(const Bank& bank, const Look& look, const double* measured_variance) const;
  double update(Bank& bank, const Look& look, double value, double variance) const;

  DriftOptions options_;
  std::vector<Bank> banks_;
  Eigen::MatrixXd cross_;  ///< covariance of the axes' levels; its diagonal is not used
  std::optional<std::chrono::sys_seconds> last_;
  int n_nights_ = 0;
  double mean_temperature_c_ = 0;
  double spread_of_temperatures_ = 0;  ///< sum of squares about the mean
  int n_temperatures_ = 0;
};

}  // namespace panelcal
