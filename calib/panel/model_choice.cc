// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/model_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "calib/panel/model.h"
#include "calib/panel/smooth_panel.h"
#include "calib/panel/system.h"
#include <Eigen/LU>

namespace panelcal {
namespace internal {
namespace {

constexpr std::array kPanelStiffToSoft = {PanelModel::Offset,
                                          PanelModel::Rigid,
                                          PanelModel::Similarity,
                                          PanelModel::Stretch,
                                          PanelModel::Affine};

/// Fitting anew without each target costs the square of their number; above this many a single one
/// hardly moves the others, and leverage is as good.
constexpr std::size_t kMostRefits = 64;

/// 1 - leverage of a target without which the others leave the model open. Rounding leaves some
/// 1e-15; targets that are nearly in one line, by the ratio that fits accept, 1e-12.
constexpr double kNoModelResidual = 1e-10;

/// Sum of squares, or empty.
std::optional<double> by_refit(std::span<const RawPair> pairs, PanelModel model) {
  double sum_mm2 = 0;
  std::vector<RawPair> others(pairs.begin() + 1, pairs.end());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    // `others` are all but the i-th, in some order.
    if (i > 0) others[i - 1] = pairs[i - 1];
    const RawFitResult without = fit_raw(others, model);
    if (!without.fit) return std::nullopt;
    const Eigen::Vector2d expected_mm =
        without.fit->linear * pairs[i].from_mm + without.fit->translation_mm;
    sum_mm2 += observed_part(pairs[i].to_mm - expected_mm, pairs[i].axes).squaredNorm();
  }
  return sum_mm2;
}

std::optional<double> by_leverage(std::span<const RawPair> pairs, const RawFit& fit) {
  double sum_mm2 = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    // The gain of what a slot does not show is 0, so its other coordinate stays out.
    const Eigen::Matrix2d leverage =
        design(pairs[i].from_mm) * fit.gain.middleCols<2>(2 * static_cast<Eigen::Index>(i));
    Eigen::Matrix2d left = Eigen::Matrix2d::Identity() - leverage;
    if (!observes_x(pairs[i].axes)) left.row(0) << 1, 0;
    if (!observes_y(pairs[i].axes)) left.row(1) << 0, 1;
    // Eigenvalues of a leverage are those of a symmetric matrix, from 0 to 1.
    if (!(left.determinant() > kNoModelResidual)) return std::nullopt;
    sum_mm2 += (left.inverse() * fit.residuals_mm[i]).squaredNorm();
  }
  return sum_mm2;
}

/// Infinite if there is none.
double least_criterion(std::span<const ModelScore> scores) {
  double least = std::numeric_limits<double>::infinity();
  for (const ModelScore& score : scores) {
    if (score.is_eligible) least = std::min(least, score.criterion);
  }
  return least;
}

/// Akaike's, of those that are not eligible 0.
std::vector<double> weights_of(std::span<const ModelScore> scores) {
  const double least = least_criterion(scores);
  std::vector<double> weights;
  double sum = 0;
  for (const ModelScore& score : scores) {
    weights.push_back(score.is_eligible ? std::exp(-0.5 * (score.criterion - least)) : 0);
    sum += weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// Marks the stiffest of those that may be chosen and are as good as the best.
void choose(std::span<ModelScore> scores) {
  const double bound = least_criterion(scores) + kWorthASofterModel;
  for (ModelScore& score : scores) {
    score.is_chosen = score.is_eligible && score.criterion <= bound;
    if (score.is_chosen) return;
  }
}

bool foretells_best(const ModelScore& score, std::span<const ModelScore> others) {
  return score.left_out_mm && std::ranges::all_of(others, [&score](const ModelScore& other) {
           return !other.left_out_mm || *score.left_out_mm < *other.left_out_mm;
         });
}

/// d weights of the basis (1, x, y; x and y by turns) / d [l00 l01 l10 l11 tx ty].
Eigen::Matrix<double, 6, 6> weights_by_coefficients(const RawSmooth& smooth) {
  const double s = smooth.scale_mm;
  const Eigen::Vector2d c = smooth.center_mm;
  Eigen::Matrix<double, 6, 6> m;
  m << c.x(), c.y(), 0, 0, 1, 0,  //
      0, 0, c.x(), c.y(), 0, 1,   //
      s, 0, 0, 0, 0, 0,           //
      0, 0, s, 0, 0, 0,           //
      0, s, 0, 0, 0, 0,           //
      0, 0, 0, s, 0, 0;
  return m;
}

/// w d d^T of a difference of two maps.
CovarianceForm squared(const Eigen::Matrix2Xd& weights, double w) {
  const Eigen::MatrixXd xy = w * weights.row(0).transpose() * weights.row(1);
  return {w * weights.row(0).transpose() * weights.row(0),
          0.5 * (xy + xy.transpose()),
          w * weights.row(1).transpose() * weights.row(1)};
}

CovarianceForm scaled(const CovarianceForm& form, double factor) {
  return {factor * form.xx, factor * form.xy, factor * form.yy};
}

/// Of the coefficients of an affine map.
CovarianceForm affine_form(const RawSmooth& smooth, const Eigen::Matrix<double, 6, 6>& cov) {
  const Eigen::Index n = smooth.by_measured.rows();
  const Eigen::Matrix<double, 6, 6> m = weights_by_coefficients(smooth);
  Eigen::MatrixXd of_weights = Eigen::MatrixXd::Zero(n, n);
  of_weights.bottomRightCorner<6, 6>() = m * cov * m.transpose();
  return CovarianceForm::of_weights(of_weights);
}

/// A bent fit with what the stiffer models say against it.
void count_stiffer(std::span<const RawPair> pairs,
                   std::span<const ModelScore> scores,
                   RawSmooth& smooth) {
  const std::vector<double> weights = weights_of(scores);
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (scores[i].is_smooth || !(weights[i] > 0)) continue;
    const RawFitResult other = fit_raw(pairs, scores[i].model);
    if (!other.fit) continue;
    smooth.choice +=
        squared(smooth.weights_of(other.fit->linear, other.fit->translation_mm) - smooth.weights,
                weights[i]);
  }
  smooth.cov += smooth.choice;
}

/// A straight fit with what the bent one says against it.
void count_bending(std::span<const RawPair> pairs,
                   std::span<const ModelScore> scores,
                   const RawFit& straight,
                   double weight,
                   RawSmooth& smooth) {
  const Eigen::Matrix2Xd weights = smooth.weights_of(straight.linear, straight.translation_mm);
  const CovarianceForm alone = affine_form(smooth, straight.cov);
  smooth.choice = affine_form(smooth, choice_covariance(pairs, scores));
  smooth.choice += squared(weights - smooth.weights, weight);
  smooth.choice += scaled(smooth.cov, weight);
  smooth.choice += scaled(alone, -weight);
  smooth.cov = alone;
  smooth.cov += smooth.choice;
  smooth.weights = weights;
  smooth.by_measured.setZero();
  smooth.by_measured.bottomRows<6>() = weights_by_coefficients(smooth) * straight.gain;
  smooth.is_bent = false;
}

Coefficients coefficients_of(const RawFit& fit) {
  Coefficients a;
  a << fit.linear(0, 0), fit.linear(0, 1), fit.linear(1, 0), fit.linear(1, 1), fit.translation_mm;
  return a;
}

}  // namespace

std::optional<double> left_out_rms_mm(std::span<const RawPair> pairs,
                                      PanelModel model,
                                      const RawFit& fit) {
  const bool is_exact = is_linear(model);
  if (pairs.size() < 2) return std::nullopt;
  const std::optional<double> sum_mm2 =
      is_exact || pairs.size() > kMostRefits ? by_leverage(pairs, fit) : by_refit(pairs, model);
  if (!sum_mm2) return std::nullopt;
  return std::sqrt(*sum_mm2 / static_cast<double>(pairs.size()));
}

std::vector<ModelScore> compare_raw(std::span<const RawPair> pairs,
                                    PanelModel usual,
                                    SmoothModels smooth_models) {
  std::vector<ModelScore> scores;
  for (const PanelModel model : kPanelStiffToSoft) {
    const RawFitResult result = fit_raw(pairs, model);
    if (!result.fit) continue;
    ModelScore score;
    score.model = model;
    score.parameters = parameter_count(model);
    score.chi_square = result.fit->chi_square;
    score.criterion = score.chi_square + 2 * score.parameters;
    score.left_out_mm = left_out_rms_mm(pairs, model, *result.fit);
    score.is_eligible = score.left_out_mm.has_value() || model == usual;
    scores.push_back(score);
  }
  if (const std::optional<RawSmooth> smooth = fit_smooth_raw(pairs)) {
    ModelScore score{.model = PanelModel::Affine, .is_smooth = true, .left_out_mm = {}};
    score.parameters = smooth->parameters;
    score.chi_square = smooth->chi_square;
    score.criterion = smooth->criterion();
    score.left_out_mm = smooth->left_out_rms_mm;
    score.is_eligible = smooth_models == SmoothModels::Eligible && foretells_best(score, scores);
    scores.push_back(score);
  }
  choose(scores);
  return scores;
}

Eigen::Matrix<double, 6, 6> choice_covariance(std::span<const RawPair> pairs,
                                              std::span<const ModelScore> scores) {
  Eigen::Matrix<double, 6, 6> sum = Eigen::Matrix<double, 6, 6>::Zero();
  const ModelScore* best = chosen(scores);
  if (best == nullptr) return sum;
  const RawFitResult center = fit_raw(pairs, best->model);
  if (!center.fit) return sum;
  const std::vector<double> weights = weights_of(scores);
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const ModelScore& score = scores[i];
    if (!score.is_eligible || score.is_smooth || score.is_chosen) continue;
    const RawFitResult other = fit_raw(pairs, score.model);
    if (!other.fit) continue;
    const Coefficients away = coefficients_of(*other.fit) - coefficients_of(*center.fit);
    sum += weights[i] * away * away.transpose();
    if (score.model > best->model) sum += weights[i] * (other.fit->cov - center.fit->cov);
  }
  return sum;
}

std::optional<RawSmooth> smooth_choice(std::span<const RawPair> pairs,
                                       std::span<const ModelScore> scores) {
  const auto found = std::ranges::find_if(scores, &ModelScore::is_smooth);
  const ModelScore* best = chosen(scores);
  if (found == scores.end() || best == nullptr || !found->is_eligible) return std::nullopt;
  const double weight =
      weights_of(scores)[static_cast<std::size_t>(std::distance(scores.begin(), found))];
  if (!found->is_chosen && weight < kNoWeight) return std::nullopt;
  std::optional<RawSmooth> smooth = fit_smooth_raw(pairs);
  if (!smooth) return std::nullopt;
  if (found->is_chosen) {
    count_stiffer(pairs, scores, *smooth);
    return smooth;
  }
  const RawFitResult straight = fit_raw(pairs, best->model);
  if (!straight.fit) return std::nullopt;
  count_bending(pairs, scores, *straight.fit, weight, *smooth);
  return smooth;
}

}  // namespace internal

std::string_view name(const ModelScore& score) {
  return score.is_smooth ? "smooth" : name(score.model);
}

const ModelScore* chosen(std::span<const ModelScore> scores) {
  const auto found = std::ranges::find_if(scores, &ModelScore::is_chosen);
  return found == scores.end() ? nullptr : &*found;
}

const ModelScore* recommended_smooth(std::span<const ModelScore> scores) {
  const ModelScore* best = chosen(scores);
  const auto smooth = std::ranges::find_if(scores, &ModelScore::is_smooth);
  if (best == nullptr || smooth == scores.end()) return nullptr;
  const bool explains = smooth->criterion < best->criterion - kWorthASofterModel;
  const bool predicts =
      smooth->left_out_mm && best->left_out_mm && *smooth->left_out_mm < *best->left_out_mm;
  return explains && predicts ? &*smooth : nullptr;
}

}  // namespace panelcal
