// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "calib/base/statistics/median.h"
#include "calib/faults/stories.h"
#include "calib/panel/system.h"
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

// Rough priors of the causes; see fault_stories.cc.
constexpr double kPriorPad = 0.35;
constexpr double kPriorDamaged = 0.3;
constexpr double kPriorFocus = 0.05;

/// Likelihood ratio of a bad picture under a cause and under a healthy target, and that of a good
/// one.
struct PictureOdds {
  double bad;
  double good;
};
constexpr PictureOdds kOddsFocus{30, 0.01};
constexpr PictureOdds kOddsDamaged{3, 1};
constexpr PictureOdds kOddsPad{0.3, 1};

/// A picture is bad beside the others if its sigma is so much larger, or its score so much less.
constexpr double kBadSigma = 2;
constexpr double kBadScore = 0.75;

/// Shifts of a mark that is not where it should be: from what noise hides to a camera's view.
constexpr double kLeastShift_sigmas = 4;
constexpr double kGreatestShift_mm = 10;
constexpr double kShiftStep = 2;
/// Pads that an outlier is held against, the nearest to what was seen.
constexpr std::size_t kMostPads = 8;
/// More targets than this are not all suspected one by one.
constexpr std::size_t kMostSuspects = 24;
constexpr double kHuber_sigmas = 2.5;  // design note "Robust"

double odds_of(const PictureOdds& odds, bool is_bad) {
  return is_bad ? odds.bad : odds.good;
}

Eigen::Vector2d residual_mm(const ToldTarget& target, const Evidence& told) {
  return observed_part(target.to_mm - told.linear * target.from_mm - told.translation_mm,
                       target.axes);
}

/// Residuals in sigmas after a fit that large residuals pull at with constant force only (Huber
/// 1964), by weights that are renewed.
std::vector<double> robust_residuals(const Series& series) {
  std::vector<ToldTarget> targets(series.targets.begin(), series.targets.end());
  std::vector<double> out(targets.size(), 0);
  constexpr int kRounds = 20;
  for (int round = 0; round < kRounds; ++round) {
    const Evidence told = evidence(targets, series.belief);
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const ToldTarget& own = series.targets[i];
      out[i] = residual_mm(own, told).norm() / sigma_mm_of(own);
      targets[i].cov_mm2 = own.cov_mm2 * std::max(1.0, out[i] / kHuber_sigmas);
    }
  }
  return out;
}

std::vector<std::size_t> suspects(const Series& series) {
  std::vector<std::size_t> out(series.targets.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = i;
  if (out.size() <= kMostSuspects) return out;
  const std::vector<double> residuals = robust_residuals(series);
  std::ranges::stable_sort(
      out, std::ranges::greater{}, [&](std::size_t i) { return residuals[i]; });
  out.resize(kMostSuspects);
  return out;
}

std::vector<ToldTarget> with_error(const Series& series, std::size_t i, double sigma_mm) {
  std::vector<ToldTarget> targets(series.targets.begin(), series.targets.end());
  targets[i].cov_mm2 += sigma_mm * sigma_mm * Eigen::Matrix2d::Identity();
  return targets;
}

/// One target is off by a shift of any size: damaged, or out of focus.
void tell_of_shift(const Series& series, std::size_t i, std::vector<FaultStory>& stories) {
  const bool is_bad = has_bad_picture(series.facts, i);
  const auto n = static_cast<double>(series.targets.size());
  std::vector<double> sizes_mm;
  for (double size_mm = kLeastShift_sigmas * sigma_mm_of(series.targets[i]);
       size_mm < kGreatestShift_mm;
       size_mm *= kShiftStep) {
    sizes_mm.push_back(size_mm);
  }
  const auto share = static_cast<double>(sizes_mm.size());
  for (const double size_mm : sizes_mm) {
    FaultStory story;
    story.told = evidence(with_error(series, i, size_mm), series.belief);
    story.i_point = i;
    story.off_mm = residual_mm(series.targets[i], story.told).norm();
    const auto add = [&](FaultCause cause, double prior, const PictureOdds& odds) {
      story.cause = cause;
      story.log_weight =
          story.told.log_likelihood + std::log(prior * odds_of(odds, is_bad) / n / share);
      stories.push_back(story);
    };
    add(FaultCause::DamagedMark, kPriorDamaged, kOddsDamaged);
    if (is_bad) add(FaultCause::OutOfFocus, kPriorFocus, kOddsFocus);
  }
}

/// One target is another pad of the program, which is known to lie where it does.
void tell_of_pads(const Series& series, std::size_t i, std::vector<FaultStory>& stories) {
  const ToldTarget& own = series.targets[i];
  if (series.pads == nullptr || own.axes != ObservedAxes::Both) return;
  const Evidence others = evidence(with_error(series, i, kGreatestShift_mm), series.belief);
  if (!(std::abs(others.linear.determinant()) > 0.1)) return;
  const Eigen::Vector2d seen_mm = others.linear.inverse() * (own.to_mm - others.translation_mm);
  // Any pad as near as the one that was seen might have been taken as well.
  const double reach_mm = 1 + 1.5 * (seen_mm - own.from_mm).norm();
  if (!(reach_mm < 10 * kGreatestShift_mm)) return;
  const std::size_t n_near =
      std::max<std::size_t>(1, series.pads->within(own.from_mm, reach_mm).size());
  std::vector<ToldTarget> targets(series.targets.begin(), series.targets.end());
  const std::vector<std::size_t> candidates = series.pads->within(seen_mm, 1);
  for (std::size_t k = 0; k < std::min(candidates.size(), kMostPads); ++k) {
    const KnownPad& pad = series.pads->all()[candidates[k]];
    if ((pad.place_mm - own.from_mm).norm() < 1e-3) continue;
    targets[i].from_mm = pad.place_mm;
    FaultStory story;
    story.cause = FaultCause::WrongPad;
    story.i_point = i;
    story.pad = pad;
    story.told = evidence(targets, series.belief);
    story.off_mm = residual_mm(own, story.told).norm();
    story.pad_off_mm = residual_mm(targets[i], story.told).norm();
    const double prior = kPriorPad * odds_of(kOddsPad, has_bad_picture(series.facts, i)) /
                         static_cast<double>(series.targets.size() * n_near);
    story.log_weight = story.told.log_likelihood + std::log(prior);
    stories.push_back(story);
  }
}

}  // namespace

double sigma_mm_of(const ToldTarget& target) {
  double sum = 0;
  if (observes_x(target.axes)) sum += target.cov_mm2(0, 0);
  if (observes_y(target.axes)) sum += target.cov_mm2(1, 1);
  return std::sqrt(target.axes == ObservedAxes::Both ? sum / 2 : sum);
}

bool has_bad_picture(std::span<const PictureFacts> facts, std::size_t i) {
  std::vector<double> sigmas_mm;
  std::vector<double> scores;
  for (std::size_t k = 0; k < facts.size(); ++k) {
    if (k == i) continue;
    sigmas_mm.push_back(facts[k].sigma_mm);
    if (facts[k].score) scores.push_back(*facts[k].score);
  }
  if (sigmas_mm.empty()) return false;
  const bool is_vague = facts[i].sigma_mm >= kBadSigma * median(sigmas_mm);
  const bool is_poor =
      facts[i].score && !scores.empty() && *facts[i].score <= kBadScore * median(scores);
  return is_vague || is_poor;
}

void tell_of_liars(const Series& series, std::vector<FaultStory>& stories) {
  for (const std::size_t i : suspects(series)) {
    tell_of_shift(series, i, stories);
    tell_of_pads(series, i, stories);
  }
}

}  // namespace panelcal::internal
