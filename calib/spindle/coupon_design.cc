// SPDX-License-Identifier: Apache-2.0
#include "calib/spindle/coupon_design.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/base/statistics/median.h"
#include <Eigen/Core>

namespace panelcal::internal {
namespace {

/// Beyond this number of sigmas a hole pulls no harder (docs: semantics, "Robust").
constexpr double kHuber = 2.5;
constexpr int kHuberIterations = 50;
/// Median of the length of a vector whose coordinates have a standard deviation of 1.
constexpr double kRayleighMedian = 1.1774100225154747;
/// Keeps a backlash that the means of holes leave open at zero; relative to a hole's weight.
constexpr double kCouponRidge = 1e-9;

bool is_approach(const Approach& approach) {
  return std::abs(approach.x) <= 1 && std::abs(approach.y) <= 1;
}

bool is_sound_view(const CouponView& view) {
  const Eigen::Matrix2d& c = view.seen.cov;
  const bool is_finite = view.spindle.in_mm().allFinite() &&
                         view.seen.position.in_mm().allFinite() && c.allFinite() &&
                         view.by_camera.allFinite();
  if (!is_finite || !is_approach(view.approach)) return false;
  const double asymmetry = std::abs(c(0, 1) - c(1, 0));
  return c(0, 0) > 0 && c(1, 1) > 0 && asymmetry <= 1e-9 * std::sqrt(c(0, 0) * c(1, 1)) &&
         c(0, 0) * c(1, 1) > c(0, 1) * c(1, 0);
}

/// Offset by one look.
Eigen::Vector2d value_mm(const CouponHole& hole, const CouponView& view) {
  return (hole.drilled - view.spindle).in_mm() - view.seen.position.in_mm();
}

TrendDesign about_their_middle(std::vector<std::vector<Eigen::Vector2d>> places_mm) {
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  double n = 0;
  for (const auto& hole : places_mm) {
    for (const Eigen::Vector2d& place : hole) sum_mm += place;
    n += static_cast<double>(hole.size());
  }
  double squares_mm2 = 0;
  for (auto& hole : places_mm) {
    for (Eigen::Vector2d& place : hole) {
      place -= sum_mm / n;
      squares_mm2 += place.squaredNorm();
    }
  }
  return {std::move(places_mm), std::sqrt(squares_mm2 / n)};
}

/// The means of the looks at one hole.
struct HoleMean {
  Eigen::Vector2d value_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d approach_difference = Eigen::Vector2d::Zero();
};

HoleMean hole_mean(const CouponHole& hole) {
  HoleMean mean;
  for (const CouponView& view : hole.views) {
    mean.value_mm += value_mm(hole, view);
    mean.approach_difference += approach_difference(hole, view);
  }
  const auto n = static_cast<double>(hole.views.size());
  return {mean.value_mm / n, mean.approach_difference / n};
}

/// Distances from the weighted location of one axis after another.
std::vector<double> distances_mm(std::span<const HoleMean> means,
                                 std::span<const double> weights,
                                 const std::array<BacklashDesign, 2>& backlash) {
  std::vector<Eigen::Vector2d> residuals(means.size(), Eigen::Vector2d::Zero());
  for (int axis = 0; axis < 2; ++axis) {
    const bool has_backlash = backlash[static_cast<std::size_t>(axis)].is_determined;
    const auto row_of = [&](const HoleMean& mean) {
      return Eigen::Vector2d(1, has_backlash ? mean.approach_difference[axis] : 0);
    };
    Eigen::Matrix2d normal = kCouponRidge * Eigen::Matrix2d::Identity();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    // About the first hole, so that the ridge pulls nothing towards machine zero.
    const double about_mm = means.front().value_mm[axis];
    for (std::size_t i = 0; i < means.size(); ++i) {
      const Eigen::Vector2d row = row_of(means[i]);
      normal += weights[i] * row * row.transpose();
      right += weights[i] * row * (means[i].value_mm[axis] - about_mm);
    }
    const Eigen::Vector2d location = solve_plane_symmetric(normal, right);
    for (std::size_t i = 0; i < means.size(); ++i) {
      residuals[i][axis] = means[i].value_mm[axis] - about_mm - row_of(means[i]).dot(location);
    }
  }
  std::vector<double> distances;
  for (const Eigen::Vector2d& residual : residuals) distances.push_back(residual.norm());
  return distances;
}

/// The coordinate-wise median: where the iteration starts, so that outliers do not say what is far.
std::vector<double> distances_from_median_mm(std::span<const HoleMean> means) {
  Eigen::Vector2d middle_mm;
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    for (const HoleMean& mean : means) values.push_back(mean.value_mm[axis]);
    middle_mm[axis] = median(std::move(values));
  }
  std::vector<double> distances;
  for (const HoleMean& mean : means) distances.push_back((mean.value_mm - middle_mm).norm());
  return distances;
}

}  // namespace

Eigen::Vector2d approach_difference(const CouponHole& hole, const CouponView& view) {
  return {0.5 * (hole.approach.x - view.approach.x), 0.5 * (hole.approach.y - view.approach.y)};
}

bool is_sound(std::span<const CouponHole> holes) {
  return std::ranges::all_of(holes, [](const CouponHole& hole) {
    return hole.drilled.in_mm().allFinite() && is_approach(hole.approach) && !hole.views.empty() &&
           std::ranges::all_of(hole.views,
                               [](const CouponView& view) { return is_sound_view(view); });
  });
}

std::array<BacklashDesign, 2> backlash_design(std::span<const CouponHole> holes) {
  std::array<BacklashDesign, 2> designs;
  for (int axis = 0; axis < 2; ++axis) {
    BacklashDesign& design = designs[static_cast<std::size_t>(axis)];
    design.constant = approach_difference(holes.front(), holes.front().views.front())[axis];
    for (const CouponHole& hole : holes) {
      for (const CouponView& view : hole.views) {
        design.is_determined |= approach_difference(hole, view)[axis] != design.constant;
      }
    }
    if (design.is_determined) design.constant = 0;
  }
  return designs;
}

TrendDesign over_coupon(std::span<const CouponHole> holes, std::span<const std::size_t> used) {
  std::vector<std::vector<Eigen::Vector2d>> places_mm;
  for (const std::size_t i : used) {
    places_mm.emplace_back(holes[i].views.size(), holes[i].drilled.in_mm());
  }
  return about_their_middle(std::move(places_mm));
}

TrendDesign over_picture(std::span<const CouponHole> holes, std::span<const std::size_t> used) {
  std::vector<std::vector<Eigen::Vector2d>> places_mm;
  for (const std::size_t i : used) {
    std::vector<Eigen::Vector2d> of_hole;
    for (const CouponView& view : holes[i].views) {
      of_hole.emplace_back((holes[i].drilled - view.spindle).in_mm());
    }
    places_mm.push_back(std::move(of_hole));
  }
  return about_their_middle(std::move(places_mm));
}

std::vector<GroupedObservation> observations_of(std::span<const CouponHole> holes,
                                                std::span<const std::size_t> used,
                                                const std::array<BacklashDesign, 2>& backlash,
                                                const TrendDesign* trend) {
  const int n_backlashes = int{backlash[0].is_determined} + int{backlash[1].is_determined};
  const int n_columns = 2 + n_backlashes + (trend != nullptr ? 2 : 0);
  std::vector<GroupedObservation> observations;
  for (std::size_t group = 0; group < used.size(); ++group) {
    const CouponHole& hole = holes[used[group]];
    for (std::size_t i_view = 0; i_view < hole.views.size(); ++i_view) {
      const CouponView& view = hole.views[i_view];
      GroupedObservation one;
      one.group = static_cast<int>(group);
      one.value_mm = value_mm(hole, view);
      one.cov_mm2 = 0.5 * (view.seen.cov + view.seen.cov.transpose());
      one.design = Eigen::MatrixXd::Zero(2, n_columns);
      one.design.leftCols<2>() = Eigen::Matrix2d::Identity();
      const Eigen::Vector2d difference = approach_difference(hole, view);
      int column = 2;
      for (int axis = 0; axis < 2; ++axis) {
        if (!backlash[static_cast<std::size_t>(axis)].is_determined) continue;
        one.design(axis, column++) = difference[axis];
      }
      if (trend != nullptr) {
        const Eigen::Vector2d unit = trend->places_mm[group][i_view] / trend->spread_mm;
        one.design.col(column) << -unit.y(), unit.x();
        one.design.col(column + 1) = unit;
      }
      observations.push_back(std::move(one));
    }
  }
  return observations;
}

std::vector<std::size_t> nearest_first(std::span<const CouponHole> holes,
                                       const std::array<BacklashDesign, 2>& backlash) {
  std::vector<HoleMean> means;
  for (const CouponHole& hole : holes) means.push_back(hole_mean(hole));
  std::vector<double> distances = distances_from_median_mm(means);
  std::vector<double> weights(means.size(), 1);
  for (int i = 0; i < kHuberIterations; ++i) {
    const double limit_mm = kHuber * median(distances) / kRayleighMedian;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      weights[k] = distances[k] > limit_mm ? limit_mm / distances[k] : 1;
    }
    // More than half of the holes at one place: all others weigh nothing.
    if (!(limit_mm > 0)) break;
    distances = distances_mm(means, weights, backlash);
  }
  std::vector<std::size_t> order(holes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return distances[i]; });
  return order;
}

}  // namespace panelcal::internal
