// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/step_profile.h"

#include <algorithm>
#include <cmath>

#include "vision/fit/gauss_table.h"
#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr double kMinStepSigma_px = 0.4;
constexpr int kMaxStepIterations = 12;

GaussValue gauss_at(double t) {
  return gauss(std::clamp(t, -kEdgeReach, kEdgeReach));
}

/// Levels and slopes that fit best for a place and a blur; the squares that are left.
double fit_levels(const Eigen::ArrayXd& levels, double first_px, StepProfile& step) {
  Eigen::Matrix4d h = Eigen::Matrix4d::Zero();
  Eigen::Vector4d g = Eigen::Vector4d::Zero();
  // Slopes are held a little, so that a zone of few rings has none.
  h(1, 1) = h(3, 3) = 2;
  for (Eigen::Index j = 0; j < levels.size(); ++j) {
    const double x = first_px + static_cast<double>(j);
    const double s = step.share(x);
    const Eigen::Vector4d row(1 - s, (1 - s) * x, s, s * x);
    h += row * row.transpose();
    g += row * levels[j];
  }
  const Eigen::Vector4d solution = h.ldlt().solve(g);
  step.outside = solution[0];
  step.outside_slope = solution[1];
  step.inside = solution[2];
  step.inside_slope = solution[3];
  double squares = 0;
  for (Eigen::Index j = 0; j < levels.size(); ++j) {
    const double d = levels[j] - step.level(first_px + static_cast<double>(j));
    squares += d * d;
  }
  return squares;
}

}  // namespace

double StepProfile::share(double x_px) const {
  return gauss_at((x_px - at_px) / sigma_px).cdf;
}
double StepProfile::level(double x_px) const {
  const double s = share(x_px);
  return (outside + outside_slope * x_px) * (1 - s) + (inside + inside_slope * x_px) * s;
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
    Eigen::Matrix2d h = Eigen::Matrix2d::Zero();
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    for (Eigen::Index j = 0; j < levels.size(); ++j) {
      const double x = first_px + static_cast<double>(j);
      const double d = step.steepness(x);
      const Eigen::Vector2d row(-d, -d * (x - step.at_px) / step.sigma_px);
      h += row * row.transpose();
      g += row * (levels[j] - step.level(x));
    }
    h(0, 0) *= 1 + damping;
    h(1, 1) *= 1 + damping;
    const double det = h(0, 0) * h(1, 1) - h(0, 1) * h(1, 0);
    if (!(det > 0)) return std::nullopt;
    const Eigen::Vector2d move(std::clamp((h(1, 1) * g[0] - h(0, 1) * g[1]) / det, -1.0, 1.0),
                               std::clamp((h(0, 0) * g[1] - h(1, 0) * g[0]) / det, -0.5, 0.8));
    StepProfile next = step;
    next.at_px = std::clamp(step.at_px + move[0], first_px + 1, last_px - 1);
    next.sigma_px =
        std::clamp(step.sigma_px + move[1], kMinStepSigma_px, 0.5 * (last_px - first_px));
    const double next_squares = fit_levels(levels, first_px, next);
    if (!(next_squares <= squares)) {
      damping = std::max(0.1, damping * 10);
      if (damping > 1e4) break;
      continue;
    }
    const bool is_settled = move.norm() < 1e-3;
    step = next;
    squares = next_squares;
    damping *= 0.1;
    if (is_settled) break;
  }
  return step;
}

}  // namespace panelcal::internal
