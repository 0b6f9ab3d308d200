// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace panelcal {

/// The basis of a job's risks: one decision that all outputs follow.
struct RiskBasis {
  enum class Kind : std::uint8_t {
    Stated,   ///< every figure may be printed
    Bounded,  ///< so may those above kMinStatedRisk
    Unknown,  ///< none: `words` in place of risk and Cpk
  };
  Kind kind = Kind::Stated;
  std::string words;  ///< the reason; empty if Stated
  /// The machine's largest terms are not stated: sigma is of the fit only.
  bool is_of_fit_only = false;

  bool tells_risk() const { return kind != Kind::Unknown; }
};

}  // namespace panelcal
