// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "vision/texture/weave_parameters.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The look of plain-woven glass in resin, about -1 to 1.
///
/// Warp and weft make a checkerboard of bright and dark knots; yarns wander a little, are unequally
/// thick, and resin and filaments add an irregular mottle. All of it is a function of the place on
/// the panel and of the seed; tables of it for one box make it quick there.
class WeaveField {
 public:
  /// In     low, high: corners of the box where most places will be, mm on the panel
  WeaveField(const Weave& weave, const Eigen::Vector2d& low_mm, const Eigen::Vector2d& high_mm);

  /// At a place on the panel; to 1e-4 of what it is without tables.
  double level(const Eigen::Vector2d& at_mm) const;

 private:
  /// A random smooth curve, -1 to 1: a property of yarns along or across them.
  class Curve {
   public:
    Curve(std::uint64_t seed, std::int64_t lane, double per_period, double low, double high);
    /// In     x: periods
    double at(double x) const;

   private:
    std::uint64_t seed_;
    std::int64_t lane_;
    double per_period_;  ///< random values in a period
    std::int64_t first_ = 0;
    std::vector<double> values_;  ///< from first_ on, kStepsPerValue for each random value
  };

  /// The same in two dimensions.
  class Cloud {
   public:
    Cloud(std::uint64_t seed, const Eigen::Vector2d& low, const Eigen::Vector2d& high);
    double at(double x, double y) const;

   private:
    std::uint64_t seed_;
    std::int64_t first_x_;
    std::int64_t first_y_;
    std::uint64_t width_ = 0;
    std::uint64_t height_ = 0;
    std::vector<double> values_;
  };

  double sine_of_turns(double x) const;

  double per_mm_;
  Curve warp_wander_;
  Curve weft_wander_;
  Curve warp_thickness_;
  Curve weft_thickness_;
  Cloud mottle_;
  std::vector<double> sines_;  ///< of a turn
};

}  // namespace panelcal::internal
