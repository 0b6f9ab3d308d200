// SPDX-License-Identifier: Apache-2.0
#include "vision/round/estimate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "vision/round/fit.h"
#include "vision/round/residuals.h"
#include "vision/round/shape.h"
#include "vision/round/strangers.h"
#include "vision/round/texture.h"
#include "vision/round/window.h"
#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr double kCircleHuber = 2.0;
constexpr double kRough_px = 0.1;  // step at which a rough fit stops
/// The band's width to either side, in sigmas of the edge: beyond, the share is 0 or 1 to 3e-6.
constexpr double kBandSigmas = 4.5;
constexpr int kMaxPeels = 6;
/// Around the target up to this part of its radius counts for the score, about as many pixels as
/// on it.
constexpr double kCircleScoreReach = 0.35;
/// An oval rim is fitted if chance would not make one so oval, and if it matters.
constexpr double kOvalChiSquare = 30;
constexpr double kOvalPx = 0.02;
/// Rims with residuals near what noise makes are round; others are looked at closely.
constexpr double kSuspiciousRatio = 1.3;
constexpr double kRoughSignificance = 4;
/// Noise may hide lobes of this amplitude, of the radius, from that ratio.
constexpr double kLobes = 0.03;
constexpr double kLobesSignificance = 40;
/// A light that does not multiply, such as a reflection: chance would hardly make one.
constexpr double kOwnSlopeChiSquare = 12;
constexpr double kOwnSlopeOnTexture = 300;
/// Debris on the rim is never left out to its last trace. Measured with a tenth to a fifth of the
/// rim covered, errors are as if the variance were larger by this (tests/bench/README.md).
constexpr double kCircleDebrisDoubt = 2.4;
constexpr double kCleanRim = 0.03;
constexpr double kLeastNoise = 0.3;  // grey levels: rounding to whole ones
/// How many pixels err together on a texture whose model could not be fitted.
constexpr double kCorrelated = 4;

/// The window's reach beyond the rim: more pixels settle the brightness gradient, which costs
/// accuracy while it is uncertain, and show texture for what it is; fewer meet less of what is not
/// the target.
double outside_px(double radius) {
  return std::clamp(10 + 0.6 * radius, 28.0, 40.0);
}

double band_px(const RimVector& p) {
  return kBandSigmas * p[kSigma] + 0.5;
}

/// True if a fit left the rim it was started at: there is none.
bool is_circle_astray(const RimVector& p, const RimVector& start) {
  constexpr double kFar = 0.2;  // of the radius
  const double limit = std::max(1.0, kFar * start[kRadius]);
  return !p.allFinite() || (p.head<2>() - start.head<2>()).norm() > limit ||
         std::abs(p[kRadius] - start[kRadius]) > limit;
}

/// Sums for a correlation.
struct Correlation {
  double n = 0, m = 0, v = 0, mm = 0, mv = 0, vv = 0;

  void add(double model, double seen) {
    ++n;
    m += model;
    v += seen;
    mm += model * model;
    mv += model * seen;
    vv += seen * seen;
  }
  /// Pixels of one model level, by their residuals.
  void add_flat(double model, std::span<const float> residuals) {
    const Eigen::Map<const Eigen::ArrayXf> r(residuals.data(),
                                             static_cast<Eigen::Index>(residuals.size()));
    const auto count = static_cast<double>(residuals.size());
    const auto sum = static_cast<double>(r.sum());
    const auto squares = static_cast<double>(r.square().sum());
    n += count;
    m += count * model;
    v += count * model + sum;
    mm += count * model * model;
    mv += model * (count * model + sum);
    vv += model * (count * model + 2 * sum) + squares;
  }
  double value(double white_noise) const {
    const double var_m = n * mm - m * m;
    const double var_seen = n * vv - v * v;
    // A faint target may look just like the model but for the camera's noise.
    const double var_v = std::max(var_seen - n * n * white_noise * white_noise, 0.25 * var_seen);
    if (!(var_m > 0) || !(var_v > 0)) return 0;
    return std::clamp((n * mv - m * v) / std::sqrt(var_m * var_v), 0.0, 1.0);
  }
};

/// Correlation of model and picture over the target and its near surroundings, above the
/// background. What was excluded as debris on the target counts, neighbours do not.
double correlation_of(const RimWindow& window,
                      const RimVector& p,
                      const RimResiduals& residuals,
                      double white_noise) {
  Correlation sums;
  const double limit = (1 + kCircleScoreReach) * p[kRadius] / window.unit_px();
  const bool has_excluded = !window.excluded().empty();
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
    if (!has_excluded) {
      sums.add_flat(model, {left + x0, static_cast<std::size_t>(x1 - x0)});
      continue;
    }
    for (int x = x0; x < x1; ++x) {
      if (span.zone == RimZone::Outside && window.is_excluded(x, span.y)) continue;
      sums.add(model, model + static_cast<double>(left[x]));
    }
  }
  // What was left out of a band by the target's inner part counts as well.
  for (const RimSpan& span : window.spans()) {
    if (!has_excluded || !span.is_band || span.zone == RimZone::Outside) continue;
    for (int x = span.x0; x < span.x1; ++x) {
      if (!window.is_excluded(x, span.y)) continue;
      const Eigen::Vector2d at = window.plane_at(x, span.y);
      const double background = p[kLevel] * (1 + p[kLightX] * at.x() + p[kLightY] * at.y());
      const double model = span.zone == RimZone::Target ? p[kContrast] : p[kHole];
      sums.add(model, static_cast<double>(window.value(x, span.y)) - background);
    }
  }
  const RimBand& band = window.band();
  for (std::size_t i = 0; i < band.size(); ++i) {
    const double background = p[kLevel] * (1 + p[kLightX] * static_cast<double>(band.plane_x[i]) +
                                           p[kLightY] * static_cast<double>(band.plane_y[i]));
    sums.add(static_cast<double>(residuals.band.level[i]) - background,
             static_cast<double>(band.value[i]) - background);
  }
  return sums.value(white_noise);
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

/// How surely the rim is oval: chi square of two degrees of freedom, and how much, px.
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
  for (const RimPixel pixel : window.band()) {
    const double distance = std::abs((pixel.at.cast<double>() - p.head<2>()).norm() - p[kRadius]);
    if (distance > 3 * p[kSigma]) continue;
    ++n;
    n_clipped += pixel.clipped != 0;
  }
  return n > 0 ? n_clipped / n : 0;
}

/// One estimate on its way through the fits.
class RimEstimator {
 public:
  RimEstimator(const Image& image,
               const FitFrame& frame,
               const RimStart& start,
               bool is_ring,
               double least_correlation)
      : window_(image, frame, start.parameters, outside_px(start.parameters[kRadius]), is_ring),
        start_(start.parameters),
        least_correlation_(least_correlation) {
    options_.freedom.is_ring = is_ring;
    solution_.parameters = start_;
  }

  RimEstimate run() {
    RimEstimate estimate;
    if (window_.empty() || !fit_roughly() || !fit_all(0)) return finished(estimate);
    look();
    leave_out_marks();
    // What an oval rim or a reflection leaves would be taken for strangers; on texture both would
    // follow the texture.
    fit_own_slope();
    if (!noise_.is_textured) fit_oval();
    peel();
    if (is_circle_astray(solution_.parameters, start_)) return finished(estimate);
    estimate.correlation = correlation_of(window_, solution_.parameters, residuals_, noise_.white);
    if (estimate.correlation < least_correlation_) return finished(estimate);
    if (!noise_.is_textured) fit_own_slope();
    fit_weighted();
    if (!noise_.is_textured && is_peeled_) fit_oval();
    estimate.converged = solution_.converged && !is_circle_astray(solution_.parameters, start_);
    if (!estimate.converged) return finished(estimate);
    settle(estimate);
    if (excluded_of_rim() > kCleanRim) estimate.center_cov *= kCircleDebrisDoubt;
    look_at_shape(estimate);
    return finished(estimate);
  }

 private:
  bool fit_roughly() {
    const int stride = static_cast<int>(std::clamp(0.1 * start_[kRadius], 2.0, 6.0));
    window_.collect(solution_.parameters, kBandSigmas * 2 + 2, stride);
    options_.tolerance_px = kRough_px;
    options_.huber = 0;
    solution_ = fit_rim(window_, solution_.parameters, options_);
    return !is_circle_astray(solution_.parameters, start_);
  }

  bool fit_all(double huber) {
    window_.collect(solution_.parameters, band_px(solution_.parameters), 1);
    weigh();
    options_.tolerance_px = RimFitOptions{}.tolerance_px;
    options_.huber = huber;
    solution_ = fit_rim(window_, solution_.parameters, options_);
    return solution_.converged && !is_circle_astray(solution_.parameters, start_);
  }

  /// Fits and looks at what came of it, converged or not: what the next step is told of must be of
  /// the band that the window holds.
  bool refit(double huber) {
    const bool is_fitted = fit_all(huber);
    look();
    return is_fitted;
  }

  void weigh() {
    if (is_weighted_) set_weights(window_, solution_.parameters, options_.noise);
  }

  void look() {
    residuals_ = residuals_of(window_, solution_.parameters);
    noise_ = estimate_noise(window_, residuals_);
    has_strangers_.reset();
  }

  /// Excludes what does not belong, the worst first, until nothing is left that does not.
  void peel() {
    for (int i = 0; i < kMaxPeels; ++i) {
      if (i == 0 && (!has_strangers() || !fit_through_strangers())) return;
      if (!exclude_strangers(window_, residuals_, noise_, solution_.parameters)) return;
      use_noise();
      if (!refit(kCircleHuber)) return;
      is_peeled_ = true;
    }
  }

  /// Whether the residuals last looked at hold what does not belong.
  bool has_strangers() {
    if (!has_strangers_) {
      has_strangers_ = internal::has_strangers(window_, residuals_, noise_, solution_.parameters);
    }
    return *has_strangers_;
  }

  /// Other marks beside the target pull its levels and light along, so that they are left out by
  /// the levels that medians gave.
  void leave_out_marks() {
    if (!has_strangers() || !exclude_marks()) return;
    is_peeled_ = true;
    refit(0);
  }

  /// The plain fit leans towards debris on the rim; the residuals of one that gives little weight
  /// to what lies off tell better.
  bool fit_through_strangers() {
    std::vector<float> magnitudes;
    for (std::size_t i = 0; i < residuals_.kinds.size(); ++i) {
      if (residuals_.kinds[i] >= RimResiduals::kBand) {
        magnitudes.push_back(std::abs(residuals_.values[i]));
      }
    }
    if (magnitudes.empty()) return false;
    const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
    std::nth_element(magnitudes.begin(), middle, magnitudes.end());
    const double sigma = std::max(0.3, 1.4826 * static_cast<double>(*middle));
    options_.noise.sigma.fill(sigma);
    is_weighted_ = true;
    is_peeled_ = true;
    return refit(kCircleHuber);
  }

  bool exclude_marks() {
    RimVector flat = solution_.parameters;
    for (const int i : {kLevel, kContrast}) flat[i] = start_[i];
    for (const int i : {kLightX, kLightY, kContrastX, kContrastY}) flat[i] = 0;
    RimResiduals residuals = residuals_of(window_, flat);
    for (std::uint8_t& kind : residuals.kinds) {
      const bool is_ground = kind == RimResiduals::kZone;
      if (!is_ground) kind = RimResiduals::kNowhere;
    }
    return exclude_strangers(window_, residuals, noise_, flat);
  }

  void use_noise() {
    options_.noise = noise_.total;
    // Texture is taken care of later; here it must not make its zone count for nothing.
    if (noise_.is_textured) options_.noise.sigma[0] = std::max(noise_.white, noise_.total.sigma[1]);
    is_weighted_ = true;
  }

  /// The band's noise differs from unit weights only where the zones differ.
  void fit_weighted() {
    const double ratio = noise_.total[RimZone::Target] / noise_.total[RimZone::Outside];
    const bool is_even = ratio > 0.8 && ratio < 1.25;
    use_noise();
    if (is_even && !is_peeled_ && clipped_share(window_, solution_.parameters) == 0) {
      // The solution is the same; only the information has another unit.
      const double sigma = pooled_sigma();
      solution_.information /= sigma * sigma;
      return;
    }
    refit(is_peeled_ ? 3 * kCircleHuber : 0);
  }

  double pooled_sigma() const {
    return 0.5 * (noise_.total[RimZone::Target] + noise_.total[RimZone::Outside]);
  }

  void fit_own_slope() {
    const double chi_square =
        own_slope_of(window_, solution_.parameters, noise_.total[RimZone::Target]);
    // A light that is misjudged outside looks like texture; texture alone misjudges it less.
    const double limit = noise_.is_textured ? kOwnSlopeOnTexture : kOwnSlopeChiSquare;
    if (options_.freedom.has_own_slope || chi_square < limit) return;
    options_.freedom.has_own_slope = true;
    refit(options_.huber);
  }

  void fit_oval() {
    const Ovalness oval =
        ovalness_of(window_, solution_.parameters, std::max(0.3, noise_.rim_sigma));
    if (options_.freedom.is_oval || oval.chi_square < kOvalChiSquare || oval.size_px < kOvalPx) {
      return;
    }
    RimFitOptions round = options_;
    const RimSolution before = solution_;
    options_.freedom.is_oval = true;
    if (refit(options_.huber)) return;
    options_ = round;
    solution_ = before;
    look();
  }

  void settle(RimEstimate& estimate) {
    const Eigen::Index n = solution_.information.rows();
    const Eigen::MatrixXd columns =
        solution_.information.ldlt().solve(Eigen::MatrixXd::Identity(n, 2));
    estimate.center_cov = columns.topRows<2>();
    // Three standard deviations of a chi square over its degrees of freedom.
    const double chance = 1 + 3 * std::sqrt(2.0 / std::max(1, noise_.n_band));
    if (noise_.rim_ratio > chance) estimate.center_cov *= noise_.rim_ratio;
    if (noise_.is_textured) settle_on_texture(estimate);
  }

  void settle_on_texture(RimEstimate& estimate) {
    auto textured = fit_on_texture(window_, solution_, residuals_, noise_);
    if (!textured) {
      // Pixels that err together by some texture say less than as many that do not.
      const double ratio = noise_.total[RimZone::Outside] / noise_.white;
      estimate.center_cov *= kCorrelated * std::max(1.0, ratio * ratio);
      return;
    }
    const double sigma = noise_.total[RimZone::Target];
    if (own_slope_of(window_, textured->parameters, sigma) > kOwnSlopeChiSquare) {
      solution_.freedom.has_own_slope = true;
      const auto free = fit_on_texture(window_, solution_, residuals_, noise_);
      if (free) textured = free;
    }
    solution_.parameters = textured->parameters;
    estimate.center_cov = textured->center_cov;
    estimate.converged = !is_circle_astray(solution_.parameters, start_);
    window_.collect(solution_.parameters, band_px(solution_.parameters), 1);
  }

  /// The part of the band that is left out.
  double excluded_of_rim() const {
    double n = 0;
    double n_excluded = 0;
    for (const RimSpan& span : window_.spans()) {
      if (!span.is_band) continue;
      n += span.x1 - span.x0;
      for (int x = span.x0; x < span.x1; ++x) n_excluded += window_.is_excluded(x, span.y);
    }
    return n > 0 ? n_excluded / n : 0;
  }

  /// Whether lobes would raise the rim's residuals by too little to be noticed.
  bool may_hide_lobes() const {
    const RimVector& p = solution_.parameters;
    const double shift_px = kLobes * p[kRadius] / std::numbers::sqrt2;
    const double slopes =
        p[kContrast] * p[kContrast] / (2 * std::sqrt(std::numbers::pi) * p[kSigma]);
    const double excess = shift_px * shift_px * slopes / (2 * band_px(p));
    return excess < 2 * (kSuspiciousRatio - 1) * pooled_sigma() * pooled_sigma();
  }

  void look_at_shape(RimEstimate& estimate) {
    if (!is_peeled_ && noise_.rim_ratio < kSuspiciousRatio && !may_hide_lobes()) return;
    const RimVector& p = solution_.parameters;
    estimate.covered = covered_share(window_, p);
    std::vector<std::uint8_t> excluded;
    std::swap(excluded, window_.excluded());
    window_.collect(p, band_px(p), 1);
    const auto deviations = rim_deviations(window_, p, noise_.total);
    const RimRoughness rough = rim_roughness(deviations);
    if (rough.significance > kRoughSignificance) estimate.roughness = rough.rms_px / p[kRadius];
    const RimLobes lobes = rim_lobes(deviations);
    if (lobes.significance > kLobesSignificance) {
      estimate.n_lobes = lobes.n;
      estimate.lobes = lobes.amplitude_px / p[kRadius];
    }
    std::swap(excluded, window_.excluded());
    window_.collect(p, band_px(p), 1);
  }

  RimEstimate finished(RimEstimate estimate) {
    estimate.parameters = solution_.parameters;
    if (!solution_.parameters.allFinite()) return estimate;
    estimate.visible = visible_share(window_, solution_.parameters);
    estimate.excluded = excluded_share(window_);
    estimate.clipped = clipped_share(window_, solution_.parameters);
    estimate.rim_noise = noise_.rim_sigma;
    const double flat = std::max(noise_.total[RimZone::Outside], noise_.total[RimZone::Target]);
    estimate.rim_excess = noise_.rim_sigma / std::max(kLeastNoise, flat);
    return estimate;
  }

  RimWindow window_;
  RimVector start_;
  double least_correlation_;
  RimFitOptions options_;
  RimSolution solution_;
  RimResiduals residuals_;
  RimNoiseEstimate noise_;
  bool is_weighted_ = false;
  bool is_peeled_ = false;
  std::optional<bool> has_strangers_;
};

}  // namespace

RimEstimate estimate_rim(const Image& image,
                         const FitFrame& fit_frame,
                         const RimStart& start,
                         bool is_ring,
                         double least_correlation) {
  return RimEstimator(image, fit_frame, start, is_ring, least_correlation).run();
}

}  // namespace panelcal::internal
