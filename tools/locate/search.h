// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "calib/camera/mapping.h"
#include "machine/config/settings/machine.h"
#include "vision/fit/detection.h"
#include "vision/fit/target.h"
#include "vision/picture/image.h"
#include "vision/picture/picture_form.h"

namespace panelcal {

/// The target that is looked for in pictures, and how: a vision tool of a machine.
struct TargetSearch {
  Target target;
  std::optional<CameraMapping> mapping;  ///< of a target whose size is in mm
  LocateOptions options;
  PictureForm form;
  int width_px = 0;  ///< of the pictures that `mapping` is calibrated for
  int height_px = 0;
};

/// Fails  vision-tool-undefined
Expected<TargetSearch> target_search(const MachineConfig& machine, int tool);

/// Checks that a picture is one of those that the mapping is for.
///
/// In     file: as diagnostics name it
/// Fails  picture-mismatch
Expected<void> check_picture_size(const std::string& file,
                                  const Image& image,
                                  const TargetSearch& search);

}  // namespace panelcal
