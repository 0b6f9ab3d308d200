// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/settle_delays.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace panelcal {
namespace {

/// The fractional parts of its multiples lie as evenly as any sequence's (Weyl; Knuth 6.4).
constexpr double kGolden = std::numbers::phi - 1;
/// A view moves if it is this number of its standard deviations away from the views at rest.
constexpr double kMovingSigmas = 4;
/// A swing is seen a little longer than it was seen at last.
constexpr double kSeenLonger = 1.5;
constexpr double kUnseenShare = 0.25;
/// The last views, which are at rest if any are.
constexpr std::size_t kRestingShare = 4;

double golden_part(int i) {
  const double at = kGolden * (i + 0.5);
  return at - std::floor(at);
}

/// The time after which no view is away from where the last ones are.
Time moving_until(std::span<const SettleView> seen, Time longest, Length limit) {
  std::vector<SettleView> sorted(seen.begin(), seen.end());
  std::ranges::sort(sorted, {}, &SettleView::since_move);
  const std::size_t n_resting = std::max<std::size_t>(1, sorted.size() / kRestingShare);
  Eigen::Vector2d rest_mm = Eigen::Vector2d::Zero();
  for (std::size_t i = sorted.size() - n_resting; i < sorted.size(); ++i) {
    rest_mm += sorted[i].seen.position.in_mm() / static_cast<double>(n_resting);
  }
  for (std::size_t i = sorted.size(); i > 0; --i) {
    const SettleView& view = sorted[i - 1];
    const double away_mm = (view.seen.position.in_mm() - rest_mm).norm();
    const double sigma_mm = std::sqrt(view.seen.cov.trace());
    if (away_mm < std::max(kMovingSigmas * sigma_mm, 0.5 * limit.in_mm())) continue;
    const Time next = i < sorted.size() ? sorted[i].since_move : view.since_move;
    return std::min(longest, kSeenLonger * next);
  }
  return kUnseenShare * longest;
}

}  // namespace

std::vector<Time> first_settle_delays(int n, Time longest) {
  std::vector<Time> delays;
  for (int i = 0; i < n; ++i) {
    // Up to half a place off, but for the ends.
    const bool is_end = i == 0 || i + 1 == n;
    const double off = is_end ? 0 : 0.5 * (golden_part(i) - 0.5);
    const double part = (i + off) / (n - 1);
    delays.push_back(part * part * longest);
  }
  return delays;
}

std::vector<Time> next_settle_delays(
    std::span<const SettleView> seen, int n, int i_round, Time longest, Length limit) {
  const Time reach =
      seen.empty() ? kUnseenShare * longest : moving_until(seen, longest, limit);
  std::vector<Time> delays;
  for (int i = 0; i < n; ++i) {
    delays.push_back(golden_part((i_round - 1) * n + i) * reach);
  }
  std::ranges::sort(delays);
  return delays;
}

}  // namespace panelcal
