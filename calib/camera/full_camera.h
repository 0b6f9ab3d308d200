// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/camera/form.h"
#include "calib/camera/model.h"

namespace panelcal {

/// The result of a fit of a camera that need not look straight down.
struct FullCamera {
  CameraForm form = CameraForm::Flat;
  CameraModel::Parameters parameters;
  CameraModelCovariance covariance = CameraModelCovariance::Zero();  ///< of held ones 0
  std::vector<CameraParameter> undetermined;  ///< of the form, but held: the data left them open
  std::optional<double> zoom;                 ///< level it was calibrated at; absent: it has none
  double rms_px = 0;                          ///< of the residuals' lengths
  std::optional<double> held_out_rms_px;      ///< of observations that the fit did not see
};

}  // namespace panelcal
