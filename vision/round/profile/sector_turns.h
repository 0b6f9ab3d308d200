// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <numbers>
#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// The waves around a rim of n sectors: exp(i k phi) of every sector's direction phi, from one
/// table of sines for all k.
class SectorTurns {
 public:
  explicit SectorTurns(Eigen::Index n) : once_(n) {
    for (Eigen::Index i = 0; i < n; ++i) {
      once_[i] =
          std::polar(1.0, 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n));
    }
  }

  Eigen::Index n() const { return once_.size(); }

  /// Calls `visit(sector, turn)` for each sector in order.
  ///
  /// In     n_periods: 0 or more
  template <class Visit>
  void for_each(int n_periods, Visit&& visit) const {
    const Eigen::Index step = n() > 0 ? n_periods % n() : 0;
    Eigen::Index at = 0;
    for (Eigen::Index i = 0; i < n(); ++i) {
      visit(i, once_[at]);
      at += step;
      if (at >= n()) at -= n();
    }
  }

 private:
  Eigen::VectorXcd once_;
};

/// The power of waves of `first` to `last` periods around the rim, per sector: E is the variance of
/// a sector if these are independent.
///
/// In     use: of each sector, 0: it counts as 0; empty: all are used
std::vector<double> wave_powers(const Eigen::VectorXd& values,
                                const std::vector<char>& use,
                                int first,
                                int last);

}  // namespace panelcal::internal
