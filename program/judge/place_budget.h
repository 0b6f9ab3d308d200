// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <utility>

#include "calib/correction/error_budget.h"
#include "program/model/operation.h"
#include "program/walk/survey.h"

namespace panelcal {

/// The record of a place from which its error budget can be made later.
struct BudgetPlace {
  Position<frame::Nominal> nominal;          ///< reference scaling done
  std::optional<std::size_t> base_series;    ///< in force there; index into Survey::series
  std::optional<std::size_t> nested_series;  ///< the same
  std::optional<std::size_t> i_measurement;  ///< of a hole at its own target
};
BudgetPlace budget_place(const PlacedPoint& point, const Origin& origin);

/// The corrections in force there.
CorrectionStack corrections_at(const BudgetPlace& place,
                               const Survey& survey,
                               const MachineUncertainty& machine);

/// The budget of a place; empty where no correction was in force. Its sum is the place's
/// covariance, but for rounding.
ErrorBudget error_budget(const BudgetPlace& place,
                         const Survey& survey,
                         const MachineUncertainty& machine);

/// The part of places' covariances that comes from pictures, from not knowing the panel's model,
/// and from calibrations of the job itself: what a simulated job draws. Keeps what all places under
/// one correction share.
///
/// Precondition: the survey outlives this
class PictureCovariance {
 public:
  PictureCovariance(const Survey& survey, MachineUncertainty machine)
      : survey_(survey), machine_(std::move(machine)) {}
  /// Zero where no correction was in force.
  Eigen::Matrix2d at_mm2(const BudgetPlace& place);

 private:
  Eigen::Matrix2d of_offset_mm2(const BudgetPlace& place) const;

  const Survey& survey_;
  MachineUncertainty machine_;
  std::optional<std::size_t> base_series_;  ///< that corrections_ belongs to
  std::optional<std::size_t> nested_series_;
  CorrectionStack corrections_;
  Eigen::Matrix<double, 6, 6> coefficients_cov_ = Eigen::Matrix<double, 6, 6>::Zero();
};

}  // namespace panelcal
