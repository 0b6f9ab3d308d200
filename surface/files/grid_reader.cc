// SPDX-License-Identifier: Apache-2.0
#include "surface/files/grid_reader.h"

#include <cmath>
#include <cstddef>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// In the file's unit. No machine probes closer nodes, and few digits would tell them apart.
constexpr double kLeastStep = 0.001;

}  // namespace

Expected<void> check_grid(const std::string& file,
                          const TextField& at,
                          const LatticeAxis& x,
                          const LatticeAxis& y) {
  const auto bad = [&](std::string what, std::string expected) {
    return failure(
        {Code::MeasurementFile, {file, at.line, at.column}, std::move(what), std::move(expected)});
  };
  if (x.n_nodes < 2 || y.n_nodes < 2) {
    return bad(fmt::format("a grid of {} x {} nodes", x.n_nodes, y.n_nodes), "2 or more each way");
  }
  if (static_cast<std::size_t>(x.n_nodes) > kMaxFileProbes / static_cast<std::size_t>(y.n_nodes)) {
    return bad(fmt::format("a grid of {} x {} nodes", x.n_nodes, y.n_nodes),
               fmt::format("at most {} in all", kMaxFileProbes));
  }
  for (const LatticeAxis* axis : {&x, &y}) {
    if (axis->step_mm >= kLeastStep) continue;
    return bad(fmt::format("nodes that are {:g} apart", axis->step_mm),
               fmt::format("at least {:g}", kLeastStep));
  }
  return {};
}

ProbeFile file_of_grid(ProbeFormat format,
                       const std::string& file,
                       const ReadGrid& grid,
                       const ProbeFileOptions& options) {
  const double unit_mm = options.unit_mm();
  const auto scaled = [&](const LatticeAxis& axis) {
    return LatticeAxis{axis.first_mm * unit_mm, axis.step_mm * unit_mm, axis.n_nodes};
  };
  ProbeFile out;
  out.format = format;
  out.file = file;
  out.grid = ProbeGrid{scaled(grid.x), scaled(grid.y)};
  for (std::size_t k = 0; k < grid.nodes.size(); ++k) {
    const ReadNode& node = grid.nodes[k];
    const int i = static_cast<int>(k) % grid.x.n_nodes;
    const int j = static_cast<int>(k) / grid.x.n_nodes;
    const auto place = position_mm<frame::Nominal>(out.grid->x.at_mm(i), out.grid->y.at_mm(j));
    std::string name = fmt::format("column {} row {}", i, j);
    if (node.height) {
      out.points.push_back(
          {place, {mm(*node.height * unit_mm), options.scatter()}, std::move(name), node.from});
    } else {
      out.missing.push_back({place, std::move(name), node.reason, node.from});
    }
  }
  return out;
}

}  // namespace panelcal::internal
