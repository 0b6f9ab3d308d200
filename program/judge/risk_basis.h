// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "program/judge/place_budget.h"
#include "program/model/operation.h"
#include "program/walk/survey.h"

namespace panelcal {

class JobVerdict;

/// The basis of a job's risks: one decision that all outputs follow.
struct RiskBasis {
  enum class Kind : std::uint8_t {
    Stated,   ///< every figure may be printed
    Bounded,  ///< so may those above kLeastToldRisk
    Unknown,  ///< none: `words` in place of risk and Cpk
  };
  Kind kind = Kind::Stated;
  std::string words;  ///< the reason; empty if Stated
  /// The machine's largest terms are not stated: sigma is of the fit only.
  bool is_of_fit_only = false;

  bool tells_risk() const { return kind != Kind::Unknown; }
};

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
