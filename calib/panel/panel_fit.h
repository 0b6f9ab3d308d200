// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/panel/fit.h"
#include "calib/panel/gates.h"
#include "calib/panel/misfit.h"
#include "calib/panel/model_choice.h"
#include "calib/panel/smooth_panel.h"
#include <Eigen/Core>

namespace panelcal {

/// Model and limits of a panel's fit.
struct PanelFitOptions {
  PanelModel model = PanelModel::Offset;  ///< as the manual or the machine's file prescribes
  bool chooses_model = false;             ///< instead, the model that the targets speak for
  bool compares_models = false;           ///< scores the models, and fits the prescribed one
  SmoothModels smooth = SmoothModels::Compared;
  bool bends = false;  ///< instead, a smooth model, whatever the targets speak for
  GateLimits limits;
};

struct Uncertain {
  double value = 0;
  double sigma = 0;  ///< one standard deviation, same unit
};

/// The outcome of a panel's fit, in the words of the trade.
///
/// The map is R(rotation) [scale_x, shear; 0, scale_y] about the targets' centroid plus a shift.
struct PanelFitSummary {
  PanelModel model = PanelModel::Offset;
  bool chose_model = false;           ///< `model` is what the targets speak for
  std::vector<ModelScore> compared;   ///< all models that the targets could determine
  std::optional<FitFailure> failure;  ///< the reason if there is no fit; below, the numbers of one
  std::vector<GateVerdict> gates;     ///< as the targets themselves show, without the misfit
  std::optional<double> smooth_parameters;  ///< effective number; set if the fit is a smooth one
  Uncertain rotation_rad;                   ///< counter-clockwise
  Uncertain stretch_x_ppm;                  ///< scale - 1
  Uncertain stretch_y_ppm;                  ///< |scale| - 1
  Uncertain shear_ppm;
  bool is_mirrored = false;
  Eigen::Vector2d centroid_mm = Eigen::Vector2d::Zero();  ///< of the targets, before the fit
  Uncertain shift_x_mm;                                   ///< of the centroid
  Uncertain shift_y_mm;
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();  ///< of a smooth fit the map nearest to it
  Eigen::Vector2d translation_mm = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 6, 6> cov = Eigen::Matrix<double, 6, 6>::Zero();
  std::vector<Eigen::Vector2d> residuals_mm;  ///< measured minus fitted
  double chi_square = 0;
  int degrees_of_freedom = 0;
  double misfit_ratio = 1;  ///< by which sigma has grown, since the targets do not agree

  bool is_smooth() const { return smooth_parameters.has_value(); }
  double worst_residual_um() const;
  /// "offset" to "affine", or "smooth, 9.4 effective parameters".
  std::string model_text() const;
  /// "turned +1.2 mrad, stretched +3 ppm in x and -1 ppm in y, worst residual 4 um"
  std::string brief() const;
  /// Lines, each with its end: brief(), which model is smooth, and if the targets chose it why, and
  /// whether a smooth one would predict better.
  ///
  /// In     subject: begins the lines, as "panel (line 12)"
  std::string full(std::string_view subject) const;
};

namespace internal {
/// A mirrored panel where none is meant, or one that is no panel.
bool is_wrong_way_round(const Eigen::Matrix2d& linear, const GateLimits& limits);
/// Rotation, stretch and shear of `linear`, with their sigmas by `cov`, to first order.
void put_deformation(PanelFitSummary& summary);
/// The same for the shift, of the centroid and where the map carries it.
void put_shift(const Eigen::Vector2d& moved_mm,
               const Eigen::Matrix2d& cov_mm2,
               PanelFitSummary& summary);
}  // namespace internal

template <class To, class From>
void put_numbers(const PanelFit<To, From>& fit, PanelFitSummary& summary) {
  if (fit.smooth && fit.smooth->is_bent()) summary.smooth_parameters = fit.smooth->parameters();
  summary.linear = fit.map.map.linear();
  summary.translation_mm = fit.map.map.translation();
  summary.cov = fit.map.cov;
  for (const auto& pair : fit.pairs) summary.centroid_mm += pair.nominal.in_mm();
  if (!fit.pairs.empty()) summary.centroid_mm /= static_cast<double>(fit.pairs.size());
  const PositionEstimate<To> moved = fit.map(position_mm<From>(summary.centroid_mm));
  internal::put_deformation(summary);
  internal::put_shift(moved.position.in_mm(), moved.cov, summary);
  for (const auto& residual : fit.residuals) summary.residuals_mm.push_back(residual.in_mm());
  summary.chi_square = fit.chi_square;
  summary.degrees_of_freedom = fit.degrees_of_freedom;
  summary.misfit_ratio =
      std::sqrt(1 + internal::misfit_excess(fit.chi_square, fit.degrees_of_freedom));
}

/// Fits a series of targets, holds the fit against its limits, and lets its covariance grow by what
/// the targets do not agree in.
///
/// Out    null if there is no fit that may correct anything: `summary` says why
/// Fails  as fit_panel() of one model; Mirrored; Folded
/// See    calib/panel/fit.h, model_choice.h, smooth_panel.h, gates.h, misfit.h: the steps
///        tests/calib/panel/panel_fit_test.cc
template <class To, class From>
std::shared_ptr<const PanelFit<To, From>> fit_panel(const PanelFitOptions& options,
                                                    std::span<const TargetPair<To, From>> pairs,
                                                    PanelFitSummary& summary) {
  summary = {.model = options.bends ? PanelModel::Affine : options.model};
  if (options.chooses_model || options.compares_models) {
    summary.compared = compare_models(pairs, options.model, options.smooth);
  }
  const bool chooses = options.chooses_model && !options.bends;
  const ModelScore* const best = chooses ? chosen(summary.compared) : nullptr;
  summary.chose_model = best != nullptr;
  if (best != nullptr) summary.model = best->model;
  PanelFitResult<To, From> result = options.bends     ? fit_bent(pairs)
                                    : best != nullptr ? fit_chosen(pairs, summary.compared)
                                                      : fit_panel(pairs, summary.model);
  if (!result.fit) {
    summary.failure = result.failure;
  } else if (internal::is_wrong_way_round(result.fit->map.map.linear(), options.limits)) {
    summary.failure = FitFailure::Mirrored;
  } else if (const auto& smooth = result.fit->smooth;
             smooth && smooth->is_bent() &&
             !internal::is_unfolded(smooth->raw(), internal::raw_pairs(pairs))) {
    summary.failure = FitFailure::Folded;
  }
  if (summary.failure) return nullptr;
  summary.gates = check_gates(*result.fit, options.limits);
  count_misfit(*result.fit);
  put_numbers(*result.fit, summary);
  return std::make_shared<const PanelFit<To, From>>(*std::move(result.fit));
}

}  // namespace panelcal
