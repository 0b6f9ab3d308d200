// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/picture/image.h"
#include "vision/suggest/seen_mark.h"

namespace panelcal {

/// Options of the search for marks in a picture.
struct MarkOptions {
  int n_levels = 24;           ///< thresholds between the picture's darkest and brightest levels
  double min_contrast = 0.03;  ///< of full scale
  double min_size_px = 8;
  bool reads_tags = true;  ///< of the families tag36h11, tagStandard41h12 and tag25h9
};

/// Everything round, square, cross-shaped or tagged in a picture, to tell a person what could be a
/// target; not to measure it.
///
/// The picture is cut at several levels; an outline that keeps its shape over neighbouring levels
/// is a mark (as in maximally stable regions), and its size is that at the level half way between
/// inside and outside. A bright disc around a dark one is a ring. What touches the picture's border
/// is left out.
///
/// Out    in the order of the picture's rows
/// Fails  never: a picture that cannot be looked at has no marks
/// Cost   about 2 ms a level for 640 x 480 px
/// Source Matas, Chum, Urban and Pajdla 2002 (stability over thresholds)
/// See    tests/vision/suggest/find_marks_test.cc
std::vector<SeenMark> find_marks(const Image& image, const MarkOptions& options = {});

}  // namespace panelcal
