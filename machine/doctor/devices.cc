// SPDX-License-Identifier: Apache-2.0
// Camera, control and probe: opened and closed, never moved.
#include <cerrno>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <variant>

#include "machine/devices/cameras/camera_uri.h"
#include "machine/devices/controls/open/open_control.h"
#include "machine/doctor/checks.h"
#include <fmt/format.h>
#include <unistd.h>

namespace panelcal::doctor {
namespace {

constexpr const char* kTryIt = "--devices, while no other program uses the machine";

/// Of a device file; empty: it may be read and written.
std::string access_problem(const std::string& device) {
  if (::access(device.c_str(), R_OK | W_OK) == 0) return {};
  return std::error_code(errno, std::generic_category()).message();
}

/// False if the device cannot be opened, which is said.
bool check_device_file(const std::string& subject,
                       const std::string& device,
                       const char* group,
                       Findings& findings) {
  const std::string problem = access_problem(device);
  if (problem.empty()) return true;
  findings.fail(
      subject,
      device + ": " + problem,
      fmt::format("plug it in; where it is there, `sudo adduser $USER {}` and log in anew", group));
  return false;
}

/// What can be said of a camera without opening it; false if it cannot be opened.
bool check_camera_address(const CameraAddress& address, Findings& findings) {
  if (const auto* video = std::get_if<VideoAddress>(&address)) {
    return video->kind != VideoAddress::Kind::V4l2 ||
           check_device_file("camera device", video->what, "video", findings);
  }
  const auto* folder = std::get_if<FolderAddress>(&address);
  std::error_code ignored;
  if (folder == nullptr || std::filesystem::is_directory(folder->folder, ignored)) return true;
  findings.fail("camera device", quoted(folder->folder) + " is no folder", "a folder of pictures");
  return false;
}

void check_picture(const MachineConfig& config, const std::string& uri, Findings& findings) {
  constexpr const char* kSubject = "camera device";
  const Expected<std::unique_ptr<CameraDevice>> camera = open_camera(uri);
  if (!camera) return findings.add(kSubject, camera.error());
  const Expected<Image> picture = (*camera)->take();
  if (!picture) return findings.add(kSubject, picture.error());
  const std::string size = fmt::format("{} x {} px", picture->width(), picture->height());
  std::string text = fmt::format("{}: a picture of {}", (*camera)->name(), size);
  if (const auto exposure_us = (*camera)->value(CameraSetting::Exposure)) {
    text += fmt::format(", exposure {} us", *exposure_us);
  }
  for (const Diagnostic& risk : (*camera)->risks()) findings.add(kSubject, risk);
  if (config.camera && (config.camera->picture_width_px != picture->width() ||
                        config.camera->picture_height_px != picture->height())) {
    return findings.fail(kSubject,
                         fmt::format("{}, and the calibration is of {} x {} px",
                                     text,
                                     config.camera->picture_width_px,
                                     config.camera->picture_height_px),
                         "the calibrated size in the camera's address, or a new calibration");
  }
  findings.ok(kSubject, text);
}

void check_camera(const MachineConfig& config, const Examination& examination, Findings& findings) {
  constexpr const char* kSubject = "camera device";
  std::string uri = examination.camera;
  if (uri.empty() && config.nightly) uri = config.nightly->camera;
  if (uri.empty()) {
    if (!config.camera || (config.nightly && config.nightly->is_simulated)) return;
    return findings.not_tried(
        kSubject, "machine.toml names no camera's address", "--camera ADDRESS");
  }
  const Expected<CameraAddress> address = parse_camera_uri(uri);
  if (!address) return findings.add(kSubject, address.error());
  if (!check_camera_address(*address, findings)) return;
  if (examination.opens_devices) return check_picture(config, uri, findings);
  findings.not_tried(kSubject, uri + " is not opened", kTryIt);
}

/// In     config: as it is opened
void open_and_close(const MachineConfig& config, Findings& findings) {
  constexpr const char* kSubject = "control";
  const Expected<OpenedControl> control = open_control(config);
  if (!control) return findings.add(kSubject, control.error());
  findings.ok(kSubject, control->words + ": ready to be moved");
  if (control->probe) findings.ok("probe", "by the control; not touched with");
}

void check_control(const MachineConfig& config,
                   const Examination& examination,
                   Findings& findings) {
  constexpr const char* kSubject = "control";
  const ControlSetting& setting = config.control;
  if (!setting.driver) return;  // commands: check_programs()
  if (!setting.device.empty() &&
      !check_device_file(kSubject, setting.device, "dialout", findings)) {
    return;
  }
  if (!examination.opens_devices) {
    return findings.not_tried(
        kSubject,
        (setting.device.empty() ? setting.host : setting.device) + " is not opened",
        kTryIt);
  }
  MachineConfig still = config;
  if (setting.homing == Homing::WhenLocked) still.control.homing = Homing::Required;
  open_and_close(still, findings);
}

}  // namespace

void check_devices(const MachineConfig& config,
                   const Examination& examination,
                   Findings& findings) {
  check_camera(config, examination, findings);
  check_control(config, examination, findings);
}

}  // namespace panelcal::doctor
