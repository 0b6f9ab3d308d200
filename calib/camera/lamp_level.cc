// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/lamp_level.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::size_t kMinLevels = 3;

std::optional<LampLevel> no_lamp_level(std::string* reason, std::string text) {
  if (reason != nullptr) *reason = std::move(text);
  return std::nullopt;
}

/// One sample a level, by rising level, without values that are not finite.
std::vector<LampSample> by_level(std::span<const LampSample> samples) {
  std::map<double, LampSample> levels;
  for (const LampSample& s : samples) {
    if (!std::isfinite(s.level) || !std::isfinite(s.contrast) || !std::isfinite(s.clipped_share)) {
      continue;
    }
    const auto [at, is_new] = levels.try_emplace(s.level, s);
    at->second.contrast = std::min(at->second.contrast, s.contrast);
    at->second.clipped_share = std::max(at->second.clipped_share, s.clipped_share);
  }
  std::vector<LampSample> sorted;
  for (const auto& [level, sample] : levels) sorted.push_back(sample);
  return sorted;
}

}  // namespace

std::optional<LampLevel> best_lamp_level(std::span<const LampSample> samples,
                                         const LampLimits& limits,
                                         std::string* reason) {
  std::vector<LampSample> levels = by_level(samples);
  if (levels.size() < kMinLevels) {
    return no_lamp_level(reason,
                         fmt::format("{} lamp levels are too few for a choice", levels.size()));
  }
  const auto clips = std::ranges::find_if(
      levels, [&](const LampSample& s) { return !(s.clipped_share <= limits.clipped_share); });
  const bool has_clipped = clips != levels.end();
  levels.erase(clips, levels.end());
  if (levels.empty()) {
    return no_lamp_level(reason, "the picture clips at every lamp level: shorten the exposure");
  }
  const auto best = std::ranges::max_element(levels, {}, &LampSample::contrast);
  if (!(best->contrast >= limits.contrast)) {
    return no_lamp_level(
        reason,
        fmt::format("the contrast is {:.3f} at best without clipping, {:.3f} is needed",
                    best->contrast,
                    limits.contrast));
  }
  const double enough = best->contrast * (1 - limits.worth);
  const auto darkest =
      std::ranges::find_if(levels, [enough](const LampSample& s) { return s.contrast >= enough; });
  return LampLevel{
      darkest->level, darkest->contrast, !has_clipped && std::next(darkest) == levels.end()};
}

}  // namespace panelcal
