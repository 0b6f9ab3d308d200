// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "vision/fit/frame.h"
#include "vision/picture/image.h"
#include "vision/polygon/model.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The model of a slot.
struct ExpectedSlot {
  double width = 0;  ///< frame units
  double angle_rad = 0;
  double angle_tolerance_rad = 0;

  double reach() const { return std::clamp(14 + 0.4 * width, 16.0, 34.0); }
};

/// A slot, seen roughly; the state's origin is on it.
struct SlotSighting {
  FitFrame fit_frame;
  CellState state;
};

/// Place of a pixel in the coordinates of a sighting: along, across.
inline Eigen::Vector2d place_on(const SlotSighting& sighting, const Eigen::Vector2d& at_px) {
  return sighting.state.to_pattern(sighting.fit_frame.from_image(at_px));
}

/// The stretch of a slot that is seen, pattern units about the sighting's origin.
struct SlotStretch {
  double from = 0;
  double to = 0;
  bool is_cut_from = false;  ///< does not end there
  bool is_cut_to = false;

  double length() const { return to - from; }
};

/// Follows a slot both ways from where it was seen, as far as it goes or the picture reaches.
///
/// In     wanted_px: what lies nearest to it is wanted most
SlotStretch seen_stretch(const Image& image,
                         const SlotSighting& sighting,
                         const ExpectedSlot& expected,
                         const Eigen::Vector2d& wanted_px);

}  // namespace panelcal::internal
