// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "calib/panel/fit.h"

namespace panelcal {

/// Score of one model for a series, for comparing.
struct ModelScore {
  PanelModel model = PanelModel::Offset;
  bool is_smooth = false;  ///< a bending on top of the affine map (calib/panel/smooth_panel.h)
  double parameters = 0;   ///< effective number: of a smooth model a fraction
  double chi_square = 0;
  double criterion = 0;  ///< Akaike's, smaller is better
  /// Root mean square over targets of the distance to where the others' fit puts them; absent where
  /// the others do not determine the model.
  std::optional<double> left_out_mm;
  bool is_eligible = false;  ///< leave-one-out can examine it, or the manual prescribes it
  bool is_chosen = false;    ///< by the evidence, whatever is in force
};

/// "offset" to "affine", or "smooth".
std::string_view name(const ModelScore& score);

}  // namespace panelcal
