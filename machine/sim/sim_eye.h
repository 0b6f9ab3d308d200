// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/statistics/random.h"
#include "calib/base/units.h"
#include "machine/config/machine_config.h"
#include "machine/devices/camera.h"
#include "vision/fit/target.h"
#include "vision/render/render.h"

namespace panelcal::internal {

/// A mark before the camera of a virtual machine.
struct SimSeenMark {
  Target target;
  Position<frame::Machine> place;
  Angle turn;     ///< on top of the target's own angle, the same way round
  Random random;  ///< of this mark, see sim_mark
};

/// The camera of a virtual machine that drives over marks, with the lamp and the focus axis of
/// [sim].
class SimEye {
 public:
  /// Precondition: config has [sim] and [camera]
  SimEye(const MachineConfig& config, Random noise);

  /// True if [sim] says what a lamp or a focus axis does.
  bool has(CameraSetting setting) const;
  /// One that it does not tell of changes nothing.
  void set(CameraSetting setting, double value);

  /// Looks with another camera from here on: another zoom. Lamp and focus stay as they are.
  ///
  /// Precondition: config has [sim] and [camera]
  void look_through(const MachineConfig& config);

  /// In     axis: where the optical axis really stands
  Image picture(const Position<frame::Machine>& axis, const std::vector<SimSeenMark>& marks);

 private:
  SimConfig sim_;
  CameraMapping calibrated_;
  Camera camera_;
  Random noise_;
  Length focus_;     ///< [camera] focus_mm, or 0, until it is set
  double lamp_ = 1;  ///< against the one that [sim] describes
};

}  // namespace panelcal::internal
