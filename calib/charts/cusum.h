// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace panelcal {

/// Shift that a chart looks for.
enum class Shift : std::uint8_t { Up, Both };

/// A chart of cumulative sums of one standard score: of all charts with the same rate of false
/// alarms, it sees a lasting shift of twice its allowance soonest (Moustakides 1986).
///
///   up' = max(0, up + u - allowance),   down' = max(0, down - u - allowance)
///
/// Source Page 1954
/// See    calib/charts/run_length.h; tests/calib/charts/charts_test.cc
class CusumChart {
 public:
  /// In     allowance 0 to 2; nights between false alarms of both sums together, on the average, 2
  /// to
  ///        5e5
  CusumChart(Shift shift, double allowance, double nights_per_false_alarm);

  /// Adds a night; true if a sum is now above the limit.
  bool add(double score);
  void restart() {
    up_ = down_ = 0;
    n_up_ = n_down_ = 0;
  }

  /// The larger sum.
  double statistic() const { return up_ > down_ ? up_ : down_; }
  double limit() const { return limit_; }
  /// The nights for which that sum has been above zero, the last one included: so long ago the
  /// shift began, if it is one.
  int n_nights() const { return up_ > down_ ? n_up_ : n_down_; }

 private:
  Shift shift_;
  double allowance_;
  double limit_;
  double up_ = 0;
  double down_ = 0;
  int n_up_ = 0;
  int n_down_ = 0;
};

}  // namespace panelcal
