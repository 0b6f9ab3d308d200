// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/units.h"
#include "machine/sim/truth.h"
#include "program/judge/job_verdict.h"
#include "program/judge/place_budget.h"
#include "program/model/operation.h"

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
  /// All of a hole's covariance counts as predicted.
  explicit TruthComparison(const Truth& truth) : truth_(truth) {}
  /// Only what pictures say counts as predicted: a simulated job draws neither the stage nor the
  /// table, the drill, or errors of the spindle-camera offset and the camera's calibration.
  ///
  /// In     machine: what the job is walked with
  /// Precondition: truth and survey outlive this
  TruthComparison(const Truth& truth, const Survey& survey, MachineUncertainty machine)
      : truth_(truth), of_pictures_(std::in_place, survey, std::move(machine)) {}
  void put(const Operation& operation) override;

  struct Errors {
    ErrorStatistics corrected;
    ErrorStatistics uncorrected;
  };
  const Errors& all() const { return all_; }
  const std::map<int, Errors>& by_tool() const { return by_tool_; }
  /// Mean squared error of the corrected holes over what is predicted of it (see the constructors),
  /// per coordinate: 1 if that is honest; 0 if nothing is predicted of any. The holes of one job
  /// share their fits, so one job scatters widely.
  double mean_normalized_square() const;

  /// A short table for people.
  std::string summary() const;

 private:
  Position<frame::Actual> true_place(const Operation& operation, const Drill& drill) const;

  const Truth& truth_;
  std::optional<PictureCovariance> of_pictures_;
  Errors all_;
  std::map<int, Errors> by_tool_;
  double sum_normalized_squares_ = 0;
  std::int64_t n_normalized_ = 0;
};

}  // namespace panelcal
