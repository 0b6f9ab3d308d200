// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "panelcal/calib/error_budget.h"
#include "panelcal/program/operation.h"
#include "panelcal/program/survey.h"

namespace panelcal {

/// What one has to remember of a place to say later where its uncertainty comes from.
struct BudgetPlace {
  Position<frame::Nominal> nominal;          ///< reference scaling done
  std::optional<std::size_t> base_series;    ///< in force there; index into Survey::series
  std::optional<std::size_t> nested_series;  ///< the same
  std::optional<std::size_t> i_measurement;  ///< of a hole at its own target
};
BudgetPlace budget_place(const PlacedPoint& point, const Origin& origin);

/// The budget of a place; empty where no correction was in force. Its sum is the place's
/// covariance, but for rounding.
ErrorBudget error_budget(const BudgetPlace& place,
                         const Survey& survey,
                         const MachineUncertainty& machine);

}  // namespace panelcal
