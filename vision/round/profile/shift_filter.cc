// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/shift_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "calib/base/statistics/median.h"
#include "vision/round/profile/sector_turns.h"
#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr double kFarOff = 3.5 * kSigmasPerMedian;  // of the median magnitude

/// Rings nearer to the rim than this many sigmas are part of the step.
constexpr double kStepReach = 2.7;
/// Textures are looked at in waves along the rim of 2 periods and more, down to this length.
constexpr double kShortestWave_px = 24;
constexpr int kFewestRings = 4;
constexpr double kRoundingVariance = 1.0 / 12;

/// First ring and the one past the last.
struct RingRange {
  Eigen::Index first = 0;
  Eigen::Index end = 0;

  Eigen::Index n() const { return std::max<Eigen::Index>(0, end - first); }
};

/// The autocovariance of rings by their distance, of slow waves along the rim: divided by the
/// number of rings, which keeps it positive definite.
Eigen::VectorXd ring_autocovariance(const Eigen::ArrayXXf& left, RingRange rings, int n_waves) {
  const Eigen::Index n = left.cols();
  Eigen::VectorXd covariance = Eigen::VectorXd::Zero(std::max<Eigen::Index>(1, rings.n()));
  const SectorTurns turns(n);
  Eigen::VectorXf cosine(n);
  Eigen::VectorXf sine(n);
  for (int m = 2; m < 2 + n_waves; ++m) {
    turns.for_each(m, [&](Eigen::Index i, const std::complex<double>& turn) {
      cosine[i] = static_cast<float>(turn.real());
      sine[i] = static_cast<float>(turn.imag());
    });
    const auto rows = left.middleRows(rings.first, rings.n()).matrix();
    const Eigen::VectorXd a = (rows * cosine).cast<double>();
    const Eigen::VectorXd b = (rows * sine).cast<double>();
    for (Eigen::Index lag = 0; lag < rings.n(); ++lag) {
      const Eigen::Index k = rings.n() - lag;
      covariance[lag] += a.head(k).dot(a.tail(k)) + b.head(k).dot(b.tail(k));
    }
  }
  return covariance / (static_cast<double>(n) * n_waves *
                       static_cast<double>(std::max<Eigen::Index>(1, rings.n())));
}

double at_lag(const Eigen::VectorXd& covariance, Eigen::Index lag) {
  return lag < covariance.size() ? covariance[lag] : 0;
}

/// Shading makes the levels beside a rim slope as they like, within this part of the contrast per
/// px.
void add_slopes(const RimStrip& strip, const StepProfile& step, Eigen::MatrixXd& covariance) {
  constexpr double kSlope = 0.005;
  Eigen::VectorXd inside(strip.n_rings());
  Eigen::VectorXd outside(strip.n_rings());
  for (Eigen::Index j = 0; j < strip.n_rings(); ++j) {
    const double x = strip.at_px(j) - step.at_px;
    const double s = step.share(strip.at_px(j));
    inside[j] = s * x;
    outside[j] = (1 - s) * x;
  }
  const double variance = std::pow(kSlope * step.contrast(), 2);
  covariance += variance * (inside * inside.transpose() + outside * outside.transpose());
}

/// Ring by ring: what a shift changes, the level inside and that outside; of each other step what
/// its height changes and what its shift does.
Eigen::MatrixXd step_columns(const RimStrip& strip, const StepProfile& step) {
  const auto n_others = static_cast<Eigen::Index>(step.others.size());
  Eigen::MatrixXd columns(strip.n_rings(), 3 + 2 * n_others);
  for (Eigen::Index j = 0; j < strip.n_rings(); ++j) {
    const double x = strip.at_px(j);
    const double s = step.share(x);
    columns.row(j).head<3>() << step.steepness(x), s, 1 - s;
    for (Eigen::Index k = 0; k < n_others; ++k) {
      const OtherStep& other = step.others[static_cast<std::size_t>(k)];
      columns(j, 3 + 2 * k) = step.other_share(other, x);
      columns(j, 4 + 2 * k) = step.other_steepness(other, x);
    }
  }
  return columns;
}

Eigen::MatrixXd plain_covariance(const RimStrip& strip, const StepProfile& step, double variance) {
  const Eigen::VectorXd variances = variance / strip.mass.max(0.1);
  Eigen::MatrixXd covariance = variances.matrix().asDiagonal();
  add_slopes(strip, step, covariance);
  return covariance;
}

/// Weights of least variance that answer 1 to the first column and 0 to the others.
ShiftFilter best_filter(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& columns) {
  ShiftFilter filter;
  filter.weights = Eigen::VectorXd::Zero(covariance.rows());
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success) return filter;
  const Eigen::MatrixXd solved = factor.solve(columns);
  Eigen::MatrixXd normal = columns.transpose() * solved;
  normal.diagonal() *= 1 + 1e-9;
  const Eigen::VectorXd first = normal.ldlt().solve(Eigen::VectorXd::Unit(columns.cols(), 0));
  if (!first.allFinite()) return filter;
  filter.weights = solved * first;
  filter.variance = first[0];
  return filter;
}

/// Cells that are far off are pulled in, on each side of the rim: single things are no texture.
Eigen::ArrayXXf tamed_cells(const RimStrip& strip,
                            const StepProfile& step,
                            const Eigen::ArrayXXf& left) {
  Eigen::ArrayXXf tamed = left;
  std::vector<float> magnitudes;
  for (const bool is_inside : {false, true}) {
    magnitudes.clear();
    const auto is_here = [&](Eigen::Index j) { return (strip.at_px(j) > step.at_px) == is_inside; };
    for (Eigen::Index j = 0; j < left.rows(); ++j) {
      if (!is_here(j)) continue;
      for (Eigen::Index i = j % 3; i < left.cols(); i += 3)
        magnitudes.push_back(std::abs(left(j, i)));
    }
    if (magnitudes.empty()) continue;
    const auto middle = static_cast<float>(median(std::move(magnitudes)));
    const float limit = std::max(0.5F, static_cast<float>(kFarOff) * middle);
    for (Eigen::Index j = 0; j < left.rows(); ++j) {
      if (is_here(j)) tamed.row(j) = left.row(j).max(-limit).min(limit);
    }
  }
  return tamed;
}

}  // namespace

ShiftFilter make_shift_filter(const RimStrip& strip,
                              const Eigen::ArrayXXf& left,
                              const StepProfile& step) {
  const Eigen::ArrayXXf tamed = tamed_cells(strip, step, left);
  const Eigen::Index n = strip.n_rings();
  const double reach = kStepReach * step.sigma_px + 0.5;
  RingRange outside{0, 0};
  RingRange inside{n, n};
  for (Eigen::Index j = 0; j < n; ++j) {
    if (strip.at_px(j) - step.at_px < -reach) outside.end = j + 1;
  }
  for (Eigen::Index j = n; j-- > 0;) {
    if (strip.at_px(j) - step.at_px > reach) inside.first = j;
  }
  const double around_px = 2 * static_cast<double>(strip.n_sectors());  // about
  const int n_waves = std::clamp(static_cast<int>(around_px / kShortestWave_px) - 1, 3, 24);
  std::array<Eigen::VectorXd, 2> textures = {ring_autocovariance(tamed, outside, n_waves),
                                             ring_autocovariance(tamed, inside, n_waves)};
  if (outside.n() < kFewestRings) textures[0] = textures[1];
  if (inside.n() < kFewestRings) textures[1] = textures[0];
  for (Eigen::VectorXd& t : textures) t[0] = std::max(1.02 * t[0], kRoundingVariance / 2);

  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const double s = step.share(strip.at_px(j));
    for (Eigen::Index i = 0; i <= j; ++i) {
      const double r = step.share(strip.at_px(i));
      const double c =
          s * r * at_lag(textures[1], j - i) + (1 - s) * (1 - r) * at_lag(textures[0], j - i);
      // Pixels of the step have both kinds of noise in part, and all of the camera's.
      const double white = i == j ? 2 * s * (1 - s) * std::min(textures[0][0], textures[1][0]) : 0;
      covariance(j, i) = covariance(i, j) = c + white;
    }
  }
  add_slopes(strip, step, covariance);
  return best_filter(covariance, step_columns(strip, step));
}

ShiftFilter make_plain_filter(const RimStrip& strip, const StepProfile& step, double variance) {
  return best_filter(plain_covariance(strip, step, variance), step_columns(strip, step));
}

ShiftFilter make_blur_filter(const RimStrip& strip, const StepProfile& step, double variance) {
  const Eigen::MatrixXd shift = step_columns(strip, step);
  Eigen::MatrixXd columns(shift.rows(), shift.cols() + 1);
  for (Eigen::Index j = 0; j < shift.rows(); ++j) {
    columns.row(j) << shift(j, 0) * (step.at_px - strip.at_px(j)) / step.sigma_px, shift.row(j);
  }
  return best_filter(plain_covariance(strip, step, variance), columns);
}

double band_shift(const RimStrip& strip,
                  const Eigen::ArrayXd& medians,
                  const StepProfile& step,
                  const ShiftFilter& filter) {
  double shift_px = 0;
  for (Eigen::Index j = 0; j < strip.n_rings(); ++j) {
    shift_px += std::abs(filter.weights[j] * (medians[j] - step.level(strip.at_px(j))));
  }
  return shift_px;
}

}  // namespace panelcal::internal
