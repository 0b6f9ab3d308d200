// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "calib/camera/model.h"

namespace panelcal {

/// Free parameters of the camera model, from stiff to soft; each form has all of the one before it.
enum class CameraForm {
  Flat,          ///< scale, rotation
  Radial,        ///< and k1
  Tilted,        ///< and the tilt
  TiltedRadial,  ///< and k2
  Tangential,    ///< and p1, p2
};
inline constexpr std::array kCameraForms = {CameraForm::Flat,
                                            CameraForm::Radial,
                                            CameraForm::Tilted,
                                            CameraForm::TiltedRadial,
                                            CameraForm::Tangential};
std::string_view name(CameraForm form);
std::vector<CameraParameter> free_parameters(CameraForm form);

}  // namespace panelcal
