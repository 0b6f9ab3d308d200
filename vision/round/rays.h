// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <optional>

#include "vision/fit/frame.h"
#include "vision/fit/target.h"
#include "vision/picture/image.h"
#include "vision/round/model/model.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The target, in the fit frame's units.
struct ExpectedRim {
  Shape shape = Shape::Disc;
  Polarity polarity = Polarity::Bright;
  double radius = 0;
  std::optional<double> inner_radius;
  double size_tolerance = 0;  ///< relative

  double sign() const { return polarity == Polarity::Bright ? 1 : -1; }
  /// A rim is worth a fit if its size is off by less than this part: near enough to be the target
  /// badly made, not another kind of mark.
  double near_size() const { return std::max(0.15, 1.5 * size_tolerance); }
  /// Of the diameters: a tolerance that was stated says how far any of them may be off.
  double allowed_oval(double max_oval) const {
    const bool is_stated = size_tolerance != Target{}.size_tolerance;
    return is_stated ? std::max(max_oval, size_tolerance) : max_oval;
  }
};

/// A rim seen along rays from its middle: good to a few tenths of a pixel.
struct RimStart {
  RimVector parameters = RimVector::Zero();
  double support = 0;           ///< part of the rays inside the picture that show the rim
  double inside = 1;            ///< part of the rays whose rim is inside of the picture
  bool is_of_its_size = false;  ///< another rim may be stronger: RimChoice::OfItsSize
  bool at_border = false;       ///< a part of the rim is outside of the picture
};

/// The rim among several rings about one centre.
enum class RimChoice {
  Strongest,
  /// Of the size that is expected, though another beside it is stronger: a pad in a mask's opening.
  OfItsSize,
};

/// Looks for the rim along rays from `center`; empty if there is none of at least `min_contrast`
/// grey levels, or only a part of one.
///
/// On each ray the best step from target to surroundings near the expected radius; a circle
/// through these, trimmed; three times, so that it is centred.
std::optional<RimStart> find_rim(const Image& image,
                                 const FitFrame& fit_frame,
                                 const Eigen::Vector2d& center,
                                 const ExpectedRim& expected,
                                 double min_contrast,
                                 RimChoice choice = RimChoice::Strongest);

}  // namespace panelcal::internal
