// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "program/model/operation.h"

namespace panelcal {

// Names in output files of the kinds that operation.h gives no name.

constexpr std::string_view word(PlungeKind kind) {
  return kind == PlungeKind::Plain ? "plain" : "contouring";
}

constexpr std::string_view word(CompensationSide side) {
  switch (side) {
    case CompensationSide::Left:
      return "left";
    case CompensationSide::Right:
      return "right";
    case CompensationSide::Off:
      break;
  }
  return "off";
}

constexpr std::string_view word(CorrectionLevel level) {
  return level == CorrectionLevel::Base ? "base" : "nested";
}

constexpr std::string_view word(const Retract& retract) {
  return retract.with_clamping ? "clamping" : "free";
}

/// Standard deviations of the corrected place along x and y, mm.
inline Eigen::Vector2d sigma_mm(const PlacedPoint& place) {
  return Eigen::Vector2d(place.cov_mm2(0, 0), place.cov_mm2(1, 1)).cwiseSqrt();
}

}  // namespace panelcal
