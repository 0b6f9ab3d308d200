// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "calib/spindle/coupon.h"
#include "calib/spindle/variance_components.h"
#include <Eigen/Core>

// Not installed: how looks at a coupon become observations of a random-effects model.
namespace panelcal::internal {

/// Half the difference of the approaches of drilling and looking: what backlash is multiplied by.
Eigen::Vector2d approach_difference(const CouponHole& hole, const CouponView& view);

/// True if every number is finite, every approach one, every covariance positive definite, and
/// every hole was looked at.
bool is_sound(std::span<const CouponHole> holes);

/// The backlash along one axis, from the looks.
struct BacklashDesign {
  bool is_determined = false;  ///< approach differences vary
  double constant = 0;         ///< if not: the approach difference of all
};
std::array<BacklashDesign, 2> backlash_design(std::span<const CouponHole> holes);

/// Regressors of a turn and a growth about the middle of some places, mm per unit.
struct TrendDesign {
  std::vector<std::vector<Eigen::Vector2d>> places_mm;  ///< by hole and look, about their middle
  double spread_mm = 0;                                 ///< rms; what one unit is
};
/// Over the coupon: where holes were drilled.
TrendDesign over_coupon(std::span<const CouponHole> holes, std::span<const std::size_t> used);
/// Over the picture: where looks had a perfectly drilled hole. Not where it was seen: in that and
/// in its residual there is the same wander.
TrendDesign over_picture(std::span<const CouponHole> holes, std::span<const std::size_t> used);

/// Observations [offset x, y; backlashes that are determined; turn, growth if there is a trend] of
/// the used holes, which become groups 0, 1 ..
std::vector<GroupedObservation> observations_of(std::span<const CouponHole> holes,
                                                std::span<const std::size_t> used,
                                                const std::array<BacklashDesign, 2>& backlash,
                                                const TrendDesign* trend = nullptr);

/// All holes, by their distance from a Huber location of the means of their looks.
///
/// Source Huber 1964
std::vector<std::size_t> nearest_first(std::span<const CouponHole> holes,
                                       const std::array<BacklashDesign, 2>& backlash);

}  // namespace panelcal::internal
