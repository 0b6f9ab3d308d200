// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

namespace panelcal::internal {

/// A grey picture as baseline JPEG; empty where libjpeg fails (no memory).
///
/// In     levels: row by row, width * height of them; quality: 1 to 100
std::string encode_grey_jpeg(std::span<const unsigned char> levels,
                             int width,
                             int height,
                             int quality);

}  // namespace panelcal::internal
