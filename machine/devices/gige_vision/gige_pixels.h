// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "vision/picture/image.h"
#include <arv.h>

namespace panelcal::internal {

/// The GenICam name of a format that is read: "Mono8" for "mono8". Letters may be large or small.
std::optional<std::string_view> genicam_format(std::string_view word);

/// Notation of a format in the address of a camera: "mono8" for "Mono8".
std::string address_format(std::string_view genicam);

/// The missing part of an incomplete frame.
const char* status_text(ArvBufferStatus status);

/// A whole frame as a grey picture.
///
/// Fails  device-frame (a format that is not read, fewer bytes than pixels)
Expected<Image> image_of(ArvBuffer& buffer, const std::string& camera);

}  // namespace panelcal::internal
