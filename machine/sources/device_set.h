// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/devices/calibration_devices.h"
#include "machine/devices/camera.h"
#include "machine/devices/spindle.h"
#include "machine/devices/stage.h"

namespace panelcal {

/// Owns the stage, the spindle and the camera that a calibration works with.
class DeviceSet {
 public:
  /// The virtual machine of [sim] and [sim.coupon]. Waiting moves its own clock. Random parts are
  /// a function of [sim] seed and of the coupon's rows that are used up, so that two nights differ
  /// and one night repeats. The table's surface is that of `now`.
  ///
  /// Fails  config-value (no [sim] or no [camera]); vision-tool-undefined; what used_rows reports
  static Expected<DeviceSet> simulated(const MachineConfig& config,
                                       std::chrono::sys_seconds now = {});

  /// The parts that open_control opens, [machine] drill_command (which may be absent: then the
  /// spindle cannot drill) and a camera by its address.
  ///
  /// Fails  camera-uri; config-value (nothing drives the stage); what open_camera and open_control
  ///        report
  static Expected<DeviceSet> live(const MachineConfig& config, std::string_view camera_uri);

  /// They live as long as this set, also when it is moved.
  CalibrationDevices devices(Prompt prompt = {}) const;
  /// For people.
  const std::string& words() const { return words_; }
  /// CameraDevice::risks of the camera.
  std::vector<Diagnostic> risks() const;

 private:
  struct Owned;
  explicit DeviceSet(std::shared_ptr<Owned> owned, std::string words);

  std::shared_ptr<Owned> owned_;
  std::string words_;
};

}  // namespace panelcal
