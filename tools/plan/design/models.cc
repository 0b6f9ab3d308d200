// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/design/models.h"

namespace panelcal::plan {

PanelModel ModelRule::operator()(CorrectionLevel level,
                                 std::span<const DesignTarget> targets) const {
  if (dialect == Dialect::Excellon) {
    const auto n = static_cast<int>(targets.size());
    if (n <= 1) return PanelModel::Offset;
    return model_at_most(fixed.value_or(default_model(n)), 2 * n, false);
  }
  if (level == CorrectionLevel::Nested) return PanelModel::Offset;
  int n_equations = 0;
  for (const DesignTarget& target : targets) {
    n_equations += target.axes == ObservedAxes::Both ? 2 : 1;
  }
  if (n_equations <= 2) return PanelModel::Offset;
  const PanelModel usual = default_model_of_equations(n_equations, fits_scale);
  return model_at_most(fixed.value_or(usual), n_equations, fits_scale);
}

}  // namespace panelcal::plan
