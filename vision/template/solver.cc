// SPDX-License-Identifier: Apache-2.0
#include "vision/template/solver.h"

#include <algorithm>
#include <cmath>

#include "vision/template/noise.h"
#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

constexpr int kMaxTemplateIterations = 30;
constexpr double kTemplateCostRounding = 1e-10;
constexpr double kFinePx = 1e-5;

using TemplateDynamic = Eigen::Matrix<double,
                                      Eigen::Dynamic,
                                      Eigen::Dynamic,
                                      Eigen::ColMajor,
                                      kTemplateParameters,
                                      kTemplateParameters>;

struct TemplateEquations {
  TemplateMatrix h = TemplateMatrix::Zero();
  TemplateVector g = TemplateVector::Zero();  ///< J^T W (data - model)
  double cost = 0;
  double n_pixels = 0;
};

double huber_cost(double z, double huber) {
  return huber > 0 && z > huber ? huber * (2 * z - huber) : z * z;
}

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
    double weight = pixel.weight;
    const double z = std::abs(residual) * std::sqrt(weight);
    e.cost += huber_cost(z, huber);
    if (huber > 0 && z > huber) weight *= huber / z;
    h.rankUpdate(value->smooth_row, weight);
    e.g += weight * residual * value->smooth_row;
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
  TemplateDynamic h = e.h.block(first, first, n, n);
  for (int i = 0; i < n; ++i) h(i, i) += damping * h(i, i) + 1e-12;
  TemplateVector step = TemplateVector::Zero();
  const Eigen::LDLT<TemplateDynamic> factor(h.selfadjointView<Eigen::Lower>());
  if (factor.info() == Eigen::Success && factor.isPositive()) {
    step.segment(first, n) = factor.solve(e.g.segment(first, n));
  }
  if (!step.allFinite()) step.setZero();
  return step;
}

/// The largest move of any place of the template, in units of the fit frame.
double template_move(const TemplateProblem& problem,
                     const TemplateVector& p,
                     const TemplateVector& step) {
  const double reach = problem.window.unit + (problem.window.middle - p.head<2>()).norm();
  return step.head<2>().norm() + reach * (std::abs(step[kTurn]) + std::abs(step[kLogScale]));
}

}  // namespace

bool takes_part(const TemplatePixel& pixel, double level, double full_scale) {
  if (pixel.is_excluded) return false;
  return !(pixel.value >= full_scale && level >= full_scale) && !(pixel.value <= 0 && level <= 0);
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
  // No step may leave the part of the cost that knows where the minimum is.
  const double limit = 2.0 * (1 << problem.window.level);
  double damping = 1e-4;
  TemplateEquations e = accumulate(problem, p, huber, Residual::Smooth);
  for (int i = 0; i < kMaxTemplateIterations && damping < 1e8; ++i) {
    TemplateVector step = template_step(e, 0, n, damping);
    const double move = template_move(problem, p, step);
    if (move > limit) step.head<kPoseParameters>() *= limit / move;
    const TemplateVector next = p + step;
    const TemplateEquations e_next = accumulate(problem, next, huber, Residual::Smooth);
    const bool is_small = move < tolerance_px;
    if (e_next.cost <= e.cost * (1 + kTemplateCostRounding)) {
      p = next;
      e = e_next;
      damping = std::max(1e-9, damping * 0.1);
    } else {
      damping = std::max(1e-3, damping * 10);
    }
    if (is_small) return true;
  }
  return false;
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
