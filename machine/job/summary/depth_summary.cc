// SPDX-License-Identifier: Apache-2.0
#include "machine/job/summary/depth_summary.h"

#include <optional>

#include "calib/base/append_format.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

std::string side_text(const std::optional<Length>& length) {
  return length ? fmt::format("{:.1f}", length->in_um()) : "-";
}

std::string false_alarm_text(double chance) {
  return chance < 1e-12 ? "<1e-12" : fmt::format("{:.1e}", chance);
}

}  // namespace

std::string depth_tolerance_text(const DepthTolerance& tolerance) {
  return side_text(tolerance.too_shallow) + " / " + side_text(tolerance.too_deep);
}

std::vector<std::string> surface_lines(const DepthVerdict& verdict) {
  const auto maps = verdict.errors().maps();
  std::vector<std::string> lines;
  for (std::size_t axis = 0; axis < maps.size(); ++axis) {
    const std::string of_axis = maps.size() > 1 ? fmt::format("Z axis {}: ", axis) : "";
    const Expected<ZonedMap>& map = maps[axis];
    if (!map) {
      lines.push_back(of_axis + "no map of the surface: " + map.error().what);
      continue;
    }
    for (std::size_t i = 0; i < map->maps().size(); ++i) {
      const bool is_whole = map->zones().empty();
      const std::string of_zone =
          is_whole ? of_axis : of_axis + "zone " + quoted(map->zones()[i].name) + ": ";
      lines.push_back(of_zone + "surface: " + map->map(i).surface().summary());
      for (const SurfaceOutlier& outlier : map->map(i).outliers()) {
        lines.push_back(of_zone + "not in the map: " + outlier.text());
      }
    }
  }
  return lines;
}

std::string depth_summary(const DepthVerdict& verdict) {
  std::string out = "depth, predicted (lengths in um)\n";
  internal::append_format(out,
                          "{:>6} {:>8} {:>15} {:>8} {:>8} {:>6} {:>6} {:>9} {:>9}\n",
                          "tool",
                          "depths",
                          "shallow / deep",
                          "off",
                          "sigma",
                          "warn",
                          "hold",
                          "shallow",
                          "deep");
  for (const auto& [number, tool] : verdict.by_tool()) {
    const bool is_judged = tool.places.n_judged > 0;
    internal::append_format(out,
                            "{:>6} {:>8} {:>15} {:>8} {:>8} {:>6} {:>6} {:>9} {:>9}\n",
                            fmt::format("T{}", number),
                            tool.places.n_judged + tool.places.n_unjudged,
                            depth_tolerance_text(tool.tolerance),
                            is_judged ? fmt::format("{:+.2f}", tool.largest_mean.in_um()) : "-",
                            is_judged ? fmt::format("{:.2f}", tool.largest_sigma.in_um()) : "-",
                            tool.places.n_warned,
                            tool.places.n_held,
                            is_judged ? false_alarm_text(tool.worst.risk.too_shallow) : "-",
                            is_judged ? false_alarm_text(tool.worst.risk.too_deep) : "-");
  }
  for (const std::string& line : surface_lines(verdict)) out += line + "\n";
  return out + "depth verdict: " + verdict.sentence();
}

}  // namespace panelcal
