// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "calib/base/expected.h"
#include "machine/devices/camera.h"

namespace panelcal {

/// The PNG, TIFF, BMP and JPEG files of a folder as a camera that takes them in the order of their
/// names.
///
/// Fails  file-unreadable (no folder); picture-missing (no picture in it)
Expected<std::unique_ptr<CameraDevice>> open_folder_camera(const std::filesystem::path& folder);

}  // namespace panelcal
