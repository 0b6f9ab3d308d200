// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include "calib/advice/target_design.h"
#include "program/walk/walk.h"

namespace panelcal::plan {

/// Rule for the model that a job fits to a series, by its targets: before they are measured, and
/// with more of them than the program has.
///
/// Source CNC-7 manual, Vision Assist, G36 (by targets); SIEB & MEYER G31 (by equations) and CAMA
/// See    tests/tools/plan/design/models_test.cc, where the walk itself is the judge
struct ModelRule {
  Dialect dialect = Dialect::Excellon;
  std::optional<PanelModel> fixed;  ///< [vision] model; absent: what the manual says
  bool fits_scale = false;          ///< [vision] scale, of SIEB & MEYER

  PanelModel operator()(CorrectionLevel level, std::span<const DesignTarget> targets) const;

  /// More than these a series cannot have: a SIEB & MEYER pattern measures two (CAMA).
  std::size_t most_targets(CorrectionLevel level) const {
    const bool is_pattern = dialect == Dialect::SiebMeyer && level == CorrectionLevel::Nested;
    return is_pattern ? 2 : std::numeric_limits<std::size_t>::max();
  }
};

}  // namespace panelcal::plan
