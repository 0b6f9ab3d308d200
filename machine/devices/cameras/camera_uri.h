// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "calib/base/expected.h"
#include "machine/devices/camera.h"
#include "machine/devices/cameras/gige_camera.h"
#include "machine/devices/cameras/opencv_camera.h"
#include "machine/devices/cameras/without_password.h"

namespace panelcal {

/// folder:DIR
struct FolderAddress {
  std::string folder;
};

using CameraAddress = std::variant<FolderAddress, VideoAddress, GigeAddress>;

/// Takes a camera's address apart:
///
///   folder:DIR                                      pictures in the order of their names
///   video:FILE                                      frames of a video file
///   v4l2:/dev/video0?width=1280&height=960&exposure_us=8000&gain=0&focus=30&white_balance_k=4600&
///          power_line_hz=50                         a USB camera
///   rtsp://HOST/PATH                                a network camera; passed on as it is
///   gige://192.168.1.20?packet=1500&exposure_us=2000&gain=1.5&format=mono8&timeout_ms=1000&
///          retries=20&resend=on                     GigE Vision, by the camera's IPv4 address
///
/// Fails  camera-uri, naming the part, what was expected and the nearest known word
Expected<CameraAddress> parse_camera_uri(std::string_view uri);

/// Opens the camera of an address.
///
/// Fails  camera-uri; file-unreadable; picture-format (a file that is no video); device-camera
///        (no answer, no camera, busy, refuses a setting, or built without)
Expected<std::unique_ptr<CameraDevice>> open_camera(std::string_view uri);

}  // namespace panelcal
