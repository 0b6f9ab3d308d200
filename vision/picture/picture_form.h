// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "vision/picture/bayer.h"
#include "vision/picture/image.h"

namespace panelcal {

/// Interpretation of a camera's picture files, where they do not state it.
struct PictureForm {
  /// [camera] bayer: files are a colour sensor's mosaic as it is, of this pattern.
  std::optional<BayerPattern> bayer = {};
  /// [camera] bits: files of 16 bit hold numbers of this many bits, the lowest ones, so that white
  /// is 2^bits - 1. Contrasts count in parts of white.
  std::optional<int> bits = {};
};

/// The picture that a file's levels mean; levels above white are white.
///
/// See    tests/vision/picture/picture_form_test.cc
Image understood(Image image, const PictureForm& form);

}  // namespace panelcal
