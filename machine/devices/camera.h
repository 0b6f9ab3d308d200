// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "vision/picture/image.h"

namespace panelcal {

/// The settings of a picture besides the place.
enum class CameraSetting : std::uint8_t {
  Lamp,      ///< as `$uvis,lamp` writes it
  Zoom,      ///< as `$uvis,zoom` writes it
  Focus,     ///< height of the focus axis, mm
  Exposure,  ///< us
};
inline constexpr std::size_t kCameraSettings = 4;

constexpr std::string_view name(CameraSetting setting) {
  switch (setting) {
    case CameraSetting::Lamp:
      return "lamp";
    case CameraSetting::Zoom:
      return "zoom";
    case CameraSetting::Focus:
      return "focus";
    case CameraSetting::Exposure:
      return "exposure";
  }
  return "";
}

/// Width and height, px.
struct PictureSize {
  int width = 0;
  int height = 0;
};

/// A source of pictures, one at a time: a camera on the wire, a video, a folder.
class CameraDevice {
 public:
  virtual ~CameraDevice() = default;

  /// A picture that a live camera exposed after this call began: one that waited in a buffer would
  /// show where the stage stood before. A recording gives its next one.
  ///
  /// Fails  device-frame (lost, late or damaged frames; the end of a recording); what reading a
  ///        picture file reports
  virtual Expected<Image> take() = 0;

  /// For people: the address it was opened by.
  virtual std::string name() const = 0;

  /// Of the pictures to come; absent if only a picture tells.
  virtual std::optional<PictureSize> size() const { return std::nullopt; }

  /// Number of frames that arrived damaged or not at all and were taken again.
  virtual int n_retaken() const { return 0; }

  /// Changes that the camera makes to its pictures by itself, as warnings; empty if it is held.
  virtual std::vector<Diagnostic> risks() const { return {}; }

  /// Few cameras have a lamp, a zoom or a focus of their own.
  virtual bool can_set(CameraSetting /*setting*/) const { return false; }
  /// The value in force; absent where the camera does not tell it.
  virtual std::optional<double> value(CameraSetting /*setting*/) const { return std::nullopt; }
  /// Fails  not-supported (see can_set); device errors
  virtual Expected<void> set(CameraSetting setting, double /*value*/) {
    return failure({Code::NotSupported,
                    {name(), 0, 0},
                    "the camera has no " + std::string(panelcal::name(setting)) + " to set",
                    ""});
  }
};

}  // namespace panelcal
