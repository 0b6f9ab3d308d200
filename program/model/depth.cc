// SPDX-License-Identifier: Apache-2.0
#include "program/model/depth.h"

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
  switch (control) {
    case DepthControl::Standard:
      return "standard";
    case DepthControl::Depth:
      return "depth";
    case DepthControl::Slm:
      return "slm";
  }
  return {};
}

std::string_view name(DepthReference reference) {
  switch (reference) {
    case DepthReference::Table:
      return "table";
    case DepthReference::Board:
      return "board";
    case DepthReference::Plane:
      return "plane";
    case DepthReference::Grid:
      return "grid";
  }
  return {};
}

std::string_view name(HeightSource source) {
  switch (source) {
    case HeightSource::Measured:
      return "measured";
    case HeightSource::Filled:
      return "filled";
    case HeightSource::Extrapolated:
      return "extrapolated";
    case HeightSource::InVoid:
      return "void";
  }
  return {};
}

}  // namespace panelcal
