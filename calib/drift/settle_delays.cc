// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/settle_delays.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "calib/base/statistics/random.h"

namespace panelcal {
namespace {

/// A view moves if it is this number of its standard deviations away from the views at rest.
constexpr double kMovingSigmas = 4;
/// A swing is seen a little longer than it was seen at last.
constexpr double kSeenLonger = 1.5;
constexpr double kUnseenShare = 0.25;
/// The last views, which are at rest if any are.
constexpr std::size_t kRestingShare = 4;

/// From 0 to 1, the same in every run: times that no rule makes have no frequency of their own.
double chance_of(int i_round, int i) {
  constexpr std::uint64_t kRound = 1000;
  return Random(3)
      .fork(static_cast<std::uint64_t>(i_round) * kRound + static_cast<std::uint64_t>(i))
      .uniform();
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
    const double off = is_end ? 0 : 0.5 * (chance_of(0, i) - 0.5);
    const double part = (i + off) / (n - 1);
    delays.push_back(part * part * longest);
  }
  return delays;
}

std::vector<Time> next_settle_delays(
    std::span<const SettleView> seen, int n, int i_round, Time longest, Length limit) {
  const Time reach = seen.empty() ? kUnseenShare * longest : moving_until(seen, longest, limit);
  std::vector<Time> delays;
  for (int i = 0; i < n; ++i) {
    delays.push_back((i + chance_of(i_round, i)) / n * reach);
  }
  return delays;
}

}  // namespace panelcal
