// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/camera_settings.h"

#include <algorithm>

#include <fmt/format.h>

namespace panelcal {

Expected<void> check_can_set(const MachineConfig& config,
                             const CalibrationDevices& devices,
                             CameraSetting setting) {
  if (devices.camera.can_set(setting) || devices.stage.can_set(setting)) return {};
  return failure({Code::ConfigValue,
                  {config.file.string(), 0, 0},
                  fmt::format("neither the camera nor the machine has a {} to set", name(setting)),
                  fmt::format("[machine] {}_command", name(setting))});
}

Expected<void> set_camera(const MachineConfig& config,
                          const CalibrationDevices& devices,
                          CameraSetting setting,
                          double value) {
  PANELCAL_CHECK(check_can_set(config, devices, setting));
  return devices.camera.can_set(setting) ? devices.camera.set(setting, value)
                                         : devices.stage.set(setting, value);
}

std::optional<double> usual_zoom(const MachineConfig& config) {
  const auto found = std::ranges::find_if(config.zoom_files, [&](const auto& zoom) {
    return zoom.second.lexically_normal() == config.camera_file.lexically_normal();
  });
  return found == config.zoom_files.end() ? std::nullopt : std::optional(found->first);
}

Expected<void> set_camera_as_stated(const MachineConfig& config,
                                    const CalibrationDevices& devices) {
  const VisionOptions& vision = config.vision;
  const std::optional<double> zoom = usual_zoom(config);
  if (zoom && check_can_set(config, devices, CameraSetting::Zoom)) {
    PANELCAL_CHECK(set_camera(config, devices, CameraSetting::Zoom, *zoom));
  }
  if (vision.lamp) PANELCAL_CHECK(set_camera(config, devices, CameraSetting::Lamp, *vision.lamp));
  if (!vision.focus) return {};
  return set_camera(config, devices, CameraSetting::Focus, vision.focus->in_mm());
}

}  // namespace panelcal
