// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "program/judge/job_verdict.h"
#include "program/judge/place_budget.h"
#include "program/judge/risk_basis.h"
#include "program/model/operation.h"
#include "program/walk/survey.h"

namespace panelcal {

/// "stage repeatability, table residual and drill wander not stated"; empty if all are.
std::string unstated_words(const MachineUncertainty& machine);

/// Of a job that has passed.
///
/// In     survey, machine: what it was walked with
RiskBasis risk_basis(const JobVerdict& verdict,
                     const Survey& survey,
                     const MachineUncertainty& machine);

/// The risk of one place in words: "1.5e-08", "no figure: drill wander not stated".
///
/// Precondition: place.judged_risk is present
std::string risk_words(const PlacedPoint& place,
                       const BudgetPlace& budget_place,
                       const Survey& survey,
                       const MachineUncertainty& machine);

}  // namespace panelcal
