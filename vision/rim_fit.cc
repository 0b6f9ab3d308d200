// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/rim_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr int kMaxIterations = 15;  // a rim takes 3 to 5; more means that there is none
/// Cost differences below this part are rounding.
constexpr double kCostRounding = 1e-10;
constexpr double kMinSigma = 0.32;          // a pixel behind a perfect lens has 0.29
constexpr double kMaxSigmaOfRadius = 0.15;  // a blurrier rim is no rim

/// Normal equations; flat pixels touch only the six plane parameters and are summed apart.
struct NormalEquations {
  RimMatrix h = RimMatrix::Zero();
  RimVector g = RimVector::Zero();
  Eigen::Matrix3d h_outside = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d h_inside = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g_outside = Eigen::Vector3d::Zero();
  Eigen::Vector3d g_inside = Eigen::Vector3d::Zero();
  double cost = 0;
  int n_pixels = 0;

  void finish() {
    h.block<3, 3>(kPlane, kPlane) += h_outside + h_inside;
    h.block<3, 3>(kPlane, kContrast) += h_inside;
    h.block<3, 3>(kContrast, kPlane) += h_inside;
    h.block<3, 3>(kContrast, kContrast) += h_inside;
    g.segment<3>(kPlane) += g_outside + g_inside;
    g.segment<3>(kContrast) += g_inside;
  }
};

double huber_cost(double z, double huber) {
  return huber > 0 && z > huber ? huber * (2 * z - huber) : z * z;
}

/// Sums the equations at p; `equations` null: only the cost.
double accumulate(const RimProblem& problem,
                  const RimVector& p,
                  double huber,
                  NormalEquations* equations) {
  RimVector gradient;
  double cost = 0;
  for (const WindowPixel& pixel : problem.window.pixels) {
    if (!pixel.in_fit || pixel.is_excluded) continue;
    const auto value = problem.model.evaluate(pixel, p, equations ? &gradient : nullptr);
    if (is_clipped(pixel.value, value.level, problem.full_scale)) continue;
    const double residual = value.level - pixel.value;
    double weight = pixel.weight;
    const double z = std::abs(residual) * std::sqrt(weight);
    cost += huber_cost(z, huber);
    if (!equations) continue;
    if (huber > 0 && z > huber) weight *= huber / z;
    ++equations->n_pixels;
    const double wr = weight * residual;
    switch (value.zone) {
      case RimModel::Zone::Outside:
        equations->h_outside += weight * value.plane * value.plane.transpose();
        equations->g_outside += wr * value.plane;
        break;
      case RimModel::Zone::Inside:
        equations->h_inside += weight * value.plane * value.plane.transpose();
        equations->g_inside += wr * value.plane;
        break;
      case RimModel::Zone::Rim:
        equations->h += weight * gradient * gradient.transpose();
        equations->g += wr * gradient;
        break;
    }
  }
  if (equations) {
    equations->finish();
    equations->cost = cost;
  }
  return cost;
}

using Dynamic = Eigen::Matrix<double,
                              Eigen::Dynamic,
                              Eigen::Dynamic,
                              Eigen::ColMajor,
                              kMaxRimParameters,
                              kMaxRimParameters>;

/// The damped step, or zero if the equations are singular.
RimVector solve(const NormalEquations& equations, int n, double damping) {
  Dynamic h = equations.h.topLeftCorner(n, n);
  for (int i = 0; i < n; ++i) h(i, i) += damping * h(i, i) + 1e-12;
  RimVector step = RimVector::Zero();
  const Eigen::LDLT<Dynamic> factor(h);
  if (factor.info() == Eigen::Success && factor.isPositive()) {
    step.head(n) = -factor.solve(equations.g.head(n));
  }
  if (!step.allFinite()) step.setZero();
  return step;
}

/// p + step, with lengths kept where the model means something and moves kept small.
RimVector moved(const RimVector& p, RimVector step, bool is_ring) {
  const double limit = std::max(0.5, 0.15 * p[kRadius]);
  for (const int i : {int(kCenterX), int(kCenterY), int(kRadius), int(kInnerRadius)}) {
    step[i] = std::clamp(step[i], -limit, limit);
  }
  step[kSigma] = std::clamp(step[kSigma], -0.5 * p[kSigma], 1.0 * p[kSigma]);
  RimVector q = p + step;
  q[kRadius] = std::max(q[kRadius], 1.0);
  q[kSigma] = std::clamp(q[kSigma], kMinSigma, std::max(1.5, kMaxSigmaOfRadius * q[kRadius]));
  if (is_ring) q[kInnerRadius] = std::clamp(q[kInnerRadius], 0.5, q[kRadius]);
  return q;
}

double largest_move(const RimVector& a, const RimVector& b) {
  const RimVector d = (a - b).cwiseAbs();
  return std::max({d[kCenterX], d[kCenterY], d[kRadius], d[kSigma], d[kInnerRadius]});
}

double median_of(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

RimSolution fit_rim(const RimProblem& problem,
                    const RimVector& start,
                    double huber,
                    double tolerance_px) {
  const int n = problem.model.n_parameters();
  RimSolution solution;
  solution.parameters = moved(start, RimVector::Zero(), problem.model.is_ring());
  double damping = 1e-4;
  NormalEquations equations;
  solution.cost = accumulate(problem, solution.parameters, huber, &equations);
  for (int i = 0; i < kMaxIterations && !solution.converged && damping < 1e8; ++i) {
    const RimVector step = solve(equations, n, damping);
    const RimVector next = moved(solution.parameters, step, problem.model.is_ring());
    NormalEquations next_equations;
    const double cost = accumulate(problem, next, huber, &next_equations);
    const bool is_small = largest_move(next, solution.parameters) < tolerance_px;
    if (cost <= solution.cost * (1 + kCostRounding)) {
      solution.converged = is_small && damping < 1;
      solution.parameters = next;
      solution.cost = cost;
      equations = next_equations;
      damping = std::max(1e-9, damping * 0.1);
    } else {
      solution.converged = is_small && damping < 1;
      damping = std::max(1e-3, damping * 10);
    }
  }
  solution.information.topLeftCorner(n, n) = equations.h.topLeftCorner(n, n);
  solution.n_pixels = equations.n_pixels;
  return solution;
}

void set_weights(RimProblem& problem, const RimVector& parameters, const PixelNoise& noise) {
  for (WindowPixel& pixel : problem.window.pixels) {
    const auto value = problem.model.evaluate(pixel, parameters, nullptr);
    const double share = std::clamp(value.share, 0.0, 1.0);
    pixel.weight =
        1 / (share * noise.inside * noise.inside + (1 - share) * noise.outside * noise.outside);
  }
}

double exclude_strangers(RimProblem& problem, const RimVector& parameters) {
  constexpr double kSigmas = 6;
  constexpr double kOfContrast = 0.15;
  constexpr double kRimOfContrast = 0.35;  // a rim that is not quite round must not be cut away
  constexpr int kGrow = 2;                 // px: the blurred foot of what was excluded

  std::vector<double> magnitudes;
  std::vector<double> residuals(problem.window.pixels.size(), 0);
  std::vector<char> is_rim(problem.window.pixels.size(), 0);
  for (std::size_t i = 0; i < problem.window.pixels.size(); ++i) {
    const WindowPixel& pixel = problem.window.pixels[i];
    const auto value = problem.model.evaluate(pixel, parameters, nullptr);
    if (is_clipped(pixel.value, value.level, problem.full_scale)) continue;
    residuals[i] = std::abs(pixel.value - value.level);
    is_rim[i] = std::abs(value.distance_px) < 2.5 * parameters[kSigma];
    if (pixel.in_fit) magnitudes.push_back(residuals[i]);
  }
  const double sigma = std::max(0.3, 1.4826 * median_of(magnitudes));
  const double contrast = std::abs(parameters[kContrast]);

  const FitWindow& window = problem.window;
  const auto cell = [&](int x, int y) {
    return static_cast<std::size_t>(y - window.y0) * static_cast<std::size_t>(window.width) +
           static_cast<std::size_t>(x - window.x0);
  };
  std::vector<char> grown(
      static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height), 0);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const double share = is_rim[i] ? kRimOfContrast : kOfContrast;
    if (residuals[i] <= std::max(kSigmas * sigma, share * contrast)) continue;
    const WindowPixel& pixel = window.pixels[i];
    for (int y = std::max(window.y0, pixel.y - kGrow);
         y <= std::min(window.y0 + window.height - 1, pixel.y + kGrow);
         ++y) {
      for (int x = std::max(window.x0, pixel.x - kGrow);
           x <= std::min(window.x0 + window.width - 1, pixel.x + kGrow);
           ++x) {
        grown[cell(x, y)] = 1;
      }
    }
  }
  int n_fit = 0;
  int n_excluded = 0;
  for (WindowPixel& pixel : problem.window.pixels) {
    pixel.is_excluded = grown[cell(pixel.x, pixel.y)] != 0;
    n_fit += pixel.in_fit;
    n_excluded += pixel.in_fit && pixel.is_excluded;
  }
  return n_fit > 0 ? static_cast<double>(n_excluded) / n_fit : 1;
}

PixelNoise noise_of(const RimProblem& problem, const RimVector& parameters) {
  // Rounding to whole levels is noise as well, and all there is in a perfect picture.
  constexpr double kRounding = 0.2887;
  constexpr int kFewPixels = 20;
  double sum_outside = 0;
  double sum_inside = 0;
  int n_outside = 0;
  int n_inside = 0;
  for (const WindowPixel& pixel : problem.window.pixels) {
    if (!pixel.in_fit || pixel.is_excluded) continue;
    const auto value = problem.model.evaluate(pixel, parameters, nullptr);
    if (is_clipped(pixel.value, value.level, problem.full_scale)) continue;
    const double residual = pixel.value - value.level;
    const bool is_inside = value.share > 0.5;
    (is_inside ? sum_inside : sum_outside) += residual * residual;
    ++(is_inside ? n_inside : n_outside);
  }
  // Half of the parameters each.
  const double used = 0.5 * problem.model.n_parameters();
  const auto sigma = [&](double sum, int n) {
    return std::max(kRounding, std::sqrt(sum / std::max(1.0, n - used)));
  };
  PixelNoise noise{sigma(sum_outside, n_outside), sigma(sum_inside, n_inside)};
  if (n_inside < kFewPixels) noise.inside = noise.outside;
  if (n_outside < kFewPixels) noise.outside = noise.inside;
  return noise;
}

}  // namespace panelcal::internal
