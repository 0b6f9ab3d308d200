// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/devices/calibration_devices.h"
#include "machine/devices/camera.h"

// Lamp and focus of a machine that calibrates: the camera's own, or else the machine's.
namespace panelcal {

/// Fails  config-value (neither the camera nor the machine can set it)
Expected<void> check_can_set(const MachineConfig& config,
                             const CalibrationDevices& devices,
                             CameraSetting setting);

/// Fails  as check_can_set; device errors
Expected<void> set_camera(const MachineConfig& config,
                          const CalibrationDevices& devices,
                          CameraSetting setting,
                          double value);

/// The level that the camera stands at unless a program asks for another: its [[camera.zoom]] names
/// the file of [camera].
std::optional<double> usual_zoom(const MachineConfig& config);

/// Sets lamp and focus as [camera] lamp and focus_mm say, so that a calibration sees what jobs see,
/// and the usual zoom, where a calibration that was cut off may have left another. What they do not
/// say stays as it is.
///
/// Fails  as set_camera
/// See    tests/machine/devices/cameras/camera_settings_test.cc
Expected<void> set_camera_as_stated(const MachineConfig& config, const CalibrationDevices& devices);

}  // namespace panelcal
