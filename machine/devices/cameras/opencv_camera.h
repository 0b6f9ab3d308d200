// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "calib/base/expected.h"
#include "machine/devices/camera.h"
#include "machine/devices/cameras/v4l2_controls.h"

namespace panelcal {

/// The addresses that OpenCV's video part reads: video:FILE, v4l2:DEVICE, rtsp://...
struct VideoAddress {
  enum class Kind : std::uint8_t { File, V4l2, Rtsp };
  Kind kind = Kind::File;
  std::string what;  ///< a file, a device, a whole rtsp:// address
  int width = 0;     ///< of a V4L2 device's pictures, px; 0: as the device has it
  int height = 0;
  V4l2Settings settings = {};  ///< of a V4L2 device
};

/// Opens a video or a camera through OpenCV.
///
/// A video file gives its frames in order. Live cameras keep frames waiting in buffers; take()
/// passes over them: by the driver's time stamps where it gives some (grab_stamped_frame()), else
/// until it has had to wait for frames that are new. What a network stream delays on its way it
/// cannot know: that belongs into [machine] settle_s.
///
/// A V4L2 camera is held (V4l2Controls), and each picture is checked to have been taken so.
///
/// Colour becomes grey as in read_image. Compression moves edges: a video is no place to measure to
/// micrometres.
///
/// Fails  file-unreadable; picture-format (no video); device-camera (cannot be opened; does not
/// take
///        a stated setting; the module libpanelcal_video.so is not installed)
/// Note   OpenCV's video part brings 100 libraries, which would take 60 ms of every command's
/// start;
///        so it lies in a module that is loaded when it is needed
Expected<std::unique_ptr<CameraDevice>> open_opencv_camera(const VideoAddress& address);

}  // namespace panelcal
