// SPDX-License-Identifier: Apache-2.0
#include "vision/template/solver.h"

#include <algorithm>
#include <cmath>

#include "vision/fit/minimiser.h"
#include "vision/fit/residual.h"
#include "vision/template/noise.h"
#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr int kMaxTemplateIterations = 30;
constexpr double kFinePx = 1e-5;

struct TemplateEquations {
  TemplateMatrix h = TemplateMatrix::Zero();
  TemplateVector g = TemplateVector::Zero();  ///< J^T W (data - model)
  double cost = 0;
  double n_pixels = 0;
};

/// Model from which the residuals are taken.
enum class Residual { Smooth, Raw };

TemplateEquations accumulate(const TemplateProblem& problem,
                             const TemplateVector& p,
                             double huber,
                             Residual kind) {
  const TemplateMap map(problem.model, p);
  TemplateEquations e;
  auto h = e.h.selfadjointView<Eigen::Lower>();
  for (const TemplatePixel& pixel : problem.window.pixels) {
    const auto value = evaluate(problem.model, problem.window, map, pixel, p, false);
    // A pixel that the pose has lost must not make the cost smaller: it keeps its noise.
    const double level = value ? value->smooth_level : 0;
    if (!value) {
      if (!pixel.is_excluded) e.cost += huber > 0 ? huber * huber : 1;
      continue;
    }
    if (!takes_part(pixel, level, problem.full_scale)) continue;
    const double residual = pixel.value - (kind == Residual::Raw ? value->level : level);
    const RobustTerm term(residual, pixel.weight, huber);
    e.cost += term.cost;
    h.rankUpdate(value->smooth_row, term.weight);
    e.g += term.weight * residual * value->smooth_row;
    ++e.n_pixels;
  }
  const TemplateVector prior = problem.prior.information();
  e.h.diagonal() += prior;
  e.g += problem.prior.pull(p);
  TemplateVector off = TemplateVector::Zero();
  off[kTurn] = problem.prior.turn - p[kTurn];
  off[kLogScale] = p[kLogScale];
  e.cost += prior.dot(off.cwiseAbs2());
  return e;
}

/// Mean contribution of the template's noise to J^T W (data - model), since rows and residuals
/// share it: -gain times the noise in the row times that in the template.
TemplateVector common_noise(const TemplateProblem& problem, const TemplateVector& p) {
  const TemplateModel& model = problem.model;
  const TemplateNoiseTable table;
  const TemplateMap map(model, p);
  TemplateVector sum = TemplateVector::Zero();
  for (const TemplatePixel& pixel : problem.window.pixels) {
    const auto value = evaluate(model, problem.window, map, pixel, p, false);
    if (!value || !takes_part(pixel, value->smooth_level, problem.full_scale)) continue;
    const auto& x = table(value->at.x());
    const auto& y = table(value->at.y());
    const double share = model.structure.at(static_cast<int>(value->at.x() + 0.5),
                                            static_cast<int>(value->at.y() + 0.5));
    const double variance = share * model.noise * model.noise;
    const Eigen::Vector2d slope(x.raw_slope * y.raw_smooth, x.raw_smooth * y.raw_slope);
    TemplateVector row = TemplateVector::Zero();
    row.head<4>() = value->gain * (map.derivative(value->at).transpose() * slope);
    row.segment<3>(kGain) = x.raw_smooth * y.raw_smooth * pixel.plane;
    row[kFocus] = x.raw_curvature * y.raw_smooth + x.raw_smooth * y.raw_curvature;
    sum -= pixel.weight * value->gain * variance * row;
  }
  return sum;
}

/// The step of parameters `first` to `first + n`, the others held; zero if singular.
TemplateVector template_step(const TemplateEquations& e, int first, int n, double damping) {
  TemplateVector step = TemplateVector::Zero();
  step.segment(first, n) = damped_solution<kTemplateParameters>(
      e.h.block(first, first, n, n), e.g.segment(first, n), damping);
  return step;
}

/// The largest move of any place of the template, in units of the fit frame.
double template_move(const TemplateProblem& problem,
                     const TemplateVector& p,
                     const TemplateVector& step) {
  const double reach = problem.window.unit + (problem.window.middle - p.head<2>()).norm();
  return step.head<2>().norm() + reach * (std::abs(step[kTurn]) + std::abs(step[kLogScale]));
}

/// The smooth template's problem, with some of the parameters free.
class SmoothProblem {
 public:
  using State = TemplateVector;
  using Equations = TemplateEquations;

  SmoothProblem(const TemplateProblem& problem, int n, double huber, double tolerance_px)
      : problem_(problem), n_(n), huber_(huber), tolerance_px_(tolerance_px) {}

  TemplateEquations equations_at(const TemplateVector& p) const {
    return accumulate(problem_, p, huber_, Residual::Smooth);
  }
  std::optional<MinimiserStep<TemplateVector>> step(const TemplateVector& p,
                                                    const TemplateEquations& e,
                                                    double damping) const {
    // No step may leave the part of the cost that knows where the minimum is.
    const double limit = 2.0 * (1 << problem_.window.level);
    TemplateVector step = template_step(e, 0, n_, damping);
    const double move = template_move(problem_, p, step);
    if (move > limit) step.head<kPoseParameters>() *= limit / move;
    return MinimiserStep<TemplateVector>{p + step, move / tolerance_px_};
  }

 private:
  const TemplateProblem& problem_;
  int n_;
  double huber_;
  double tolerance_px_;
};

}  // namespace

bool takes_part(const TemplatePixel& pixel, double level, double full_scale) {
  return !pixel.is_excluded && !is_beyond_scale(pixel.value, level, full_scale);
}

void solve_levels(const TemplateProblem& problem, TemplateVector& p) {
  p.tail<kTemplateParameters - kLinearStart>().setZero();
  // Clipping is judged by the model, which is not there yet: two rounds.
  for (int round = 0; round < 2; ++round) {
    const TemplateEquations e = accumulate(problem, p, 0, Residual::Smooth);
    p += template_step(e, kLinearStart, kGain + 1 - kLinearStart, 0);
  }
}

bool minimise(
    const TemplateProblem& problem, int n, double huber, double tolerance_px, TemplateVector& p) {
  SmoothProblem smooth(problem, n, huber, tolerance_px);
  const auto minimum = minimised(smooth, p, {.max_iterations = kMaxTemplateIterations});
  p = minimum.state;
  return minimum.converged;
}

bool solve_with_smooth_rows(const TemplateProblem& problem, TemplateVector& p) {
  // It is found from tables, hence not quite continuous: held, so that the steps can come to rest.
  constexpr int kHeldFrom = 3;
  const TemplateVector start = p;
  TemplateVector common = TemplateVector::Zero();
  for (int i = 0; i < kMaxTemplateIterations; ++i) {
    if (i < kHeldFrom) common = common_noise(problem, p);
    TemplateEquations e = accumulate(problem, p, 0, Residual::Raw);
    e.g -= common;
    const TemplateVector step = template_step(e, 0, kTemplateParameters, 0);
    const double move = template_move(problem, p, step);
    if (move > 2 || !(e.n_pixels > int(kTemplateParameters))) return false;
    p += step;
    if (move < kFinePx) return template_move(problem, start, p - start) < 2;
  }
  return false;
}

}  // namespace panelcal::internal
