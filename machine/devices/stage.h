// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "machine/devices/camera.h"

namespace panelcal {

/// The drive that carries the spindle, with the camera beside it, over the panel.
class Stage {
 public:
  virtual ~Stage() = default;

  /// Drives the point under the spindle to a place and returns where it really stands, which may
  /// differ: only a stage with scales knows.
  ///
  /// Fails  device-stage
  virtual Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) = 0;

  /// A machine may have a lamp, a zoom or a focus axis that the camera does not know of.
  virtual bool can_set(CameraSetting /*setting*/) const { return false; }
  /// Fails  not-supported (see can_set); device-stage
  virtual Expected<void> set(CameraSetting setting, double /*value*/) {
    return failure({Code::NotSupported,
                    {"stage", 0, 0},
                    "the machine has no " + std::string(panelcal::name(setting)) + " to set",
                    ""});
  }
};

}  // namespace panelcal
