// SPDX-License-Identifier: Apache-2.0
#include "calib/spindle/fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "calib/base/statistics/chi_square.h"
#include "calib/base/statistics/distributions.h"
#include "calib/base/statistics/linear_algebra.h"
#include "calib/spindle/coupon_design.h"
#include "calib/spindle/f_exceedance.h"
#include "calib/spindle/variance_components.h"

namespace panelcal {
namespace {

using internal::BacklashDesign;
using internal::GroupDeviation;
using internal::GroupedObservation;
using internal::MixedFit;
using internal::TrendDesign;
using internal::VarianceModel;
using Holes = std::span<const CouponHole>;
using Indices = std::vector<std::size_t>;

/// With this number of looks more than holes, repeatability separates from wander.
constexpr std::size_t kLeastRepeats = 2;
/// Fewer holes say too little to call another one an outlier, or axes unequal.
constexpr std::size_t kLeastToJudge = 5;
/// Chance of axes that look unequal and are not, at which they are fitted apart. Rarer than other
/// findings: it costs half the degrees of freedom, and choosing by chance makes sigmas too small.
constexpr double kUnequalAxes = 0.001;
/// Narrower than that, holes were seen at one place of the picture.
constexpr double kLeastPictureSpread_mm = 0.05;
constexpr double kLeastCouponSpread_mm = 1e-3;
/// A drill that needs more holes than this has to be replaced.
constexpr int kMostHoles = 1'000'000;
constexpr int kMostViews = 1000;

bool is_in_order(const SpindleCameraFitOptions& options) {
  const auto is_chance = [](double p) { return p > 0 && p <= 0.5; };
  const auto is_sigma = [](const std::optional<Length>& length) {
    return !length || (std::isfinite(length->in_mm()) && *length >= Length());
  };
  return is_chance(options.outlier_false_alarm) && is_chance(options.significance) &&
         options.max_outliers.value_or(0) >= 0 && is_sigma(options.backlash) &&
         is_sigma(options.expected_wander) && is_sigma(options.expected_repeatability);
}

/// The fit without a trend, and what it needs.
struct Model {
  Holes holes;
  SpindleCameraFitOptions options;
  std::array<BacklashDesign, 2> backlash;
};

VarianceModel variances_of(Holes holes, const Indices& used) {
  std::size_t n_views = 0;
  for (const std::size_t i : used) n_views += holes[i].views.size();
  return {.has_within = n_views >= used.size() + kLeastRepeats};
}

std::optional<MixedFit> fit_used(const Model& model, const Indices& used) {
  return internal::fit_mixed(internal::observations_of(model.holes, used, model.backlash),
                             variances_of(model.holes, used));
}

/// Chance that a sound hole lies as far from the fit of others as this one.
double chance_of_hole(const Model& model, const MixedFit& others, std::size_t i_hole) {
  const Indices alone = {i_hole};
  const auto group = internal::observations_of(model.holes, alone, model.backlash);
  const GroupDeviation deviation = internal::deviation_of_other(others, group);
  const double t2 = internal::squared_distance(deviation.mean_mm, deviation.cov_mm2);
  return f_exceedance(t2 / 2, 2, others.degrees_of_freedom.head<2>().minCoeff());
}

/// Holes that are left out, with the probability of each suspect.
struct Suspects {
  std::size_t n_outliers = 0;  ///< at the far end of `order`
  Indices order;               ///< nearest first
  std::vector<std::optional<double>> chance;
  bool are_too_many = false;
};

Suspects examine(const Model& model) {
  const std::size_t n = model.holes.size();
  Suspects suspects;
  suspects.order = internal::nearest_first(model.holes, model.backlash);
  suspects.chance.resize(n);
  const auto most =
      static_cast<std::size_t>(model.options.max_outliers.value_or(static_cast<int>(n / 4)));
  for (std::size_t k = 1; k <= most + 1 && k + kLeastToJudge <= n; ++k) {
    const Indices nearer(suspects.order.begin(),
                         suspects.order.end() - static_cast<std::ptrdiff_t>(k));
    const auto fit = fit_used(model, nearer);
    if (!fit) break;
    const std::size_t suspect = suspects.order[n - k];
    const double chance = chance_of_hole(model, *fit, suspect);
    suspects.chance[suspect] = chance;
    const double limit = model.options.outlier_false_alarm / static_cast<double>(n - k + 1);
    if (chance < limit) suspects.n_outliers = k;
  }
  suspects.are_too_many = suspects.n_outliers > most;
  return suspects;
}

/// Lets x and y scatter differently if they clearly do.
MixedFit with_unequal_axes(const Model& model, const Indices& used, MixedFit pooled) {
  VarianceModel variances = pooled.model;
  variances.per_axis = true;
  auto apart =
      internal::fit_mixed(internal::observations_of(model.holes, used, model.backlash), variances);
  if (used.size() < kLeastToJudge || !apart || !apart->honest_cov(2)) return pooled;
  const double ratio = 2 * (apart->log_likelihood - pooled.log_likelihood);
  const double chance = chi_square_exceedance(ratio, variances.has_within ? 2 : 1);
  return chance < kUnequalAxes ? *std::move(apart) : pooled;
}

std::optional<ResidualTrend> trend_of(const Model& model,
                                      const Indices& used,
                                      const MixedFit& fit,
                                      const TrendDesign& design,
                                      double least_spread_mm) {
  if (!(design.spread_mm >= least_spread_mm)) return std::nullopt;
  const auto with_trend = internal::fit_mixed(
      internal::observations_of(model.holes, used, model.backlash, &design), fit.model);
  if (!with_trend) return std::nullopt;
  // The offset by a look turns the other way than the place that it sees.
  const Eigen::Vector2d slope = -with_trend->fixed.tail<2>() / design.spread_mm;
  const Eigen::Matrix2d cov =
      with_trend->cov.bottomRightCorner<2, 2>() / (design.spread_mm * design.spread_mm);
  const double n_free = with_trend->degrees_of_freedom.tail<2>().minCoeff();
  ResidualTrend trend;
  trend.rotation_rad = slope.x();
  trend.rotation_sigma_rad = std::sqrt(cov(0, 0));
  trend.scale_ppm = 1e6 * slope.y();
  trend.scale_sigma_ppm = 1e6 * std::sqrt(cov(1, 1));
  trend.chance = f_exceedance(internal::squared_distance(slope, cov) / 2, 2, n_free);
  trend.is_significant = trend.chance < model.options.significance;
  return trend;
}

/// In     rest_mm2: see ScatterEstimate::low
ScatterEstimate scatter_of(const internal::VarianceEstimate& variance,
                           const Eigen::Vector2d& rest_mm2) {
  constexpr double kTail = 0.025;
  ScatterEstimate scatter;
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double sigma_mm = std::sqrt(variance.value_mm2[axis]);
    const double error_mm2 = variance.error_mm2[axis];
    scatter.sigma[i] = mm(sigma_mm);
    scatter.error[i] = mm(sigma_mm > 0 ? error_mm2 / (2 * sigma_mm) : std::sqrt(error_mm2));
    const double mean_mm2 = variance.value_mm2[axis] + rest_mm2[axis];
    if (!(error_mm2 > 0) || !(mean_mm2 > 0)) continue;
    const double n_free = 2 * std::pow(mean_mm2 / error_mm2, 2);
    const auto bound = [&](double chance) {
      const double mm2 = mean_mm2 * n_free / chi_square_of_exceedance(chance, n_free);
      return mm(std::sqrt(std::max(0.0, mm2 - rest_mm2[axis])));
    };
    scatter.low[i] = bound(kTail);
    scatter.high[i] = bound(1 - kTail);
  }
  return scatter;
}

/// The scatter of holes' means that is not wander. The holes' middle is fitted to them, which
/// makes them scatter less by one in their number.
Eigen::Vector2d rest_of_means_mm2(const MixedFit& fit) {
  Eigen::Vector2d mean_mm2 = Eigen::Vector2d::Zero();
  for (const GroupDeviation& group : fit.groups) mean_mm2 += group.cov_mm2.diagonal();
  const auto n = static_cast<double>(fit.groups.size());
  return (mean_mm2 / (n - 1) - fit.between.value_mm2).cwiseMax(0);
}

/// The detector's part of the scatter of looks.
Eigen::Vector2d rest_of_looks_mm2(const Model& model, const Indices& used) {
  Eigen::Vector2d sum_mm2 = Eigen::Vector2d::Zero();
  double n = 0;
  for (const std::size_t i : used) {
    for (const CouponView& view : model.holes[i].views) {
      sum_mm2 += view.seen.cov.diagonal();
      n += 1;
    }
  }
  return sum_mm2 / n;
}

double inflation(double n_free) {
  if (!(n_free > 2)) return std::numeric_limits<double>::infinity();
  return std::isinf(n_free) ? 1 : n_free / (n_free - 2);
}

/// Number of further holes of the same kind that halve the standard deviation.
///
///   variance(n) ~ 1 / n * nu(n) / (nu(n) - 2),   nu(n) = nu (n - 1) / (n_used - 1)
int more_holes(const SpindleCameraFit& fit) {
  const double n_free = fit.degrees_of_freedom.minCoeff();
  const auto variance = [&](int n) { return inflation(n_free * (n - 1) / (fit.n_used - 1)) / n; };
  const double wanted = variance(fit.n_used) / 4;
  int low = fit.n_used;
  int high = 2 * low;
  while (variance(high) > wanted && high < kMostHoles) high *= 2;
  while (high - low > 1) {
    const int middle = low + (high - low) / 2;
    (variance(middle) > wanted ? low : high) = middle;
  }
  return high - fit.n_used;
}

/// Number of further looks at each hole that do the same; empty if wander alone is too much.
std::optional<int> more_views(const Model& model, const Indices& used, const MixedFit& fit) {
  if (!fit.model.has_within) return std::nullopt;
  double detector_mm2 = 0;
  double n_views = 0;
  for (const std::size_t i : used) {
    for (const CouponView& view : model.holes[i].views) detector_mm2 += view.seen.cov.trace();
    n_views += static_cast<double>(model.holes[i].views.size());
  }
  const double between_mm2 = fit.between.value_mm2.sum();
  const double within_mm2 = fit.within.value_mm2.sum() + detector_mm2 / n_views;
  const double views = n_views / static_cast<double>(used.size());
  const double wanted_mm2 = (between_mm2 + within_mm2 / views) / 4;
  if (between_mm2 >= wanted_mm2) return std::nullopt;
  const double needed = std::ceil(within_mm2 / (wanted_mm2 - between_mm2) - views);
  if (!(needed <= kMostViews)) return std::nullopt;
  return static_cast<int>(needed);
}

void add_backlash(const Model& model, const MixedFit& fit, SpindleCameraFit& result) {
  const auto covariance = fit.honest_cov(static_cast<int>(fit.fixed.size()));
  Eigen::Index column = 2;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    BacklashEstimate& estimate = result.backlash[axis];
    if (model.backlash[axis].is_determined) {
      const Eigen::Index k = column++;
      estimate.is_determined = covariance.has_value();
      estimate.value = mm(fit.fixed[k]);
      if (covariance) estimate.sigma = mm(std::sqrt((*covariance)(k, k)));
      continue;
    }
    if (model.backlash[axis].constant == 0) continue;
    const double shift_mm = model.backlash[axis].constant * model.options.backlash->in_mm();
    const auto i = static_cast<Eigen::Index>(axis);
    result.offset.cov_mm2(i, i) += shift_mm * shift_mm;
  }
}

void add_holes(const Model& model,
               const Suspects& suspects,
               const Indices& used,
               const MixedFit& fit,
               SpindleCameraFit& result) {
  result.holes.resize(model.holes.size());
  for (std::size_t i = 0; i < model.holes.size(); ++i) {
    CouponHoleResidual& hole = result.holes[i];
    hole.chance = suspects.chance[i];
    hole.is_outlier = true;
    const Indices alone = {i};
    const auto group = internal::observations_of(model.holes, alone, model.backlash);
    const GroupDeviation deviation = internal::deviation_of_other(fit, group);
    hole.residual = displacement_mm<frame::Machine>(-deviation.mean_mm);
    hole.cov_mm2 = deviation.cov_mm2;
  }
  for (std::size_t k = 0; k < used.size(); ++k) {
    CouponHoleResidual& hole = result.holes[used[k]];
    hole.is_outlier = false;
    hole.residual = displacement_mm<frame::Machine>(-fit.groups[k].mean_mm);
    hole.cov_mm2 = fit.groups[k].cov_mm2;
  }
}

void add_camera(const Model& model, const Indices& used, const MixedFit& fit, SpindleCameraFit& r) {
  Eigen::Index column = 0;
  for (const std::size_t i : used) {
    for (const CouponView& view : model.holes[i].views) {
      r.by_camera -= fit.gain.block<2, 2>(0, column) * view.by_camera;
      column += 2;
    }
  }
  r.n_views = static_cast<int>(column / 2);
}

void add_findings(const Model& model,
                  const Indices& used,
                  const MixedFit& fit,
                  SpindleCameraFit& r) {
  r.over_coupon =
      trend_of(model, used, fit, internal::over_coupon(model.holes, used), kLeastCouponSpread_mm);
  r.over_picture =
      trend_of(model, used, fit, internal::over_picture(model.holes, used), kLeastPictureSpread_mm);
  r.more_holes_to_halve = more_holes(r);
  r.more_views_to_halve = more_views(model, used, fit);
  const SpindleCameraFitOptions& options = model.options;
  if (!options.expected_wander || !options.expected_repeatability) return;
  const auto expected =
      internal::fit_fixed(internal::observations_of(model.holes, used, model.backlash),
                          std::pow(options.expected_wander->in_mm(), 2),
                          std::pow(options.expected_repeatability->in_mm(), 2));
  if (!expected) return;
  r.chance_as_expected = chi_square_exceedance(expected->chi_square, expected->n_free);
}

}  // namespace

SpindleCameraFitResult fit_spindle_camera(Holes holes, const SpindleCameraFitOptions& options) {
  const auto fails = [](SpindleCameraFailure failure) {
    return SpindleCameraFitResult{std::nullopt, failure};
  };
  if (!is_in_order(options)) return fails(SpindleCameraFailure::BadOptions);
  if (!internal::is_sound(holes)) return fails(SpindleCameraFailure::BadInput);
  if (holes.size() < kLeastHoles) return fails(SpindleCameraFailure::TooFewHoles);
  const Model model{holes, options, internal::backlash_design(holes)};
  for (const BacklashDesign& axis : model.backlash) {
    if (axis.constant != 0 && !options.backlash) {
      return fails(SpindleCameraFailure::BacklashUnknown);
    }
  }
  const Suspects suspects = examine(model);
  if (suspects.are_too_many) return fails(SpindleCameraFailure::TooManyOutliers);
  Indices used(suspects.order.begin(),
               suspects.order.end() - static_cast<std::ptrdiff_t>(suspects.n_outliers));
  std::ranges::sort(used);
  auto fitted = fit_used(model, used);
  if (!fitted || !fitted->honest_cov(2)) return fails(SpindleCameraFailure::TooFewHoles);
  const MixedFit fit = with_unequal_axes(model, used, *std::move(fitted));

  SpindleCameraFit result;
  result.offset.offset = displacement_mm<frame::Machine>(fit.fixed.head<2>().eval());
  result.offset.cov_mm2 = *fit.honest_cov(2);
  result.degrees_of_freedom = fit.degrees_of_freedom.head<2>();
  result.is_separated = fit.model.has_within;
  result.has_unequal_axes = fit.model.per_axis;
  result.wander = scatter_of(fit.between, rest_of_means_mm2(fit));
  result.repeatability = scatter_of(fit.within, rest_of_looks_mm2(model, used));
  result.n_used = static_cast<int>(used.size());
  result.chi_square = fit.chi_square;
  result.n_free = fit.n_free;
  add_backlash(model, fit, result);
  add_holes(model, suspects, used, fit, result);
  add_camera(model, used, fit, result);
  add_findings(model, used, fit, result);
  return {std::move(result), SpindleCameraFailure::TooFewHoles};
}

}  // namespace panelcal
