// SPDX-License-Identifier: Apache-2.0
#include "vision/polygon/solver.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

constexpr int kMaxPolygonIterations = 20;  // a pattern takes 3 to 6; more means that there is none
/// Cost differences below this part are rounding.
constexpr double kPolygonCostRounding = 1e-10;
constexpr double kMinPolygonSigma = 0.32;  // a pixel behind a perfect lens has 0.29
/// Largest step of a place on the pattern's rim, as part of its half extent.
constexpr double kMaxStep = 0.15;

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// All flat pixels together: their squares' sum is a parabola in the levels.
struct FlatSums {
  Matrix6d h = Matrix6d::Zero();
  Levels b = Levels::Zero();
  double c = 0;

  double cost(const Levels& levels) const { return levels.dot(h * levels) - 2 * b.dot(levels) + c; }
};

struct NormalEquations {
  CellMatrix h = CellMatrix::Zero();
  CellVector g = CellVector::Zero();
  double cost = 0;
  int n_pixels = 0;
};

bool is_saturated(double value, double full_scale) {
  return value >= full_scale || value <= 0;
}

/// The problem as the iterations see it.
class CellProblem {
 public:
  CellProblem(const CellModel& model,
              const std::vector<CellPixel>& pixels,
              const CellState& start,
              const CellSolverOptions& options)
      : model_(model), options_(options) {
    CellView view(model, start);
    near_.reserve(pixels.size());
    const CellPattern& pattern = model.pattern();
    const bool has_unknown =
        pattern.outside == Cell::Unknown ||
        std::find(pattern.cells.begin(), pattern.cells.end(), Cell::Unknown) != pattern.cells.end();
    for (const CellPixel& pixel : pixels) {
      if (pixel.is_excluded) continue;
      // The state decides whether a clipped pixel counts.
      if (pixel.is_flat && !is_saturated(pixel.value, options.full_scale)) {
        add_flat(pixel);
      } else if (!has_unknown || view.evaluate(pixel, nullptr).is_known) {
        // The same pixels to the end: coming and going, they would make the cost jump.
        near_.push_back(&pixel);
      }
    }
    flat_.h.triangularView<Eigen::StrictlyUpper>() = flat_.h.transpose();
  }

  NormalEquations equations_at(const CellState& state) const {
    NormalEquations equations;
    equations.cost = sum(state, &equations);
    return equations;
  }

 private:
  void add_flat(const CellPixel& pixel) {
    const Eigen::Vector3d plane = model_.plane_terms(pixel.at);
    Levels terms;
    terms << plane, pixel.share * plane;
    for (int i = 0; i < 6; ++i) {
      const double wi = pixel.weight * terms[i];
      for (int k = 0; k <= i; ++k) flat_.h(i, k) += wi * terms[k];
      flat_.b[i] += wi * pixel.value;
    }
    flat_.c += pixel.weight * pixel.value * pixel.value;
  }

  double sum(const CellState& state, NormalEquations* equations) const {
    const int n = model_.n_parameters();
    CellVector gradient;
    CellView view(model_, state);
    double cost = flat_.cost(state.levels);
    for (const CellPixel* pixel : near_) {
      const auto value = view.evaluate(*pixel, equations ? &gradient : nullptr);
      if (is_beyond_scale(pixel->value, value.level, options_.full_scale)) continue;
      const double residual = value.level - pixel->value;
      double weight = pixel->weight;
      const double z = std::abs(residual) * std::sqrt(weight);
      const bool is_far = options_.huber > 0 && z > options_.huber;
      cost += is_far ? options_.huber * (2 * z - options_.huber) : z * z;
      if (!equations) continue;
      if (is_far) weight *= options_.huber / z;
      ++equations->n_pixels;
      for (int i = 0; i < n; ++i) {
        const double wi = weight * gradient[i];
        equations->g[i] += wi * residual;
        for (int k = 0; k <= i; ++k) equations->h(i, k) += wi * gradient[k];
      }
    }
    if (equations) {
      equations->h.triangularView<Eigen::StrictlyUpper>() = equations->h.transpose();
      const int i = model_.i_levels();
      equations->h.block<6, 6>(i, i) += flat_.h;
      equations->g.segment<6>(i) += flat_.h * state.levels - flat_.b;
    }
    return cost;
  }

  const CellModel& model_;
  const CellSolverOptions& options_;
  std::vector<const CellPixel*> near_;
  FlatSums flat_;
};

using PolygonDynamic = Eigen::Matrix<double,
                                     Eigen::Dynamic,
                                     Eigen::Dynamic,
                                     Eigen::ColMajor,
                                     kMaxCellParameters,
                                     kMaxCellParameters>;

/// The damped step, or zero if the equations are singular.
CellVector damped_step(const NormalEquations& equations, int n, double damping) {
  PolygonDynamic h = equations.h.topLeftCorner(n, n);
  for (int i = 0; i < n; ++i) h(i, i) += damping * h(i, i) + 1e-12;
  CellVector step = CellVector::Zero();
  const Eigen::LDLT<PolygonDynamic> factor(h);
  if (factor.info() == Eigen::Success && factor.isPositive()) {
    step.head(n) = -factor.solve(equations.g.head(n));
  }
  if (!step.allFinite()) step.setZero();
  return step;
}

/// The damped step; where it would take a sigma at its limit beyond, the one that leaves it there.
/// To cut only the sigma's part would leave the others with a step that belongs to it.
CellVector step_within(const CellModel& model,
                       const CellState& state,
                       const NormalEquations& equations,
                       double damping,
                       double max_sigma_px) {
  const int n = model.n_parameters();
  const int i = model.i_sigma();
  const CellVector step = damped_step(equations, n, damping);
  const bool is_beyond = (state.sigma_px <= kMinPolygonSigma && step[i] < 0) ||
                         (state.sigma_px >= max_sigma_px && step[i] > 0);
  if (!is_beyond) return step;
  NormalEquations held = equations;
  held.h.row(i).setZero();
  held.h.col(i).setZero();
  held.h(i, i) = 1;
  held.g[i] = 0;
  return damped_step(held, n, damping);
}

/// Greatest move of the pattern's rim by a step, pattern units.
double polygon_move(const CellModel& model, const CellVector& step, double half) {
  double move = std::max(std::abs(step[0]), std::abs(step[1]));
  for (int k = 2; k < model.n_pose(); ++k) {
    move = std::max(move, std::abs(step[k]) * (k < 6 ? half : half * half));
  }
  if (const auto i = model.i_growth()) move = std::max(move, std::abs(step[*i]));
  return move;
}

/// The step with moves kept small and sigma kept where the model means something.
CellVector limited(const CellModel& model,
                   const CellState& state,
                   CellVector step,
                   double half,
                   double max_sigma_px) {
  const double move = polygon_move(model, step, half);
  // Only the geometry: levels enter linearly and follow at once.
  if (const double limit = kMaxStep * half; move > limit) {
    step.head(model.n_pose()) *= limit / move;
    if (const auto i = model.i_growth()) step[*i] *= limit / move;
  }
  const double s = state.sigma_px;
  double& ds = step[model.i_sigma()];
  ds = std::clamp(std::clamp(ds, -0.5 * s, s) + s, kMinPolygonSigma, max_sigma_px) - s;
  return step;
}

}  // namespace

double half_extent(const CellPattern& pattern) {
  return 0.5 * std::max(pattern.x.back() - pattern.x.front(), pattern.y.back() - pattern.y.front());
}

CellSolution solve_cells(const CellModel& model,
                         const std::vector<CellPixel>& pixels,
                         const CellState& start,
                         const CellSolverOptions& options) {
  const int n = model.n_parameters();
  const double half = half_extent(model.pattern());
  const CellProblem problem(model, pixels, start, options);
  CellSolution solution;
  solution.state = start;
  solution.state.sigma_px = std::clamp(start.sigma_px, kMinPolygonSigma, options.max_sigma_px);
  NormalEquations equations = problem.equations_at(solution.state);
  double damping = 1e-4;
  for (int i = 0; i < kMaxPolygonIterations && !solution.converged && damping < 1e8; ++i) {
    const CellVector free =
        step_within(model, solution.state, equations, damping, options.max_sigma_px);
    const CellVector step = limited(model, solution.state, free, half, options.max_sigma_px);
    const CellState next = model.moved(solution.state, step);
    if (!next.pattern_from_frame.allFinite() || !next.levels.allFinite()) break;
    const double units_per_px =
        std::sqrt(std::abs(solution.state.jacobian(solution.state.to_frame({0, 0})).determinant()));
    const bool is_small = polygon_move(model, step, half) < options.tolerance_px * units_per_px &&
                          std::abs(step[model.i_sigma()]) < options.tolerance_px;
    if (is_small && damping < 1) {
      // The error after a small step is a few hundredths of it: not worth another look.
      solution.converged = true;
      solution.state = next;
      break;
    }
    NormalEquations next_equations = problem.equations_at(next);
    if (next_equations.cost <= equations.cost * (1 + kPolygonCostRounding)) {
      solution.state = next;
      equations = next_equations;
      damping = std::max(1e-9, damping * 0.1);
    } else {
      damping = std::max(1e-3, damping * 10);
    }
  }
  solution.cost = equations.cost;
  solution.information.topLeftCorner(n, n) = equations.h.topLeftCorner(n, n);
  solution.n_pixels = equations.n_pixels;
  return solution;
}

}  // namespace panelcal::internal
