// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "vision/fit/search_area.h"
#include "vision/picture/image.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A part of a picture, each pixel the mean of factor x factor of the picture's.
struct ReducedPicture {
  Image image;
  int factor = 1;
  int x0 = 0;  ///< of the part, in the picture
  int y0 = 0;

  /// The place in the picture of a place in `image`, px.
  Eigen::Vector2d in_picture(const Eigen::Vector2d& at) const {
    const double half = 0.5 * (factor - 1);
    return Eigen::Vector2d(x0 + half, y0 + half) + factor * at;
  }
};

/// Starts on a multiple of the factor, so that lattices of different boxes agree; a remainder at
/// the far ends is left out.
ReducedPicture reduce(const Image& image, const PixelBox& box, int factor);

/// A small picture to look for, of odd width and height; its reference place is its middle pixel.
struct SearchPattern {
  Image picture;
};

/// A place where a pattern fits best.
struct PatternPeak {
  Eigen::Vector2d at;         ///< in the reduced picture, px
  std::size_t i_pattern = 0;  ///< index of the pattern
  double correlation = 0;     ///< normalised, above 0
  double gain = 0;            ///< change of the picture's level per change of the pattern's
};

struct PatternSearchOptions {
  double min_correlation = 0.5;
  double min_gain = 0;    ///< least gain that counts, either way
  double same_place = 3;  ///< nearer peaks are one, reduced px
  std::size_t max_peaks = 24;
  bool is_inverted = false;  ///< looks for the patterns' negatives
};

/// Sees every place where one of the patterns, or its negative, fits: local maxima of the
/// normalised cross-correlation, the best first. Patterns may lie half outside of the picture.
///
/// Cost   0.5 ms for a pattern and 128 x 96 px
/// Source Lewis 1995 (fast normalised cross-correlation), as OpenCV has it
std::vector<PatternPeak> search_patterns(const ReducedPicture& picture,
                                         std::span<const SearchPattern> patterns,
                                         const PatternSearchOptions& options);

}  // namespace panelcal::internal
