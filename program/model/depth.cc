// SPDX-License-Identifier: Apache-2.0
#include "program/model/depth.h"

#include <array>
#include <cstddef>

#include "surface/map/height_map.h"

namespace panelcal {
namespace {

std::vector<Length> between_all(const std::vector<Length>& from,
                                const std::vector<Length>& to,
                                double fraction) {
  std::vector<Length> out = to;
  for (std::size_t i = 0; from.size() == to.size() && i < to.size(); ++i) {
    out[i] = from[i] + fraction * (to[i] - from[i]);
  }
  return out;
}

}  // namespace

DepthOfCut interpolate(const DepthOfCut& from, const DepthOfCut& to, double fraction) {
  const auto between = [fraction](const std::optional<Length>& a, const std::optional<Length>& b) {
    return a && b ? std::optional(*a + fraction * (*b - *a)) : b;
  };
  DepthOfCut cut = to;
  cut.z = between(from.z, to.z);
  cut.depth = between(from.depth, to.depth);
  cut.surface = between(from.surface, to.surface);
  cut.other_surfaces = between_all(from.other_surfaces, to.other_surfaces, fraction);
  return cut;
}

std::string_view name(DepthControl control) {
  constexpr std::array<std::string_view, 3> kNames = {"standard", "depth", "slm"};
  return kNames[static_cast<std::size_t>(control)];
}

std::string_view name(DepthReference reference) {
  constexpr std::array<std::string_view, 4> kNames = {"table", "board", "plane", "grid"};
  return kNames[static_cast<std::size_t>(reference)];
}

std::string_view name(HeightSource source) {
  constexpr std::array<std::string_view, 4> kNames = {"measured", "filled", "extrapolated", "void"};
  return kNames[static_cast<std::size_t>(source)];
}

}  // namespace panelcal
