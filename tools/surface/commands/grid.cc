// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/commands/grid.h"

#include <array>
#include <charconv>
#include <optional>
#include <system_error>

#include "tools/surface/commands/subcommand.h"
#include <Eigen/Core>
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

constexpr int kMostNodes = 1000;  ///< along either side

/// Empty if the text is not valid.
std::optional<std::array<int, 2>> grid_size(const std::string& text) {
  std::array<int, 2> out = {};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int& n : out) {
    const auto read = std::from_chars(at, end, n);
    if (read.ec != std::errc() || n < 2 || n > kMostNodes) return std::nullopt;
    const bool is_last = &n == &out.back();
    if (is_last ? read.ptr != end : read.ptr == end || *read.ptr != 'x') return std::nullopt;
    at = is_last ? end : read.ptr + 1;
  }
  return out;
}

}  // namespace

Expected<GridAxes> grid_axes(const std::string& command,
                             const std::string& text,
                             const ZonedMap& map) {
  const auto size = grid_size(text);
  if (!size) {
    return failure(usage(command,
                         "--grid " + quoted(text),
                         fmt::format("NXxNY, each 2 to {}, such as 11x7", kMostNodes)));
  }
  Eigen::Vector2d low_mm = map.map(0).hull().front().in_mm(), high_mm = low_mm;
  for (const HeightMap& zone : map.maps()) {
    for (const auto& corner : zone.hull()) {
      low_mm = low_mm.cwiseMin(corner.in_mm());
      high_mm = high_mm.cwiseMax(corner.in_mm());
    }
  }
  const auto axis = [&](int i) {
    const int n = (*size)[static_cast<std::size_t>(i)];
    return LatticeAxis{low_mm[i], (high_mm[i] - low_mm[i]) / (n - 1), n};
  };
  return GridAxes{axis(0), axis(1)};
}

}  // namespace panelcal::surface
