// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "calib/base/calibration_plate.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "vision/fit/target.h"

namespace panelcal {

/// A tag on a calibration plate.
struct PlateTag {
  int id = 0;
  Position<frame::Plate> center;
  Angle turn;  ///< 0: its first row of cells is on the side of larger y
};

/// The AprilTags of a calibration plate, by which its dots are told apart. Nothing is measured with
/// them.
struct PlateTags {
  std::string family = "tag36h11";
  Length size;                           ///< side of the square that the corners make
  Polarity polarity = Polarity::Bright;  ///< Dark: black and white have changed places
  std::vector<PlateTag> tags;            ///< every id once

  /// The tag of that id; null if the plate has none.
  const PlateTag* find(int id) const;
};

/// A tag's corners in the order of tag_corners(): counter-clockwise from its bottom left.
std::array<Position<frame::Plate>, 4> corners_of(const PlateTags& tags, const PlateTag& tag);

/// Half the side of a tag with all that is printed for it: quiet zone, reversed border.
///
/// Precondition: a known family
Length half_side_of(const PlateTags& tags);

/// True if a tag of such a half side covers any of a dot: such a dot is not there.
bool covers_dot(const PlateTag& tag, Length half_side, const PlateDot& dot);

}  // namespace panelcal
