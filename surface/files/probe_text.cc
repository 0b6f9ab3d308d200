// SPDX-License-Identifier: Apache-2.0
#include "surface/files/probe_text.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "surface/files/height_map_figures.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// RepRapFirmware refuses closer nodes, shorter grids, and lines of wider heights.
constexpr double kLeastStep_mm = 0.1;
constexpr double kLeastRange_mm = 1;
constexpr double kHighest_mm = 99.999;
/// Heights and feed with which bCNC would scan on.
constexpr double kAbove_mm = 3;
constexpr double kBelow_mm = 1;
constexpr double kFeed_mm_min = 10;

tl::unexpected<Diagnostic> refused(std::string what, std::string expected) {
  return failure({Code::GridInvalid, {}, std::move(what), std::move(expected)});
}

std::vector<double> known_heights_mm(const HeightGrid& grid) {
  std::vector<double> out;
  for (const std::optional<Length>& height : grid.heights) {
    if (height) out.push_back(height->in_mm());
  }
  return out;
}

/// node(column, row, height) for each, row by row.
template <class Node>
void for_each_node(const HeightGrid& grid, const Node& node) {
  std::size_t k = 0;
  for (int row = 0; row < grid.y.n_nodes; ++row) {
    for (int column = 0; column < grid.x.n_nodes; ++column) node(column, row, grid.heights[k++]);
  }
}

Expected<std::string> height_map_csv_text(const HeightGrid& grid) {
  for (const LatticeAxis* axis : {&grid.x, &grid.y}) {
    const double range_mm = axis->last_mm() - axis->first_mm;
    if (axis->step_mm >= kLeastStep_mm && range_mm >= kLeastRange_mm) continue;
    return refused(fmt::format("nodes every {:g} mm over {:g} mm", axis->step_mm, range_mm),
                   fmt::format("at least {} mm over {} mm", kLeastStep_mm, kLeastRange_mm));
  }
  const std::vector<double> heights_mm = known_heights_mm(grid);
  const auto figures = internal::HeightFigures::of(heights_mm);
  if (figures.least < -kHighest_mm || figures.greatest > kHighest_mm) {
    return refused(fmt::format("heights from {} to {} mm", figures.least, figures.greatest),
                   fmt::format("within {} mm", kHighest_mm));
  }
  std::string out = fmt::format(
      "RepRapFirmware height map file v2, min error {:.3f}, max error {:.3f}, mean {:.3f}, "
      "deviation {:.3f}\n"
      "axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1\n"
      "X,Y,{},{},{},{},-1,{},{},{},{}\n",
      figures.least,
      figures.greatest,
      figures.mean,
      figures.deviation,
      grid.x.first_mm,
      grid.x.last_mm(),
      grid.y.first_mm,
      grid.y.last_mm(),
      grid.x.step_mm,
      grid.y.step_mm,
      grid.x.n_nodes,
      grid.y.n_nodes);
  for_each_node(grid, [&](int column, int, const std::optional<Length>& height) {
    out += height ? fmt::format("{:7.3f}", height->in_mm()) : std::string("      0");
    out += column + 1 < grid.x.n_nodes ? ',' : '\n';
  });
  return out;
}

Expected<std::string> bcnc_text(const HeightGrid& grid) {
  const std::vector<double> heights_mm = known_heights_mm(grid);
  if (heights_mm.size() < grid.heights.size()) {
    const auto missing =
        std::find(grid.heights.begin(), grid.heights.end(), std::nullopt) - grid.heights.begin();
    return refused(fmt::format("column {} row {} without a height",
                               missing % grid.x.n_nodes,
                               missing / grid.x.n_nodes),
                   "all of them for bCNC, which would take 0");
  }
  const auto [least, greatest] = std::ranges::minmax(heights_mm);
  std::string out = fmt::format("{} {} {}\n{} {} {}\n{:.3f} {:.3f} {}\n\n\n",
                                grid.x.first_mm,
                                grid.x.last_mm(),
                                grid.x.n_nodes,
                                grid.y.first_mm,
                                grid.y.last_mm(),
                                grid.y.n_nodes,
                                least - kBelow_mm,
                                greatest + kAbove_mm,
                                kFeed_mm_min);
  for_each_node(grid, [&](int column, int row, const std::optional<Length>& height) {
    fmt::format_to(std::back_inserter(out),
                   "{} {} {}\n",
                   grid.x.at_mm(column),
                   grid.y.at_mm(row),
                   height->in_mm());
    if (column + 1 == grid.x.n_nodes) out += '\n';
  });
  return out;
}

Expected<std::string> opencncpilot_text(const HeightGrid& grid) {
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
      "<heightmap MinX=\"{}\" MinY=\"{}\" MaxX=\"{}\" MaxY=\"{}\" SizeX=\"{}\" SizeY=\"{}\">\n",
      grid.x.first_mm,
      grid.y.first_mm,
      grid.x.last_mm(),
      grid.y.last_mm(),
      grid.x.n_nodes,
      grid.y.n_nodes);
  for_each_node(grid, [&](int column, int row, const std::optional<Length>& height) {
    if (!height) return;
    fmt::format_to(std::back_inserter(out),
                   "  <point X=\"{}\" Y=\"{}\">{}</point>\n",
                   column,
                   row,
                   height->in_mm());
  });
  return out + "</heightmap>\n";
}

void append_log_line(std::string& out, const Eigen::Vector2d& p_mm, Length height) {
  fmt::format_to(std::back_inserter(out),
                 "{:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f}\n",
                 p_mm.x(),
                 p_mm.y(),
                 height.in_mm(),
                 0.0,
                 0.0,
                 0.0,
                 0.0,
                 0.0,
                 0.0);
}

Expected<std::string> linuxcnc_text(const HeightGrid& grid) {
  std::string out;
  for_each_node(grid, [&](int column, int row, const std::optional<Length>& height) {
    if (height) append_log_line(out, {grid.x.at_mm(column), grid.y.at_mm(row)}, *height);
  });
  return out;
}

}  // namespace

Expected<std::string> probe_file_text(ProbeFormat format, const HeightGrid& grid) {
  PANELCAL_CHECK(grid.validate());
  switch (format) {
    case ProbeFormat::HeightMapCsv:
      return height_map_csv_text(grid);
    case ProbeFormat::LinuxCncLog:
      return linuxcnc_text(grid);
    case ProbeFormat::BcncProbe:
      return bcnc_text(grid);
    case ProbeFormat::OpenCncPilotMap:
      return opencncpilot_text(grid);
    default:
      break;
  }
  return refused(fmt::format("a grid for a file of format {}", name_of(format)),
                 "heightmap, bcnc, opencncpilot or linuxcnc");
}

Expected<std::string> probe_file_text(ProbeFormat format, std::span<const ProbePoint> points) {
  if (format != ProbeFormat::LinuxCncLog && format != ProbeFormat::RecordedProbes) {
    return refused(fmt::format("probes for a file of format {}", name_of(format)),
                   "linuxcnc or probes");
  }
  std::string out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ProbePoint& point = points[i];
    const Eigen::Vector2d& p_mm = point.place.in_mm();
    const double height_mm = point.measured.height.in_mm(), sigma_mm = point.measured.sigma.in_mm();
    if (!p_mm.allFinite() || !std::isfinite(height_mm) || !std::isfinite(sigma_mm)) {
      return refused(fmt::format("a number of probe {} is not finite", i), "finite numbers");
    }
    if (format == ProbeFormat::LinuxCncLog) {
      append_log_line(out, p_mm, point.measured.height);
      continue;
    }
    fmt::format_to(std::back_inserter(out),
                   "{{\"probe\":{},\"nominal\":[{},{}],\"zaxis\":0,\"height\":{},\"sigma\":{},"
                   "\"status\":\"found\"}}\n",
                   i,
                   p_mm.x(),
                   p_mm.y(),
                   height_mm,
                   sigma_mm);
  }
  return out;
}

}  // namespace panelcal
