// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace panelcal {

/// A chart of the exponentially weighted moving average of vectors of standard scores: sees a shift
/// that stays, in any direction, sooner than each night by itself does.
///
/// Source Roberts 1959 (one axis); Lowry, Woodall, Champ and Rigdon 1992 (several)
/// See    calib/charts/run_length.h; tests/calib/charts/charts_test.cc
class EwmaChart {
 public:
  /// In     n_axes >= 1; weight of tonight, 0.02 to 1; nights between false alarms on the average,
  ///        2 to 1e6
  EwmaChart(int n_axes, double weight, double nights_per_false_alarm);

  /// Adds a night; true if the average is now outside the limit.
  bool add(const Eigen::VectorXd& scores);
  /// As on the first night.
  void restart() { average_.setZero(); }

  /// The average's length in standard deviations that it has after many nights.
  double statistic() const { return average_.norm() / sigma_; }
  double limit() const { return limit_; }

 private:
  double weight_;
  double sigma_;
  double limit_;
  Eigen::VectorXd average_;
};

}  // namespace panelcal
