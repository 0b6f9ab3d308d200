// SPDX-License-Identifier: Apache-2.0
#include "program/walk/execution/risk_judge.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "calib/correction/error_budget.h"

namespace panelcal {
namespace {

constexpr double kCell_mm = 16;
constexpr std::size_t kSlots = 4096;

/// Of a place that is no number, any.
std::int64_t cell_number(double at_mm) {
  constexpr double kMost = 1e6;
  const double number = std::floor(at_mm / kCell_mm);
  return std::isfinite(number) ? static_cast<std::int64_t>(std::clamp(number, -kMost, kMost)) : 0;
}

/// sqrt(-2 ln kMinStatedRisk): a distance that an error of sigma 1 exceeds as rarely, or more so.
const double kSigmas = std::sqrt(-2 * std::log(kMinStatedRisk));

}  // namespace

RiskJudge::RiskJudge(const WalkOptions& options, const CorrectionState& corrections)
    : corrections_(corrections), states_machine_(options.uncertainty.unstated().empty()) {
}

void RiskJudge::take_correction() {
  const CorrectionStack& stack = corrections_.stack;
  base_ = stack.base();
  nested_ = stack.nested();
  const Reliability* const base = corrections_.base_reliability.get();
  const Reliability* const nested = corrections_.nested_reliability.get();
  is_refused_ =
      (base != nullptr && base->is_rejected) || (nested != nullptr && nested->is_rejected);
  can_be_stated_ = (base == nullptr || base->can_be_stated()) &&
                   (nested == nullptr || nested->can_be_stated()) && stack.smooth() == nullptr;
  shifts_ = unseen_shifts(stack, base, nested);
  noisy_ = stack.drilled_from_nominal();
  if (can_be_stated_) noisy_.cov += unseen_noise_cov(stack, base, nested);
  cells_.resize(kSlots);
  ++i_correction_;
}

RiskJudge::Cell RiskJudge::bounds_at(const Eigen::Vector2d& corner_mm) const {
  const auto corner = position_mm<frame::Nominal>(corner_mm);
  Cell cell;
  for (const UnseenShift& shift : shifts_) {
    cell.unseen_mm = std::max(cell.unseen_mm, shift_at(shift, corner).in_mm());
  }
  if (!can_be_stated_) {
    cell.least_radius_mm = std::numeric_limits<double>::infinity();
    return cell;
  }
  const auto sigma_mm = [&](const TransformEstimate<frame::Actual, frame::Nominal>& map) {
    return largest_sigma(place_cov_mm2(map.cov, corner)).in_mm();
  };
  const double sure_mm =
      cell.unseen_mm + kSigmas * sigma_mm(corrections_.stack.drilled_from_nominal());
  cell.least_radius_mm = std::max(sure_mm, kSigmas * sigma_mm(noisy_));
  return cell;
}

const RiskJudge::Cell& RiskJudge::cell_at(const Position<frame::Nominal>& at) {
  const std::int64_t column = cell_number(at.in_mm().x());
  const std::int64_t row = cell_number(at.in_mm().y());
  constexpr std::int64_t kRow = 4'000'000;
  const std::int64_t index = column + kRow * row;
  Cell& cell = cells_[static_cast<std::size_t>(column + 64 * row) % kSlots];
  if (cell.i_correction == i_correction_ && cell.index == index) return cell;
  cell = {.index = index, .i_correction = i_correction_};
  for (const double dx : {0.0, 1.0}) {
    for (const double dy : {0.0, 1.0}) {
      const Cell corner = bounds_at({kCell_mm * (static_cast<double>(column) + dx),
                                     kCell_mm * (static_cast<double>(row) + dy)});
      cell.unseen_mm = std::max(cell.unseen_mm, corner.unseen_mm);
      cell.least_radius_mm = std::max(cell.least_radius_mm, corner.least_radius_mm);
    }
  }
  return cell;
}

void RiskJudge::judge(const Position<frame::Nominal>& at, Length radius, PlacedPoint& place) {
  const CorrectionStack& stack = corrections_.stack;
  if (stack.base() != base_ || stack.nested() != nested_) take_correction();
  const double risk = breaking_risk_(place.cov_mm2, radius);
  place.judged_risk = risk;
  const Cell& cell = cell_at(at);
  place.unseen = mm(cell.unseen_mm);
  // The worst place is to be known, and not only its cell.
  if (cell.unseen_mm > furthest_mm_) {
    place.unseen = shift_at(*furthest(shifts_, at), at);
    furthest_mm_ = std::max(furthest_mm_, place.unseen.in_mm());
  }
  if (!states_machine_ || is_refused_) {
    place.risk.reset();
  } else {
    const bool is_stated = radius.in_mm() >= cell.least_radius_mm;
    place.risk = is_stated ? risk : std::max(risk, kMinStatedRisk);
  }
}

void RiskJudge::judge_at_target(Length radius, PlacedPoint& place) {
  const double risk = breaking_risk_(place.cov_mm2, radius);
  place.judged_risk = risk;
  place.unseen = mm(kUnlimitedError_mm);
  place.risk = states_machine_ ? std::optional(std::max(risk, kMinStatedRisk)) : std::nullopt;
}

}  // namespace panelcal
