// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/form.h"

#include <cstddef>

namespace panelcal {
namespace {

/// The order in which parameters take up what there is to know.
constexpr std::array kStiffToSoft = {CameraParameter::Scale,
                                     CameraParameter::Rotation,
                                     CameraParameter::K1,
                                     CameraParameter::TiltX,
                                     CameraParameter::TiltY,
                                     CameraParameter::K2,
                                     CameraParameter::P1,
                                     CameraParameter::P2};

constexpr std::array<std::size_t, 5> kFree = {2, 3, 5, 6, 8};  ///< of those, by form

}  // namespace

std::string_view name(CameraForm form) {
  constexpr std::array<std::string_view, 5> kNames = {
      "flat", "radial", "tilted", "tilted radial", "tangential"};
  return kNames[static_cast<std::size_t>(form)];
}

std::vector<CameraParameter> free_parameters(CameraForm form) {
  return {kStiffToSoft.begin(), kStiffToSoft.begin() + kFree[static_cast<std::size_t>(form)]};
}

}  // namespace panelcal
