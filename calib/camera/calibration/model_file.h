// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/base/json/strict_json.h"
#include "calib/camera/full_camera.h"

// Not installed: public headers know nothing of JSON.
namespace panelcal::internal {

/// The keys of version 2 that version 1 does not have.
std::span<const std::string_view> model_keys();

/// Reads "form", "parameters", "covariance", "undetermined", "zoom", "rms_px" and
/// "held_out_rms_px" of version 2.
///
/// Fails  calibration-invalid
Expected<FullCamera> read_full_camera(const StrictObject& top, const std::string& file);

/// The same members as the file has them, each line indented and ended by a comma but the last.
std::string full_camera_text(const FullCamera& camera);

/// Checks beyond the types of the file.
Expected<void> check_full_camera(const FullCamera& camera,
                                 int width_px,
                                 int height_px,
                                 const std::string& file);

}  // namespace panelcal::internal
