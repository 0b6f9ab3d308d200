// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/correction/error_budget.h"
#include "calib/correction/max_sigma.h"
#include "program/judge/job_verdict.h"
#include "program/judge/place_budget.h"

namespace panelcal {

/// One place and where its uncertainty comes from.
struct HoleBudget {
  int line = 0;
  std::string file;  ///< of a stored pattern; empty: the program itself
  InstancePath path;
  int tool = 0;
  Position<frame::Nominal> nominal;
  bool is_likeliest_to_break = false;  ///< otherwise it is the least certain
  std::optional<double> risk;          ///< of breaking its tolerance then, if that is told
  ErrorBudget budget;
};

/// Remembers the hole whose sigma is largest, in its worst direction; of equal ones the first.
class WorstHole final : public OperationSink {
 public:
  void put(const Operation& operation) override;
  /// Empty if no hole was corrected.
  std::optional<HoleBudget> budget(const Survey& survey, const MachineUncertainty& machine) const;

 private:
  MaxSigma sigma_;
  HoleBudget hole_;
  BudgetPlace place_;
};

/// Of the place that is likeliest to break its tolerance, which the verdict names; empty if no
/// place was judged.
std::optional<HoleBudget> likeliest_to_break(const JobVerdict& verdict,
                                             const Survey& survey,
                                             const MachineUncertainty& machine);

}  // namespace panelcal
