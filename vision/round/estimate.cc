// SPDX-License-Identifier: Apache-2.0
#include "vision/round/estimate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "vision/fit/regression.h"
#include "vision/round/fit.h"
#include "vision/round/model/window.h"
#include "vision/round/profile/rim_profile.h"
#include "vision/round/profile/rim_waves.h"
#include "vision/round/profile/sector_turns.h"
#include "vision/round/residuals.h"
#include "vision/round/shape.h"
#include "vision/round/strangers.h"
#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr double kRough_px = 0.1;  // step at which a rough fit stops
/// The band's width to either side, in sigmas of the edge: beyond, the share is 0 or 1 to 3e-6.
constexpr double kBandSigmas = 4.5;
/// Around the target up to this part of its radius counts for the score, about as many pixels as
/// on it.
constexpr double kCircleScoreReach = 0.35;
/// A light that does not multiply, such as a reflection: chance would hardly make one.
constexpr double kOwnSlopeChiSquare = 12;
/// An oval rim is fitted if chance would not make one so oval, and if it matters.
constexpr double kOvalChiSquare = 30;
constexpr double kOvalPx = 0.02;
/// Waves of up to this number of periods tell of a plain rim's shape; of more noise, it is measured
/// by sectors.
constexpr int kMostPlainWaves = 10;
/// On flat pictures rims are round until shown otherwise.
constexpr double kPlainRoughChance = 0.04;
constexpr double kPlainOwn = 0.5;
/// A rim that is farther from round, as a sigma and of its radius, has something else beside it.
constexpr double kMaxOwnShape = 0.05;
/// Of the diameters: up to such a tolerance, an arc that lies off the rest is displaced
/// (over-etched, a mask's crescent) rather than a rim out of round. Beyond, this part of it may be
/// the rim's own.
constexpr double kRoundTolerance = 0.15;
constexpr double kOwnOfTolerance = 1.0 / 3;
/// A rim of less of the contrast asked for is not measured by sectors.
constexpr double kHalfContrast = 0.5;
/// A rim of the size is the edge within the tolerance or this of the circle, as a sigma.
constexpr double kBesideRim_px = 1;

/// Of the radius, as a sigma: as far as a rim may be out of round and is still measured whole.
double own_shape_of(const ExpectedRim& expected, const LocateOptions& options) {
  const double beyond = expected.allowed_oval(options.max_oval) - kRoundTolerance;
  return std::clamp(kOwnOfTolerance * beyond, 0.0, kMaxOwnShape);
}

/// The window's reach beyond the rim: more pixels settle the brightness gradient, which costs
/// accuracy while it is uncertain, and show texture for what it is; fewer meet less of what is not
/// the target.
double outside_px(double radius) {
  return std::clamp(10 + 0.6 * radius, 28.0, 40.0);
}

/// Further windows for pictures with other things in the first: a plain fit beside them is up
/// to 1.4 times as accurate as one by sectors.
constexpr double kNear_px = 12;
constexpr double kNearest_px = 6;
/// Width of flat pixels around the rim's band: a window without them does not show what is beside
/// it.
constexpr double kSurroundings_px = 0.5;

double band_px(const RimVector& p) {
  return kBandSigmas * p[kSigma] + 0.5;
}

/// Adds pixels of one model level, by their residuals.
void add_flat(double model, std::span<const float> residuals, Regression& sums) {
  const Eigen::Map<const Eigen::ArrayXf> r(residuals.data(),
                                           static_cast<Eigen::Index>(residuals.size()));
  const auto count = static_cast<double>(residuals.size());
  const auto sum = static_cast<double>(r.sum());
  const auto squares = static_cast<double>(r.square().sum());
  sums.n += count;
  sums.m += count * model;
  sums.v += count * model + sum;
  sums.mm += count * model * model;
  sums.mv += model * (count * model + sum);
  sums.vv += model * (count * model + 2 * sum) + squares;
}

/// Correlation of model and picture over the target and its near surroundings, above the
/// background.
double correlation_of(const RimWindow& window,
                      const RimVector& p,
                      const RimResiduals& residuals,
                      double white_noise) {
  Regression sums;
  const double limit = (1 + kCircleScoreReach) * p[kRadius] / window.unit_px();
  for (const RimSpan& span : window.spans()) {
    if (span.is_band) continue;
    int x0 = span.x0;
    int x1 = span.x1;
    double model = 0;
    if (span.zone == RimZone::Outside) {
      const Eigen::Vector2d at = window.plane_at(0, span.y);
      const double half2 = limit * limit - at.y() * at.y();
      if (half2 < 0) continue;
      const double half = std::sqrt(half2);
      x0 = std::max(x0, static_cast<int>(std::ceil((-half - at.x()) * window.unit_px())));
      x1 = std::min(x1, 1 + static_cast<int>(std::floor((half - at.x()) * window.unit_px())));
      if (x0 >= x1) continue;
    } else {
      model = span.zone == RimZone::Target ? p[kContrast] : p[kHole];
    }
    const float* const left = residuals.values.data() + window.index(0, span.y);
    add_flat(model, {left + x0, static_cast<std::size_t>(x1 - x0)}, sums);
  }
  const RimBand& band = window.band();
  for (std::size_t i = 0; i < band.size(); ++i) {
    const double background = p[kLevel] * (1 + p[kLightX] * static_cast<double>(band.plane_x[i]) +
                                           p[kLightY] * static_cast<double>(band.plane_y[i]));
    sums.add(static_cast<double>(residuals.band.level[i]) - background,
             static_cast<double>(band.value[i]) - background);
  }
  return sums.correlation(white_noise * white_noise);
}

/// Chi square of what the target's own slope has beyond the light's, from the flat part's
/// residuals.
double own_slope_of(const RimWindow& window, const RimVector& p, double sigma) {
  const FlatMoments& m = window.flat()[static_cast<std::size_t>(RimZone::Target)];
  if (m.n < 50) return 0;
  Eigen::Vector3d level = zone_level(p, RimZone::Target);
  level[0] -= static_cast<double>(window.reference());
  const Eigen::Vector3d left = m.bv - m.bb * level;
  const Eigen::Vector3d slope = m.bb.ldlt().solve(left);
  return slope.tail<2>().dot(m.bb.bottomRightCorner<2, 2>() * slope.tail<2>()) / (sigma * sigma);
}

/// Significance of the rim's ovalness: chi square of two degrees of freedom, and its size, px.
struct Ovalness {
  double chi_square = 0;
  double size_px = 0;
};

Ovalness ovalness_of(const RimWindow& window, const RimVector& p, double sigma) {
  Ovalness result;
  double slope[2] = {0, 0};
  double curvature[2] = {0, 0};
  RimFreedom freedom;
  freedom.is_ring = window.is_ring();
  freedom.is_oval = true;
  const RimBand& band = window.band();
  RimChunk chunk;
  for (std::size_t first = 0; first < band.size(); first += RimChunk::kSize) {
    chunk.evaluate(band, first, p, freedom, RimChunk::Want::Gradient);
    for (std::size_t k = 0; k < chunk.n; ++k) {
      if (band.clipped[first + k] != 0) continue;
      const double r = static_cast<double>(band.value[first + k] - chunk.level[k]);
      for (std::size_t i = 0; i < 2; ++i) {
        const auto g = static_cast<double>(chunk.gradient[kOval + i][k]);
        slope[i] += r * g;
        curvature[i] += g * g;
      }
    }
  }
  for (int i = 0; i < 2; ++i) {
    if (!(curvature[i] > 0)) continue;
    result.chi_square += slope[i] * slope[i] / (curvature[i] * sigma * sigma);
    result.size_px = std::max(result.size_px, std::abs(slope[i] / curvature[i]) * p[kRadius]);
  }
  return result;
}

double clipped_share(const RimWindow& window, const RimVector& p) {
  if (!window.band().has_clipped) return 0;
  double n = 0;
  double n_clipped = 0;
  const RimBand& band = window.band();
  for (std::size_t i = 0; i < band.size(); ++i) {
    const Eigen::Vector2d at(static_cast<double>(band.at_x[i]), static_cast<double>(band.at_y[i]));
    if (std::abs((at - p.head<2>()).norm() - p[kRadius]) > 3 * p[kSigma]) continue;
    ++n;
    n_clipped += band.clipped[i] != 0;
  }
  return n > 0 ? n_clipped / n : 0;
}

/// One estimate on its way through the fits.
class RimEstimator {
 public:
  RimEstimator(const Image& image,
               const FitFrame& frame,
               const ExpectedRim& expected,
               const RimStart& start,
               const LocateOptions& options,
               double reach_px)
      : window_(image, frame, start.parameters, reach_px, expected.shape == Shape::Ring),
        expected_(expected),
        start_(start.parameters),
        far_(std::max(RimSearch{}.far, expected.near_size())),
        min_visible_(options.min_visible),
        own_shape_(own_shape_of(expected, options)),
        is_of_its_size_(start.is_of_its_size),
        least_contrast_(kHalfContrast * options.min_contrast * image.full_scale()) {
    options_.freedom.is_ring = window_.is_ring();
    solution_.parameters = start_;
  }

  /// Lets plain() go on from where a fit in another window ended, if that one found the rim.
  void start_near(const RimEstimator& other) {
    is_near_ = other.solution_.converged && !is_astray(other.solution_.parameters);
    if (is_near_) solution_.parameters = other.solution_.parameters;
  }

  /// Maximum likelihood with everything flat; empty if something in the window is not.
  std::optional<RimEstimate> plain() {
    if (window_.empty()) return RimEstimate{};
    if (!(is_near_ || fit_roughly()) || !fit_all()) return std::nullopt;
    look();
    fit_own_slope();
    if (!noise_.is_textured) fit_oval();
    if (noise_.is_textured || is_beside_strangers()) return std::nullopt;
    RimEstimate estimate;
    estimate.correlation = correlation_of(window_, solution_.parameters, residuals_, noise_.white);
    fit_weighted();
    if (!solution_.converged || is_astray(solution_.parameters)) return std::nullopt;
    estimate.converged = true;
    estimate.visible = visible_share(window_, solution_.parameters);
    estimate.arc = estimate.visible;
    if (!add_covariance(estimate)) return std::nullopt;
    return finished(estimate);
  }

  /// True if plain() failed with something beside the rim, which may look like texture too, and a
  /// window of that reach shows some of the rim's surroundings.
  bool may_be_plain_within(double reach_px) const {
    const bool has_looked = !residuals_.values.empty();
    return has_looked && reach_px >= band_px(solution_.parameters) + kSurroundings_px &&
           is_beside_strangers();
  }

  /// With whatever there is beside the rim.
  RimEstimate by_sectors() {
    RimEstimate estimate;
    RimSearch search;
    search.start = start_;
    keep_hole(search.start);
    search.sign = expected_.sign();
    search.least_contrast = least_contrast_;
    search.least_used = min_visible_;
    search.far = far_;
    search.own_shape = own_shape_;
    if (is_of_its_size_) {
      search.ring_radius = expected_.radius;
      search.ring_px = std::max(kBesideRim_px, expected_.size_tolerance * expected_.radius);
    }
    search.outer_px = std::clamp(8 + 0.6 * start_[kRadius], 10.0, 30.0);
    search.inner_px = std::clamp(0.6 * start_[kRadius], 3.0, 22.0);
    const double metal_px = start_[kRadius] - start_[kInnerRadius];
    if (window_.is_ring()) search.inner_px = std::min(search.inner_px, 0.8 * metal_px);
    const auto rim = measure_rim(window_, search);
    if (!rim) return finished(estimate);
    solution_.parameters = rim->parameters;
    estimate.converged = rim->is_settled && !is_astray(solution_.parameters);
    estimate.center_cov = rim->center_cov;
    estimate.correlation = rim->correlation;
    estimate.visible = rim->used;
    estimate.arc = rim->arc;
    estimate.excluded = 1 - rim->used;
    estimate.roughness = rim->roughness;
    estimate.oval_sigma = rim->oval_sigma;
    estimate.n_lobes = rim->n_lobes;
    estimate.lobes = rim->lobes;
    noise_.rim_sigma = rim->noise;
    if (estimate.converged && window_.is_ring()) {
      estimate.converged = measure_hole(metal_px);
    }
    return finished(estimate);
  }

 private:
  /// True if a fit left the rim it was started at: there is none.
  bool is_astray(const RimVector& p) const {
    const double limit = std::max(1.0, far_ * start_[kRadius]);
    return !p.allFinite() || (p.head<2>() - start_.head<2>()).norm() > limit ||
           std::abs(p[kRadius] - start_[kRadius]) > limit;
  }

  bool is_beside_strangers() const {
    return has_strangers(window_, residuals_, noise_, solution_.parameters);
  }

  bool fit_roughly() {
    const int stride = static_cast<int>(std::clamp(0.1 * start_[kRadius], 2.0, 6.0));
    window_.collect(solution_.parameters, kBandSigmas * 2 + 2, stride);
    options_.tolerance_px = kRough_px;
    solution_ = fit_rim(window_, solution_.parameters, options_);
    return !is_astray(solution_.parameters);
  }

  bool fit_all() {
    window_.collect(solution_.parameters, band_px(solution_.parameters), 1);
    if (is_weighted_) set_weights(window_, solution_.parameters, options_.noise);
    options_.tolerance_px = RimFitOptions{}.tolerance_px;
    solution_ = fit_rim(window_, solution_.parameters, options_);
    return solution_.converged && !is_astray(solution_.parameters);
  }

  void look() {
    residuals_ = residuals_of(window_, solution_.parameters);
    noise_ = estimate_noise(window_, residuals_, solution_.parameters[kContrast]);
  }

  /// The band's noise differs from unit weights only where the zones differ.
  void fit_weighted() {
    const double ratio = noise_.total[RimZone::Target] / noise_.total[RimZone::Outside];
    const bool is_even = ratio > 0.8 && ratio < 1.25;
    options_.noise = noise_.total;
    is_weighted_ = true;
    if (is_even && clipped_share(window_, solution_.parameters) == 0) {
      // The solution is the same; only the information has another unit.
      const double sigma = 0.5 * (noise_.total[RimZone::Target] + noise_.total[RimZone::Outside]);
      solution_.information /= sigma * sigma;
      return;
    }
    fit_all();
    look();
  }

  void fit_own_slope() {
    const double chi_square =
        own_slope_of(window_, solution_.parameters, noise_.total[RimZone::Target]);
    if (chi_square < kOwnSlopeChiSquare) return;
    options_.freedom.has_own_slope = true;
    fit_all();
    look();
  }

  void fit_oval() {
    const Ovalness oval =
        ovalness_of(window_, solution_.parameters, std::max(0.3, noise_.rim_sigma));
    if (oval.chi_square < kOvalChiSquare || oval.size_px < kOvalPx) return;
    options_.freedom.is_oval = true;
    fit_all();
    look();
  }

  /// The inverse of the information, more if the residuals are, and what the rim's own shape adds;
  /// false if that is so much that the rim has to be looked at sector by sector.
  bool add_covariance(RimEstimate& estimate) {
    const RimVector& p = solution_.parameters;
    const std::vector<RimDeviation> deviations = rim_deviations(window_, p, noise_.total);
    Eigen::VectorXd px(static_cast<Eigen::Index>(deviations.size()));
    double variance = 0;
    for (std::size_t i = 0; i < deviations.size(); ++i) {
      px[static_cast<Eigen::Index>(i)] = deviations[i].px;
      variance += deviations[i].variance / static_cast<double>(deviations.size());
    }
    std::vector<double> powers = wave_powers(px, {}, 2, kMostPlainWaves);
    RimWaves waves = extrapolate_waves(powers, variance, kPlainRoughChance);
    if (waves.own > kPlainOwn * variance) return false;
    if (options_.freedom.is_oval) {
      // A round target's oval is a tilt, or a shift that looks like one.
      const double oval_px = std::hypot(p[kOval], p[kOvalDiagonal]) * p[kRadius];
      powers.front() = 0.25 * static_cast<double>(px.size()) * oval_px * oval_px;
      waves = extrapolate_waves(powers, variance, kPlainRoughChance);
    }
    const Eigen::Index n = solution_.information.rows();
    const Eigen::MatrixXd columns =
        solution_.information.ldlt().solve(Eigen::MatrixXd::Identity(n, 2));
    estimate.center_cov = columns.topRows<2>() * (waves.first / variance);
    // Three standard deviations of a chi square over its degrees of freedom.
    const double chance = 1 + 3 * std::sqrt(2.0 / std::max(1, noise_.n_band));
    if (noise_.rim_ratio > chance) estimate.center_cov *= noise_.rim_ratio;
    return true;
  }

  /// The plain fit may know where a ring has its hole; the start has it in the middle.
  void keep_hole(RimVector& p) const {
    const RimVector& seen = solution_.parameters;
    if (!window_.is_ring() || !seen.allFinite() || is_astray(seen)) return;
    const double reach = std::hypot(seen[kHoleX], seen[kHoleY]) + seen[kInnerRadius];
    if (reach < seen[kRadius]) p.segment<2>(kHoleX) = seen.segment<2>(kHoleX);
  }

  /// A ring's inner rim, measured for itself.
  bool measure_hole(double metal_px) {
    RimVector& p = solution_.parameters;
    RimSearch search;
    search.start = p;
    search.start.head<2>() += p.segment<2>(kHoleX);
    search.start[kRadius] = start_[kInnerRadius];
    search.start[kInnerRadius] = 0.5;
    search.sign = -expected_.sign();
    search.least_contrast = least_contrast_;
    search.least_used = min_visible_;
    search.outer_px = std::min(20.0, 0.8 * metal_px);
    search.inner_px = std::clamp(0.6 * start_[kInnerRadius], 3.0, 22.0);
    const auto hole = measure_rim(window_, search);
    if (!hole || !hole->is_settled) return false;
    p.segment<2>(kHoleX) = hole->parameters.head<2>() - p.head<2>();
    p[kInnerRadius] = hole->parameters[kRadius];
    p[kHole] = p[kContrast] + hole->parameters[kContrast];
    return true;
  }

  RimEstimate finished(RimEstimate estimate) {
    estimate.parameters = solution_.parameters;
    if (!solution_.parameters.allFinite()) return estimate;
    estimate.clipped = clipped_share(window_, solution_.parameters);
    estimate.rim_noise = noise_.rim_sigma;
    return estimate;
  }

  RimWindow window_;
  const ExpectedRim& expected_;
  RimVector start_;
  double far_;  ///< of the start's radius
  double min_visible_;
  double own_shape_;  ///< of the radius
  bool is_of_its_size_;
  double least_contrast_;
  RimFitOptions options_;
  RimSolution solution_;
  RimResiduals residuals_;
  RimNoiseEstimate noise_;
  bool is_weighted_ = false;
  bool is_near_ = false;  ///< the start is another window's solution
};

}  // namespace

RimEstimate estimate_rim(const Image& image,
                         const FitFrame& fit_frame,
                         const ExpectedRim& expected,
                         const RimStart& start,
                         const LocateOptions& options) {
  const auto in_window = [&](double reach_px) {
    return RimEstimator(image, fit_frame, expected, start, options, reach_px);
  };
  RimEstimator wide = in_window(outside_px(start.parameters[kRadius]));
  if (start.is_of_its_size) return wide.by_sectors();
  if (const auto plain = wide.plain()) return *plain;
  RimEstimator near = in_window(kNear_px);
  near.start_near(wide);
  if (const auto plain = near.plain()) return *plain;
  if (near.may_be_plain_within(kNearest_px)) {
    if (const auto plain = in_window(kNearest_px).plain()) return *plain;
  }
  return wide.by_sectors();
}

}  // namespace panelcal::internal
