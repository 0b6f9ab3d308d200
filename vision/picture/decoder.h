// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "vision/picture/image_header.h"
#include <opencv2/core.hpp>

namespace panelcal::internal {

/// A decoder's picture, or empty, and what it had to say.
struct Decoded {
  cv::Mat mat;
  std::string messages;
};

/// Decodes as it stands in the file: no gamma, no conversion of colours, no orientation tag but
/// TIFF's (see tiff_directory.h).
///
/// In     bytes that picture_kind recognised, so that no decoder but that kind's gets to see them
Decoded run_decoder(std::string_view bytes, PictureKind kind);

/// True if the decoder went on after damage with made-up pixels, of which it only speaks. What
/// it says of PNG is not about pixels: those are under check sums.
bool is_patched(const Decoded& decoded, PictureKind kind);

/// The decoder's words in one printable line that goes on with ": "; empty if it said nothing.
std::string reason_of(const Decoded& decoded);

}  // namespace panelcal::internal
