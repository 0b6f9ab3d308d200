// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "panelcal/calib/error_budget.h"
#include "panelcal/program/place_budget.h"

namespace panelcal {

/// One hole and where its uncertainty comes from.
struct HoleBudget {
  int line = 0;
  std::string file;  ///< of a stored pattern; empty: the program itself
  InstancePath path;
  int tool = 0;
  Position<frame::Nominal> nominal;
  ErrorBudget budget;
};

/// Remembers the hole whose sigma is largest, in its worst direction; of equal ones the first.
class WorstHole final : public OperationSink {
 public:
  void put(const Operation& operation) override;
  /// Empty if no hole was corrected.
  std::optional<HoleBudget> budget(const Survey& survey, const MachineUncertainty& machine) const;

 private:
  Length sigma_;
  HoleBudget hole_;
  BudgetPlace place_;
};

namespace report {

/// "Where the uncertainty comes from": the budget of a hole, and which errors all holes share.
/// Empty without one.
std::string budget_section(const std::optional<HoleBudget>& hole);

}  // namespace report
}  // namespace panelcal
