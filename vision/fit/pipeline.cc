// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/pipeline.h"

#include <algorithm>

namespace panelcal::internal {

void keep_best(double apart_px, std::vector<FittedCandidate>& candidates) {
  std::ranges::stable_sort(candidates, {}, [](const FittedCandidate& c) {
    return std::pair(c.judgement.verdict, -c.fit.score);
  });
  std::vector<FittedCandidate> kept;
  for (FittedCandidate& candidate : candidates) {
    const auto& place = candidate.fit.center.position;
    const bool is_new = std::ranges::none_of(kept, [&](const FittedCandidate& other) {
      return (other.fit.center.position - place).in_px().norm() < apart_px;
    });
    if (is_new) kept.push_back(std::move(candidate));
  }
  candidates = std::move(kept);
}

FittedCandidate refused_area(const DetectorInput& input, Judgement judgement) {
  FittedCandidate candidate{std::move(judgement), {}};
  const PixelBox box = input.area.box(input.image, 0);
  const Eigen::Vector2d middle(box.x0 + 0.5 * (box.width - 1), box.y0 + 0.5 * (box.height - 1));
  const double side = std::max({1, box.width, box.height});
  candidate.fit.center = {position_px<frame::Image>(middle),
                          side * side * Eigen::Matrix2d::Identity()};
  return candidate;
}

}  // namespace panelcal::internal
