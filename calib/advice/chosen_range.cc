// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/chosen_range.h"

#include <algorithm>
#include <vector>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/base/statistics/plane_normal.h"
#include "calib/panel/model_choice.h"
#include "calib/panel/system.h"

namespace panelcal {
namespace {

constexpr int kDraws = 100;  ///< of each kind of panel
constexpr int kTail = 5;     ///< of them are left out at either end
constexpr double kBeyondDoubt = 30;
constexpr double kInDoubt = 3;

/// The way that the targets of a panel move at their mean distance from the middle, in noises, by
/// rotation, scale, difference of the scales and shear.
using PanelShape = Eigen::Vector4d;

std::vector<PanelShape> panels() {
  std::vector<PanelShape> out = {PanelShape::Zero()};
  for (int softest = 0; softest < 4; ++softest) {
    for (const double size : {kInDoubt, kBeyondDoubt}) {
      PanelShape one = PanelShape::Zero();
      one.head(softest).setConstant(kBeyondDoubt);
      one[softest] = size;
      out.push_back(one);
    }
  }
  return out;
}

class Measured {
 public:
  explicit Measured(const ChoiceProblem& problem) : problem_(problem) {
    std::vector<internal::RawPair> pairs;
    for (const DesignTarget& target : problem.targets) {
      const Eigen::Vector2d at_mm = target.nominal.in_mm();
      pairs.push_back({at_mm, at_mm, kUnit_mm * kUnit_mm * target.cov, target.axes});
      roots_.push_back(internal::plane_root(target.cov));
    }
    spread_ = internal::spread_of(pairs);
    drawn_ = std::move(pairs);
  }

  /// The greatest leverage that a job states.
  std::optional<double> leverage(const PanelShape& deformation, Random& random) const {
    Eigen::Matrix2d moved;
    moved << deformation[1] + deformation[2], deformation[3] - deformation[0],
        deformation[3] + deformation[0], deformation[1] - deformation[2];
    moved *= kUnit_mm / spread_.scale_mm();
    std::vector<internal::RawPair> pairs = drawn_;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Eigen::Vector2d off = moved * (pairs[i].from_mm - spread_.from_center_mm) +
                                  kUnit_mm * (roots_[i] * internal::plane_normal(random));
      pairs[i].to_mm += internal::observed_part(off, pairs[i].axes);
    }
    return leverage_of(pairs);
  }

 private:
  /// The noise; any size far below the panel's will do.
  static constexpr double kUnit_mm = 1e-3;

  std::optional<double> leverage_of(std::span<const internal::RawPair> pairs) const {
    const std::vector<ModelScore> scores = internal::compare_raw(pairs, problem_.usual);
    const ModelScore* best = chosen(scores);
    const PanelModel model = best != nullptr ? best->model : problem_.usual;
    const internal::RawFitResult result = internal::fit_raw(pairs, model);
    if (!result.fit) return std::nullopt;
    MapCovariance cov = result.fit->cov;
    if (best != nullptr) cov += internal::choice_covariance(pairs, scores);
    cov /= kUnit_mm * kUnit_mm;
    if (!problem_.base_cov.isZero(0)) {
      MapCovariance left = MapCovariance::Identity();
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        left -= result.fit->gain.middleCols<2>(2 * static_cast<Eigen::Index>(i)) *
                internal::design(pairs[i].from_mm);
      }
      cov += left * problem_.base_cov * left.transpose();
    }
    const LeverageMap map(cov);
    double worst = 0;
    for (const Position<frame::Nominal>& corner : problem_.corners) {
      worst = std::max(worst, map(corner));
    }
    return worst;
  }

  const ChoiceProblem& problem_;
  internal::Spread spread_;
  std::vector<internal::RawPair> drawn_;
  std::vector<Eigen::Matrix2d> roots_;
};

}  // namespace

std::optional<ChosenRange> chosen_range(const ChoiceProblem& problem) {
  const Measured measured(problem);
  Random random(1);
  std::optional<ChosenRange> range;
  for (const PanelShape& deformation : panels()) {
    std::vector<double> leverages;
    for (int i = 0; i < kDraws; ++i) {
      const std::optional<double> one = measured.leverage(deformation, random);
      if (!one) return std::nullopt;
      leverages.push_back(*one);
    }
    std::ranges::sort(leverages);
    const double low = leverages[kTail];
    const double high = leverages[kDraws - 1 - kTail];
    if (!range) range = {low, high};
    range->low = std::min(range->low, low);
    range->high = std::max(range->high, high);
  }
  return range;
}

}  // namespace panelcal
