// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/rim_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr int kMaxIterations = 15;         // a rim takes 3 or 4; more means that there is none
constexpr double kCostRounding = 1e-9;     // of the cost's curvature part
constexpr double kMinSigma = 0.32;         // a pixel behind a perfect lens has 0.29
constexpr double kMaxSigmaOfRadius = 0.3;  // a blurrier rim is no rim

using Dynamic = Eigen::Matrix<double,
                              Eigen::Dynamic,
                              Eigen::Dynamic,
                              Eigen::ColMajor,
                              kRimParameters + 1,
                              kRimParameters + 1>;

/// How much one clipped pixel says: -2 log of its probability, and derivatives by the level.
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
struct Equations {
  Dynamic h;
  Eigen::VectorXd g;
  double cost = 0;
};

class Accumulator {
 public:
  Accumulator(const RimWindow& window, const RimFitOptions& options)
      : window_(window), options_(options), n_(options.freedom.columns(columns_)) {
    rows_.resize(kChunk, n_ + 1);
  }

  int n() const { return n_; }
  /// Parameters that are not free get 0.
  RimVector expanded(const Eigen::VectorXd& free) const {
    RimVector all = RimVector::Zero();
    for (int i = 0; i < n_; ++i) all[columns_[static_cast<std::size_t>(i)]] = free[i];
    return all;
  }

  Equations at(const RimVector& p) {
    Equations equations;
    sums_.setZero(n_ + 1, n_ + 1);
    cost_ = 0;
    n_rows_ = 0;
    for (const RimPixel& pixel : window_.band()) add(pixel, p);
    flush();
    equations.h = sums_.topLeftCorner(n_, n_);
    equations.g = sums_.col(n_).head(n_);
    equations.cost = cost_;
    add_flat(p, equations);
    return equations;
  }

 private:
  static constexpr Eigen::Index kChunk = 128;

  void add(const RimPixel& pixel, const RimVector& p) {
    const RimValue value = rim_value(pixel, p, options_.freedom.is_ring, &gradient_);
    double weight = static_cast<double>(pixel.weight);
    double residual = value.level - static_cast<double>(pixel.value);
    if (pixel.clipped != 0) {
      const double sigma = 1 / std::sqrt(weight);
      const double sign = pixel.clipped;
      const ClippedTerm term = clipped_term(-sign * residual / sigma, sigma);
      if (term.curvature <= 0) return;
      cost_ += term.cost;
      weight = term.curvature;
      residual = -sign * term.slope / weight;
    } else {
      const double z2 = residual * residual * weight;
      if (options_.huber > 0 && z2 > options_.huber * options_.huber) {
        const double z = std::sqrt(z2);
        cost_ += options_.huber * (2 * z - options_.huber);
        weight *= options_.huber / z;
      } else {
        cost_ += z2;
      }
    }
    const double root = std::sqrt(weight);
    for (int i = 0; i < n_; ++i) {
      rows_(n_rows_, i) = static_cast<float>(
          root * gradient_[static_cast<std::size_t>(columns_[static_cast<std::size_t>(i)])]);
    }
    rows_(n_rows_, n_) = static_cast<float>(root * residual);
    if (++n_rows_ == kChunk) flush();
  }

  void flush() {
    if (n_rows_ == 0) return;
    const auto rows = rows_.topRows(n_rows_);
    product_.noalias() = rows.transpose() * rows;
    sums_ += product_.cast<double>();
    n_rows_ = 0;
  }

  /// Flat pixels touch the levels and the light only.
  void add_flat(const RimVector& p, Equations& equations) const {
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
  RimGradient gradient_{};
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kChunk, kRimParameters + 1>
      rows_;
  Eigen::Matrix<float,
                Eigen::Dynamic,
                Eigen::Dynamic,
                Eigen::ColMajor,
                kRimParameters + 1,
                kRimParameters + 1>
      product_;
  Dynamic sums_;
  double cost_ = 0;
  Eigen::Index n_rows_ = 0;
};

/// The damped step, or zero if the equations are singular.
Eigen::VectorXd solve(const Equations& equations, double damping) {
  Dynamic h = equations.h;
  for (Eigen::Index i = 0; i < h.rows(); ++i) h(i, i) += damping * h(i, i) + 1e-12;
  const Eigen::LDLT<Dynamic> factor(h);
  Eigen::VectorXd step = Eigen::VectorXd::Zero(h.rows());
  if (factor.info() == Eigen::Success && factor.isPositive()) step = -factor.solve(equations.g);
  if (!step.allFinite()) step.setZero();
  return step;
}

/// p + step, with lengths kept where the model means something and moves kept small.
RimVector moved(const RimVector& p, RimVector step, bool is_ring) {
  const double limit = std::max(0.5, 0.15 * p[kRadius]);
  for (const int i : {kCenterX, kCenterY, kRadius, kInnerRadius, kHoleX, kHoleY}) {
    step[i] = std::clamp(step[i], -limit, limit);
  }
  step[kSigma] = std::clamp(step[kSigma], -0.4 * p[kSigma], 0.8 * p[kSigma]);
  RimVector q = p + step;
  q[kRadius] = std::max(q[kRadius], 1.0);
  q[kSigma] = std::clamp(q[kSigma], kMinSigma, max_edge_sigma(q[kRadius]));
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

}  // namespace

RimSolution fit_rim(const RimWindow& window, const RimVector& start, const RimFitOptions& options) {
  Accumulator accumulator(window, options);
  const bool is_ring = options.freedom.is_ring;
  RimSolution solution;
  solution.freedom = options.freedom;
  solution.parameters = moved(start, RimVector::Zero(), is_ring);
  double damping = 1e-6;
  Equations equations = accumulator.at(solution.parameters);
  solution.n_evaluations = 1;
  for (int i = 0; i < kMaxIterations && !solution.converged && damping < 1e8; ++i) {
    const Eigen::VectorXd step = solve(equations, damping);
    const RimVector next = moved(solution.parameters, accumulator.expanded(step), is_ring);
    const bool is_small = largest_move(next, solution.parameters) < options.tolerance_px;
    if (is_small && damping < 0.1) {
      // The next step would be smaller by as much again: no need to look.
      solution.parameters = next;
      solution.converged = true;
      break;
    }
    Equations next_equations = accumulator.at(next);
    ++solution.n_evaluations;
    const double scale = std::abs(equations.cost) + step.dot(equations.h * step);
    if (next_equations.cost <= equations.cost + kCostRounding * scale) {
      solution.parameters = next;
      equations = std::move(next_equations);
      damping = std::max(1e-9, damping * 0.1);
    } else {
      damping = std::max(1e-2, damping * 10);
    }
  }
  solution.information = equations.h;
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
  for (RimPixel& pixel : window.band()) {
    double share = 0.5;
    if (!is_even) {
      share = std::clamp(rim_value(pixel, parameters, window.is_ring(), nullptr).share, 0.0, 1.0);
    }
    pixel.weight = static_cast<float>(1 / (share * target + (1 - share) * outside));
  }
}

}  // namespace panelcal::internal
