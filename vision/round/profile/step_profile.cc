// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/step_profile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "vision/fit/gauss_table.h"
#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr double kMinStepSigma_px = 0.4;
constexpr int kMaxStepIterations = 12;

GaussValue gauss_at(double t) {
  return gauss(std::clamp(t, -kEdgeReach, kEdgeReach));
}

constexpr int kMostColumns = 8;
using StepMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostColumns, kMostColumns>;
using StepVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostColumns, 1>;

/// Levels, slopes and heights that fit best for places and a blur; the squares that are left.
double fit_levels(const Eigen::ArrayXd& levels, double first_px, StepProfile& step) {
  const auto n_others = static_cast<Eigen::Index>(step.others.size());
  StepMatrix h = StepMatrix::Zero(4 + n_others, 4 + n_others);
  StepVector g = StepVector::Zero(4 + n_others);
  // Slopes are held a little, so that a zone of few rings has none.
  h(1, 1) = h(3, 3) = 2;
  StepVector row(4 + n_others);
  for (Eigen::Index j = 0; j < levels.size(); ++j) {
    const double x = first_px + static_cast<double>(j);
    const double s = step.share(x);
    row.head<4>() << 1 - s, (1 - s) * x, s, s * x;
    for (Eigen::Index k = 0; k < n_others; ++k) {
      row[4 + k] = step.other_share(step.others[static_cast<std::size_t>(k)], x);
    }
    h += row * row.transpose();
    g += row * levels[j];
  }
  const StepVector solution = h.ldlt().solve(g);
  step.outside = solution[0];
  step.outside_slope = solution[1];
  step.inside = solution[2];
  step.inside_slope = solution[3];
  for (Eigen::Index k = 0; k < n_others; ++k) {
    step.others[static_cast<std::size_t>(k)].height = solution[4 + k];
  }
  double squares = 0;
  for (Eigen::Index j = 0; j < levels.size(); ++j) {
    const double d = levels[j] - step.level(first_px + static_cast<double>(j));
    squares += d * d;
  }
  return squares;
}

/// How the level at a place changes with the step's place, its blur and the others' places.
StepVector level_gradient(const StepProfile& step, double x) {
  StepVector row(2 + static_cast<Eigen::Index>(step.others.size()));
  const double d = step.steepness(x);
  row.head<2>() << -d, -d * (x - step.at_px) / step.sigma_px;
  for (std::size_t k = 0; k < step.others.size(); ++k) {
    const OtherStep& other = step.others[k];
    const double moved = other.height * step.other_steepness(other, x);
    row[1] += moved * (x - other.at_px) / step.sigma_px;
    row[2 + static_cast<Eigen::Index>(k)] = moved;
  }
  return row;
}

/// A Gauss-Newton step of places and blur; empty if the levels do not tell.
std::optional<StepVector> next_move(const Eigen::ArrayXd& levels,
                                    double first_px,
                                    const StepProfile& step,
                                    double damping) {
  const auto n = 2 + static_cast<Eigen::Index>(step.others.size());
  StepMatrix h = StepMatrix::Zero(n, n);
  StepVector g = StepVector::Zero(n);
  for (Eigen::Index j = 0; j < levels.size(); ++j) {
    const double x = first_px + static_cast<double>(j);
    const StepVector row = level_gradient(step, x);
    h += row * row.transpose();
    g += row * (levels[j] - step.level(x));
  }
  h.diagonal() *= 1 + damping;
  const Eigen::LLT<StepMatrix> factor(h);
  if (factor.info() != Eigen::Success) return std::nullopt;
  StepVector move = factor.solve(g);
  if (!move.allFinite()) return std::nullopt;
  for (Eigen::Index k = 0; k < n; ++k) {
    move[k] = k == 1 ? std::clamp(move[k], -0.5, 0.8) : std::clamp(move[k], -1.0, 1.0);
  }
  return move;
}

}  // namespace

double StepProfile::share(double x_px) const {
  return gauss_at((x_px - at_px) / sigma_px).cdf;
}
double StepProfile::other_share(const OtherStep& other, double x_px) const {
  const double side = other.at_px > at_px ? 1 : -1;
  return gauss_at(side * (x_px - other.at_px) / sigma_px).cdf;
}
double StepProfile::other_steepness(const OtherStep& other, double x_px) const {
  const double side = other.at_px > at_px ? 1 : -1;
  return -side * gauss_at((x_px - other.at_px) / sigma_px).pdf / sigma_px;
}
double StepProfile::level(double x_px) const {
  const double s = share(x_px);
  double level = (outside + outside_slope * x_px) * (1 - s) + (inside + inside_slope * x_px) * s;
  for (const OtherStep& other : others) level += other.height * other_share(other, x_px);
  return level;
}
double StepProfile::steepness(double x_px) const {
  const double step = inside - outside + (inside_slope - outside_slope) * x_px;
  return step * gauss_at((x_px - at_px) / sigma_px).pdf / sigma_px;
}

std::optional<StepProfile> fit_step(const Eigen::ArrayXd& levels,
                                    double first_px,
                                    const StepProfile& start) {
  if (levels.size() < 7) return std::nullopt;
  const double last_px = first_px + static_cast<double>(levels.size() - 1);
  StepProfile step = start;
  double squares = fit_levels(levels, first_px, step);
  double damping = 1e-3;
  for (int i = 0; i < kMaxStepIterations; ++i) {
    const auto move = next_move(levels, first_px, step, damping);
    if (!move) return std::nullopt;
    StepProfile next = step;
    next.at_px = std::clamp(step.at_px + (*move)[0], first_px + 1, last_px - 1);
    next.sigma_px =
        std::clamp(step.sigma_px + (*move)[1], kMinStepSigma_px, 0.5 * (last_px - first_px));
    for (std::size_t k = 0; k < next.others.size(); ++k) {
      next.others[k].at_px += (*move)[2 + static_cast<Eigen::Index>(k)];
    }
    const double next_squares = fit_levels(levels, first_px, next);
    if (!(next_squares <= squares)) {
      damping = std::max(0.1, damping * 10);
      if (damping > 1e4) break;
      continue;
    }
    const bool is_settled = move->norm() < 1e-3;
    step = next;
    squares = next_squares;
    damping *= 0.1;
    if (is_settled) break;
  }
  return step;
}

}  // namespace panelcal::internal
