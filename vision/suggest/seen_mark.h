// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "vision/fit/target.h"
#include <Eigen/Core>

namespace panelcal {

/// Something in a picture that could be a target: what it is, roughly where (0.3 px), and how
/// large.
struct SeenMark {
  Shape shape = Shape::Disc;  ///< Disc, Ring, Square, Diamond, Cross or AprilTag
  Polarity polarity = Polarity::Bright;
  Position<frame::Image> center;
  PixelLength size;                        ///< as Target::size means it
  std::optional<PixelLength> detail = {};  ///< a ring's inner diameter, a cross's bars
  Angle angle;          ///< as Target::angle means it, mathematically in (-45, 45]
  double contrast = 0;  ///< difference across its rim, 0 to 1 of full scale
  /// 0 to 1: how much of its rim lies on the shape's, times how well.
  double quality = 0;
  std::string family = {};  ///< of a tag
  std::optional<int> tag_id = {};
  std::vector<Eigen::Vector2d> outline_px = {};
};

/// Marks of one kind and like size.
struct MarkGroup {
  std::vector<SeenMark> marks;  ///< best first; never empty
  PixelLength size;             ///< their median
  PixelLength min_size;
  PixelLength max_size;
  double contrast = 0;  ///< their median
  double worth = 0;     ///< sum of quality times contrast, of which no one counts more than another

  const SeenMark& best() const { return marks.front(); }
};

/// Marks of like kind and size (within 8 %), the most useful group first: tags, then the group with
/// the most worth.
///
/// See    tests/vision/suggest/groups_test.cc
std::vector<MarkGroup> group_marks(std::vector<SeenMark> marks);

/// "bright disc of 61.2 px".
std::string describe(const SeenMark& mark);

}  // namespace panelcal
