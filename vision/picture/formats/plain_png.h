// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "vision/picture/image.h"

namespace panelcal::internal {

/// Reads a PNG of the kind that cameras write, at two to three times libpng's speed: 8 or 16 bit,
/// grey or colour with or without transparency, not interlaced, whole, with every checksum right.
///
/// Out    exactly what libpng would read; empty for every other file, damaged ones among them:
///        libpng is to judge those
/// Cost   memory for the samples beside the picture
/// Source PNG specification (third edition), 5 Datastream structure, 9 Filtering
/// See    tests/vision/picture/formats/plain_png_test.cc
std::optional<Image> read_plain_png(std::string_view bytes);

}  // namespace panelcal::internal
