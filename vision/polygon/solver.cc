// SPDX-License-Identifier: Apache-2.0
#include "vision/polygon/solver.h"

#include <algorithm>
#include <cmath>

#include "vision/fit/minimiser.h"
#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

constexpr int kMaxPolygonIterations = 20;  // a pattern takes 3 to 6; more means that there is none
/// Cost differences below this part are rounding.
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

struct CellEquations {
  CellMatrix h = CellMatrix::Zero();
  CellVector g = CellVector::Zero();
  double cost = 0;
};

bool is_saturated(double value, double full_scale) {
  return value >= full_scale || value <= 0;
}

/// The problem as the iterations see it.
class CellProblem {
 public:
  using State = CellState;
  using Equations = CellEquations;

  CellProblem(const CellModel& model,
              const std::vector<CellPixel>& pixels,
              const CellState& start,
              const CellSolverOptions& options)
      : model_(model), options_(options), half_(half_extent(model.pattern())) {
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

  CellEquations equations_at(const CellState& state) const {
    const int n = model_.n_parameters();
    CellEquations equations;
    CellVector gradient;
    CellView view(model_, state);
    equations.cost = flat_.cost(state.levels);
    for (const CellPixel* pixel : near_) {
      const auto value = view.evaluate(*pixel, &gradient);
      if (is_beyond_scale(pixel->value, value.level, options_.full_scale)) continue;
      const double residual = value.level - pixel->value;
      const RobustTerm term(residual, pixel->weight, options_.huber);
      equations.cost += term.cost;
      for (int i = 0; i < n; ++i) {
        const double wi = term.weight * gradient[i];
        equations.g[i] += wi * residual;
        for (int k = 0; k <= i; ++k) equations.h(i, k) += wi * gradient[k];
      }
    }
    equations.h.triangularView<Eigen::StrictlyUpper>() = equations.h.transpose();
    const int i = model_.i_levels();
    equations.h.block<6, 6>(i, i) += flat_.h;
    equations.g.segment<6>(i) += flat_.h * state.levels - flat_.b;
    return equations;
  }

  std::optional<MinimiserStep<CellState>> step(const CellState& state,
                                               const CellEquations& equations,
                                               double damping) const {
    const CellVector step = limited(state, step_within(state, equations, damping));
    const CellState next = model_.moved(state, step);
    if (!next.pattern_from_frame.allFinite() || !next.levels.allFinite()) return std::nullopt;
    const double units_per_px =
        std::sqrt(std::abs(state.jacobian(state.to_frame({0, 0})).determinant()));
    const double move_px = std::max(move_of(step) / units_per_px, std::abs(step[model_.i_sigma()]));
    return MinimiserStep<CellState>{next, move_px / options_.tolerance_px};
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

  /// The damped step, or zero if the equations are singular.
  CellVector damped_step(const CellEquations& equations, double damping) const {
    const int n = model_.n_parameters();
    CellVector step = CellVector::Zero();
    step.head(n) = -damped_solution<kMaxCellParameters>(
        equations.h.topLeftCorner(n, n), equations.g.head(n), damping);
    return step;
  }

  /// The damped step; where it would take a sigma at its limit beyond, the one that leaves it
  /// there. To cut only the sigma's part would leave the others with a step that belongs to it.
  CellVector step_within(const CellState& state,
                         const CellEquations& equations,
                         double damping) const {
    const int i = model_.i_sigma();
    const CellVector step = damped_step(equations, damping);
    const bool is_beyond = (state.sigma_px <= kMinPolygonSigma && step[i] < 0) ||
                           (state.sigma_px >= options_.max_sigma_px && step[i] > 0);
    if (!is_beyond) return step;
    CellEquations held = equations;
    held.h.row(i).setZero();
    held.h.col(i).setZero();
    held.h(i, i) = 1;
    held.g[i] = 0;
    return damped_step(held, damping);
  }

  /// Greatest move of the pattern's rim by a step, pattern units.
  double move_of(const CellVector& step) const {
    double move = std::max(std::abs(step[0]), std::abs(step[1]));
    for (int k = 2; k < model_.n_pose(); ++k) {
      move = std::max(move, std::abs(step[k]) * (k < 6 ? half_ : half_ * half_));
    }
    if (const auto i = model_.i_growth()) move = std::max(move, std::abs(step[*i]));
    return move;
  }

  /// The step with moves kept small and sigma kept where the model means something.
  CellVector limited(const CellState& state, CellVector step) const {
    const double move = move_of(step);
    // Only the geometry: levels enter linearly and follow at once.
    if (const double limit = kMaxStep * half_; move > limit) {
      step.head(model_.n_pose()) *= limit / move;
      if (const auto i = model_.i_growth()) step[*i] *= limit / move;
    }
    const double s = state.sigma_px;
    double& ds = step[model_.i_sigma()];
    ds = std::clamp(std::clamp(ds, -0.5 * s, s) + s, kMinPolygonSigma, options_.max_sigma_px) - s;
    return step;
  }

  const CellModel& model_;
  const CellSolverOptions& options_;
  double half_;  ///< extent of the pattern
  std::vector<const CellPixel*> near_;
  FlatSums flat_;
};

}  // namespace

double half_extent(const CellPattern& pattern) {
  return 0.5 * std::max(pattern.x.back() - pattern.x.front(), pattern.y.back() - pattern.y.front());
}

CellSolution solve_cells(const CellModel& model,
                         const std::vector<CellPixel>& pixels,
                         CellState start,
                         const CellSolverOptions& options) {
  CellProblem problem(model, pixels, start, options);
  start.sigma_px = std::clamp(start.sigma_px, kMinPolygonSigma, options.max_sigma_px);
  const auto minimum =
      minimised(problem, std::move(start), {.max_iterations = kMaxPolygonIterations});
  CellSolution solution{minimum.state, CellMatrix::Zero(), minimum.converged};
  const int n = model.n_parameters();
  solution.information.topLeftCorner(n, n) = minimum.equations.h.topLeftCorner(n, n);
  return solution;
}

}  // namespace panelcal::internal
