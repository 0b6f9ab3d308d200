// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "calib/panel/fit.h"
#include "calib/panel/model_score.h"
#include "calib/panel/smooth_panel.h"

namespace panelcal {

/// Use of smooth models: a series may get one, or only a line in the report.
enum class SmoothModels : std::uint8_t { Compared, Eligible };

namespace internal {

std::vector<ModelScore> compare_raw(std::span<const RawPair> pairs,
                                    PanelModel usual,
                                    SmoothModels smooth = SmoothModels::Compared);

/// Root mean square over targets, mm, of the distance to where a fit to the others puts them; of a
/// slot in the coordinate it shows. Linear models by the leverage of each target,
///
///   m_i - fit_without_i(p_i) = (I - H_ii)^-1 (m_i - fit(p_i)),   H_ii = d fit(p_i) / d m_i
///
/// exactly; rigid and stretch by fitting anew, for many targets by leverage too, to first order.
/// Empty where the others of some target do not determine the model.
std::optional<double> left_out_rms_mm(std::span<const RawPair> pairs,
                                      PanelModel model,
                                      const RawFit& fit);

/// Of an affine model that was chosen, from the other affine ones; their weights are among all.
Eigen::Matrix<double, 6, 6> choice_covariance(std::span<const RawPair> pairs,
                                              std::span<const ModelScore> scores);

/// The chosen model with the covariance that counts how it differs from the others, where a smooth
/// one has a part in that: it is chosen, or it has more than kNoWeight.
std::optional<RawSmooth> smooth_choice(std::span<const RawPair> pairs,
                                       std::span<const ModelScore> scores);

/// A weight among models that is not worth a covariance for every hole.
inline constexpr double kNoWeight = 0.01;

}  // namespace internal

/// Advantage in Akaike's criterion that a model needs over a stiffer one.
inline constexpr double kWorthASofterModel = 2;

/// Compares all models that the targets determine, from stiff to soft, and marks one as chosen.
///
///   criterion = chi square + 2 parameters
///
/// The targets' covariances are known, not estimated from the residuals. Then this is, but for a
/// constant, Akaike's criterion and Mallows' Cp at once, and an unbiased estimate of how badly the
/// fit predicts the same targets when they are measured again; there is no small-sample correction
/// to make (that of AICc is for an estimated variance). Schwarz's BIC, which pays log(equations)
/// instead of 2, asks which model is true. Panels have no true model, they have holes, and for
/// predicting AIC is the efficient one (Shibata 1981).
///
/// Chosen is the stiffest model whose criterion is within kWorthASofterModel of the least: such a
/// difference is no evidence (Burnham and Anderson 2002, 2.6). A model that leave-one-out cannot
/// examine is not chosen, for nothing stands behind its residuals; but for the manual's own model.
/// A smooth model (calib/panel/smooth_panel.h) may be chosen where it is Eligible, and then only if
/// it also predicts left-out targets better than any other: a single wrong target bends a spline,
/// but does not help it to predict. Where it is only Compared see recommended_smooth.
///
/// In     pairs as for fit_panel; usual: what the manual prescribes for them
/// Out    one score each, at most one chosen; empty if not even an offset is determined
/// Cost   O(n) per model, O(n^2) up to 64 targets, and O(n^3) for smooth models
/// Source Akaike 1973; Mallows 1973; Burnham and Anderson 2002; docs/formulation.md
/// See    tests/calib/panel/model_choice_test.cc
template <class To, class From>
std::vector<ModelScore> compare_models(std::span<const TargetPair<To, From>> pairs,
                                       PanelModel usual,
                                       SmoothModels smooth = SmoothModels::Compared) {
  return internal::compare_raw(internal::raw_pairs(pairs), usual, smooth);
}

/// Fits the chosen model of `scores`, which are those of the same pairs, with the covariance that
/// an estimate has whose model was chosen by the data it is fitted to.
///
///   cov = cov_c + sum of w_m [(a_m - a_c)(a_m - a_c)^T + (cov_m - cov_c where m is softer)]
///
/// with w_m ~ exp(-criterion_m / 2) over the eligible m, c the chosen one and a the coefficients.
///
/// Ellipses of the chosen model alone would forget that it might be another: of 95 % they hold as
/// little as 75 % (tests/bench/README.md). The added part is PanelFit::choice_cov. Where a smooth
/// model is eligible the sum differs from place to place, so it is in PanelFit::smooth instead,
/// also of a panel that is taken for straight.
///
/// Source Burnham and Anderson 2002, 4.3 (unconditional variance)
template <class To, class From>
PanelFitResult<To, From> fit_chosen(std::span<const TargetPair<To, From>> pairs,
                                    std::span<const ModelScore> scores);

/// The chosen one; nullptr if there is none.
const ModelScore* chosen(std::span<const ModelScore> scores);

/// The smooth model if it is clearly better than the chosen one, by the criterion and by
/// leave-one-out; nullptr otherwise.
const ModelScore* recommended_smooth(std::span<const ModelScore> scores);

template <class To, class From>
PanelFitResult<To, From> fit_chosen(std::span<const TargetPair<To, From>> pairs,
                                    std::span<const ModelScore> scores) {
  const ModelScore* score = chosen(scores);
  if (score == nullptr) return {};
  PanelFitResult<To, From> result = fit_panel(pairs, score->model);
  if (!result.fit) return result;
  const auto raw = internal::raw_pairs(pairs);
  std::optional<internal::RawSmooth> smooth = internal::smooth_choice(raw, scores);
  if (score->is_smooth) {
    if (!smooth) return {};
    return with_bending(*std::move(result.fit), SmoothPanelFit<To, From>(*std::move(smooth)));
  }
  result.fit->choice_cov = internal::choice_covariance(raw, scores);
  result.fit->map.cov += result.fit->choice_cov;
  if (smooth) {
    result.fit->smooth = std::make_shared<const SmoothPanelFit<To, From>>(*std::move(smooth));
  }
  return result;
}

}  // namespace panelcal
