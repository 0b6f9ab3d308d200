// SPDX-License-Identifier: Apache-2.0
#include "vision/round/fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/fit/minimiser.h"

namespace panelcal::internal {
namespace {

constexpr int kMaxCircleIterations = 15;      // a rim takes 3 or 4; more means that there is none
constexpr double kCircleCostRounding = 1e-6;  // of the cost: residuals are floats
constexpr double kMinCircleSigma = 0.32;      // a pixel behind a perfect lens has 0.29
constexpr double kMaxSigmaOfRadius = 0.3;     // a blurrier rim is no rim

using CircleDynamic = SmallMatrix<kRimParameters>;
using CircleStep = SmallVector<kRimParameters>;

/// Term of one clipped pixel: -2 log of its probability, and derivatives by the level.
struct ClippedTerm {
  double cost = 0;
  double slope = 0;      ///< of half the cost
  double curvature = 0;  ///< of half the cost
};

/// In     excess: how many sigmas the scale's end is beyond the level
ClippedTerm clipped_term(double excess, double sigma) {
  constexpr double kFar = 6;
  if (excess < -kFar) return {};
  double log_beyond = 0;
  double hazard = 0;
  if (excess > kFar) {
    hazard = excess + 1 / excess;
    log_beyond = -0.5 * excess * excess - std::log(excess * std::sqrt(2 * std::numbers::pi));
  } else {
    const double beyond = 0.5 * std::erfc(excess / std::numbers::sqrt2);
    hazard = std::exp(-0.5 * excess * excess) / std::sqrt(2 * std::numbers::pi) / beyond;
    log_beyond = std::log(beyond);
  }
  return {-2 * log_beyond, hazard / sigma, hazard * (hazard - excess) / (sigma * sigma)};
}

/// The equations of one iteration: the free parameters' curvature and slope of half the cost.
struct CircleEquations {
  CircleDynamic h;
  CircleStep g;
  double cost = 0;
};

/// p + step, with lengths kept where the model means something and moves kept small.
RimVector moved(const RimVector& p, RimVector step, bool is_ring) {
  const double limit = std::max(0.5, 0.15 * p[kRadius]);
  for (const int i : {kCenterX, kCenterY, kRadius, kInnerRadius, kHoleX, kHoleY}) {
    step[i] = std::clamp(step[i], -limit, limit);
  }
  step[kSigma] = std::clamp(step[kSigma], -0.4 * p[kSigma], 0.8 * p[kSigma]);
  RimVector q = p + step;
  q[kRadius] = std::max(q[kRadius], 1.0);
  q[kSigma] = std::clamp(q[kSigma], kMinCircleSigma, max_edge_sigma(q[kRadius]));
  for (const int i : {kOval, kOvalDiagonal}) q[i] = std::clamp(q[i], -0.2, 0.2);
  if (is_ring) q[kInnerRadius] = std::clamp(q[kInnerRadius], 0.5, q[kRadius]);
  return q;
}

double largest_move(const RimVector& a, const RimVector& b) {
  const RimVector d = (a - b).cwiseAbs();
  return std::max({d[kCenterX],
                   d[kCenterY],
                   d[kRadius],
                   d[kSigma],
                   d[kInnerRadius],
                   d[kHoleX],
                   d[kHoleY],
                   d[kOval] * a[kRadius],
                   d[kOvalDiagonal] * a[kRadius]});
}

/// Strong residuals of what is not the rim make steps overshoot, every one nearly as far as the one
/// before: the minimum lies between two that reverse.
void shorten_reversal(const CircleStep& last, const CircleDynamic& h, CircleStep& step) {
  constexpr double kReverse = 0.3;
  if (last.size() == 0) return;
  const CircleStep h_last = h * last;
  const double reversal = -step.dot(h_last) / last.dot(h_last);
  if (reversal > kReverse) step /= 1 + reversal;
}

/// Parameters, and the step that led to them.
struct CircleState {
  RimVector p;
  CircleStep last = {};
};

class Accumulator {
 public:
  using State = CircleState;
  using Equations = CircleEquations;

  Accumulator(const RimWindow& window, const RimFitOptions& options)
      : window_(window), options_(options), n_(options.freedom.columns(columns_)) {
    rows_.setZero(kRows, n_);
  }

  CircleEquations equations_at(const CircleState& state) {
    const RimVector& p = state.p;
    CircleEquations equations;
    sums_.setZero(n_, n_);
    gradient_.setZero(n_);
    cost_ = 0;
    n_rows_ = 0;
    const RimBand& band = window_.band();
    for (std::size_t i = 0; i < band.size(); i += RimChunk::kSize) {
      chunk_.evaluate(band, i, p, options_.freedom, RimChunk::Want::Gradient);
      chunk_.weigh(band);
      if (band.has_clipped) weigh_clipped(band);
      add_chunk();
    }
    flush();
    equations.h = sums_;
    equations.g = gradient_;
    equations.cost = cost_;
    add_flat(p, equations);
    return equations;
  }

  std::optional<MinimiserStep<CircleState>> step(const CircleState& state,
                                                 const CircleEquations& equations,
                                                 double damping) const {
    CircleStep step = -damped_solution<kRimParameters>(equations.h, equations.g, damping);
    shorten_reversal(state.last, equations.h, step);
    RimVector all = RimVector::Zero();
    for (int i = 0; i < n_; ++i) all[columns_[static_cast<std::size_t>(i)]] = step[i];
    const RimVector next = moved(state.p, all, options_.freedom.is_ring);
    return MinimiserStep<CircleState>{{next, step},
                                      largest_move(next, state.p) / options_.tolerance_px,
                                      step.dot(equations.h * step)};
  }

 private:
  static constexpr Eigen::Index kLanes = RimChunk::kSize;
  static constexpr Eigen::Index kRows = 2 * kLanes;  // summed up as floats

  void weigh_clipped(const RimBand& band) {
    for (std::size_t i = 0; i < chunk_.n; ++i) {
      const double sign = band.clipped[chunk_.first + i];
      if (sign == 0) continue;
      const double sigma = 1 / std::sqrt(static_cast<double>(band.weight[chunk_.first + i]));
      const double beyond = -sign * static_cast<double>(chunk_.residual[i]) / sigma;
      const ClippedTerm term = clipped_term(beyond, sigma);
      const bool tells = term.curvature > 0;
      chunk_.cost[i] = tells ? static_cast<float>(term.cost) : 0;
      chunk_.root_weight[i] = tells ? static_cast<float>(std::sqrt(term.curvature)) : 0;
      chunk_.residual[i] = tells ? static_cast<float>(-sign * term.slope / term.curvature) : 0;
    }
  }

  void add_chunk() {
    const auto lanes = [](const RimChunk::Lanes& l) {
      return Eigen::Map<const Eigen::Array<float, kLanes, 1>>(l.data());
    };
    const auto root = lanes(chunk_.root_weight);
    for (int i = 0; i < n_; ++i) {
      const auto k = static_cast<std::size_t>(columns_[static_cast<std::size_t>(i)]);
      rows_.col(i).segment<kLanes>(n_rows_).array() = root * lanes(chunk_.gradient[k]);
    }
    residuals_.segment<kLanes>(n_rows_).array() = root * lanes(chunk_.residual);
    cost_ += static_cast<double>(lanes(chunk_.cost).sum());
    n_rows_ += kLanes;
    if (n_rows_ == kRows) flush();
  }

  void flush() {
    if (n_rows_ == 0) return;
    // Few columns: the packing of a general matrix product would take longer than the sums.
    for (int i = 0; i < n_; ++i) {
      const auto column = rows_.col(i).head(n_rows_).array();
      for (int j = 0; j <= i; ++j) {
        const double sum = static_cast<double>((column * rows_.col(j).head(n_rows_).array()).sum());
        sums_(i, j) += sum;
        if (i != j) sums_(j, i) += sum;
      }
      gradient_[i] += static_cast<double>((column * residuals_.head(n_rows_).array()).sum());
    }
    n_rows_ = 0;
  }

  /// Flat pixels touch the levels and the light only.
  void add_flat(const RimVector& p, CircleEquations& equations) const {
    for (std::size_t i = 0; i < kRimZones; ++i) {
      const FlatMoments& m = window_.flat()[i];
      if (m.n == 0) continue;
      const double w = 1 / (options_.noise.sigma[i] * options_.noise.sigma[i]);
      Eigen::Vector3d level = zone_level(p, static_cast<RimZone>(i));
      level[0] -= static_cast<double>(window_.reference());
      equations.cost += w * level.dot(m.bb * level - 2 * m.bv);
      const auto all = zone_level_jacobian(p, static_cast<RimZone>(i));
      Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kRimParameters> d(3, n_);
      for (int k = 0; k < n_; ++k) d.col(k) = all.col(columns_[static_cast<std::size_t>(k)]);
      equations.h += w * d.transpose() * m.bb * d;
      equations.g += w * d.transpose() * (m.bb * level - m.bv);
    }
  }

  const RimWindow& window_;
  const RimFitOptions& options_;
  std::array<int, kRimParameters> columns_{};
  int n_;
  RimChunk chunk_;
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kRows, kRimParameters>
      rows_;
  Eigen::Matrix<float, kRows, 1> residuals_;
  CircleStep gradient_;
  CircleDynamic sums_;
  double cost_ = 0;
  Eigen::Index n_rows_ = 0;
};

}  // namespace

RimSolution fit_rim(const RimWindow& window, const RimVector& start, const RimFitOptions& options) {
  Accumulator accumulator(window, options);
  const CircleState first{moved(start, RimVector::Zero(), options.freedom.is_ring)};
  const auto minimum = minimised(accumulator,
                                 first,
                                 {.max_iterations = kMaxCircleIterations,
                                  .first_damping = 1e-6,
                                  .damping_after_failure = 1e-2,
                                  .cost_rounding = kCircleCostRounding});
  RimSolution solution;
  solution.parameters = minimum.state.p;
  solution.freedom = options.freedom;
  solution.information = minimum.equations.h;
  solution.n_evaluations = minimum.n_evaluations;
  solution.converged = minimum.converged;
  return solution;
}

double max_edge_sigma(double radius) {
  return std::max(1.5, kMaxSigmaOfRadius * radius);
}

void set_weights(RimWindow& window, const RimVector& parameters, const RimNoise& noise) {
  const double outside = noise[RimZone::Outside] * noise[RimZone::Outside];
  const double target = noise[RimZone::Target] * noise[RimZone::Target];
  const double ratio = target / outside;
  const bool is_even = ratio > 0.8 && ratio < 1.25;
  RimBand& band = window.band();
  if (is_even) {
    std::fill(band.weight.begin(), band.weight.end(), static_cast<float>(2 / (target + outside)));
    return;
  }
  const RimBandValues values = band_values(band, parameters, window.is_ring());
  for (std::size_t i = 0; i < band.size(); ++i) {
    const double share = std::clamp(static_cast<double>(values.share[i]), 0.0, 1.0);
    band.weight[i] = static_cast<float>(1 / (share * target + (1 - share) * outside));
  }
}

}  // namespace panelcal::internal
