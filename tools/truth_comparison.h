// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "panelcal/calib/base/units.h"
#include "panelcal/machine/sim/truth.h"
#include "panelcal/program/job_verdict.h"
#include "panelcal/program/operation.h"

namespace panelcal {

/// Errors of holes against truth, gathered as they pass.
struct ErrorStatistics {
  std::int64_t n = 0;
  double max_mm = 0;
  double sum_mm = 0;
  double sum_squares_mm2 = 0;

  void add(double error_mm);
  Length max() const { return mm(max_mm); }
  Length rms() const;
  /// As the trade sums them up: mean, mean + 3 sigma, Cpk.
  RadialFigures radial() const {
    return {.n = n, .sum_mm = sum_mm, .sum_squares_mm2 = sum_squares_mm2};
  }
};

/// Compares every hole with where the hidden panel really has it: as corrected, and as it would
/// have been drilled without any correction.
class TruthComparison final : public OperationSink {
 public:
  /// In     of_hole_mm2: what the machine adds at every hole, which a simulated panel does not
  /// show:
  ///        left out of the predicted variance
  explicit TruthComparison(const Truth& truth,
                           const Eigen::Matrix2d& of_hole_mm2 = Eigen::Matrix2d::Zero())
      : truth_(truth), of_hole_mm2_(of_hole_mm2) {}
  void put(const Operation& operation) override;

  struct Errors {
    ErrorStatistics corrected;
    ErrorStatistics uncorrected;
  };
  const Errors& all() const { return all_; }
  const std::map<int, Errors>& by_tool() const { return by_tool_; }
  /// Mean normalised squared error of the corrected holes per coordinate: 1 if the predicted
  /// uncertainties are honest. The holes of one job share their fits, so one job scatters widely.
  double mean_normalized_square() const;

  /// A short table for people.
  std::string summary() const;

 private:
  const Truth& truth_;
  Eigen::Matrix2d of_hole_mm2_;
  Errors all_;
  std::map<int, Errors> by_tool_;
  double sum_normalized_squares_ = 0;
  std::int64_t n_normalized_ = 0;
};

}  // namespace panelcal
