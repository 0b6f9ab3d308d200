// SPDX-License-Identifier: Apache-2.0
#include "surface/files/formats/klipper_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "surface/files/grid_reader.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Klipper keeps places to 0.01 mm, and the radius to 0.1.
constexpr double kKlipperRounding_mm = 0.02;

Expected<TextField> value_of_profile(const std::string& file,
                                     const KlipperProfile& profile,
                                     std::string_view key) {
  const auto found = profile.values.find(key);
  if (found != profile.values.end()) return found->second;
  return failure({Code::MeasurementFile,
                  {file, profile.name.line, profile.name.column},
                  fmt::format("bed mesh {} without {}", quoted(profile.name.text), key),
                  std::string(key)});
}

Expected<LatticeAxis> klipper_axis(const std::string& file,
                                   const KlipperProfile& profile,
                                   char letter) {
  const auto key = [&](std::string_view before, std::string_view behind) {
    return std::string(before) + letter + std::string(behind);
  };
  PANELCAL_TRY(const TextField low, value_of_profile(file, profile, key("min_", "")));
  PANELCAL_TRY(const TextField high, value_of_profile(file, profile, key("max_", "")));
  PANELCAL_TRY(const TextField count, value_of_profile(file, profile, key("", "_count")));
  PANELCAL_TRY(const double first_mm, number_of(file, low));
  PANELCAL_TRY(const double last_mm, number_of(file, high));
  PANELCAL_TRY(const int n_nodes, count_of(file, count, 2, static_cast<int>(kMaxFileProbes)));
  return LatticeAxis{first_mm, (last_mm - first_mm) / (n_nodes - 1), n_nodes};
}

Expected<void> read_heights(const std::string& file,
                            const KlipperProfile& profile,
                            ReadGrid& grid) {
  const auto counted =
      [&](const TextField& at, std::size_t n, int expected, std::string_view what) {
        return failure({Code::MeasurementFile,
                        {file, at.line, at.column},
                        fmt::format("{} {}", n, what),
                        fmt::format("{}, as the mesh's count says", expected)});
      };
  if (profile.rows.size() != static_cast<std::size_t>(grid.y.n_nodes)) {
    return counted(profile.name, profile.rows.size(), grid.y.n_nodes, "rows of points");
  }
  for (const auto& row : profile.rows) {
    if (row.size() != static_cast<std::size_t>(grid.x.n_nodes)) {
      return counted(
          row.empty() ? profile.name : row.front(), row.size(), grid.x.n_nodes, "points");
    }
    for (const TextField& cell : row) {
      ReadNode node;
      PANELCAL_TRY(node.height, number_of(file, cell));
      node.from = {file, cell.line, cell.column};
      grid.nodes.push_back(std::move(node));
    }
  }
  return {};
}

/// Fills up a round bed's rows as Klipper does, in reverse: such nodes have no height of their own.
Expected<void> leave_out_beyond_radius(const KlipperBed& bed, double radius_mm, ReadGrid& grid) {
  const auto is_beyond = [&](int column, int row) {
    const Eigen::Vector2d place_mm(grid.x.at_mm(column), grid.y.at_mm(row));
    return (place_mm - bed.origin_mm).norm() > radius_mm + kKlipperRounding_mm;
  };
  for (int row = 0; row < grid.y.n_nodes; ++row) {
    const auto node_at = [&](int column) -> ReadNode& {
      return grid.nodes[static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.x.n_nodes) +
                        static_cast<std::size_t>(column)];
    };
    int first = 0, last = grid.x.n_nodes - 1;
    while (first < last && is_beyond(first, row)) ++first;
    while (last > first && is_beyond(last, row)) --last;
    if (is_beyond(first, row)) {
      return failure({Code::MeasurementFile,
                      node_at(first).from,
                      fmt::format("row {} beyond the mesh_radius of {:g} mm", row, radius_mm),
                      "rows within it: the mesh is not of this [bed_mesh]"});
    }
    const double low_height = *node_at(first).height, high_height = *node_at(last).height;
    for (int column = 0; column < grid.x.n_nodes; ++column) {
      if (column >= first && column <= last) continue;
      ReadNode& node = node_at(column);
      if (*node.height != (column < first ? low_height : high_height)) {
        return failure(
            {Code::MeasurementFile,
             node.from,
             fmt::format(
                 "column {} row {} beyond the mesh_radius of {:g} mm", column, row, radius_mm),
             "the height of its row's end: the mesh is not of this [bed_mesh]"});
      }
      node.height.reset();
      node.reason = fmt::format("beyond the mesh_radius of {:g} mm", radius_mm);
    }
  }
  return {};
}

/// True if every node beyond the circle within the mesh has the height of its row's end, as on a
/// round bed, which Klipper gives a square with a node in its middle.
bool is_filled_up_as_round(ReadGrid grid) {
  const double width_mm = grid.x.last_mm() - grid.x.first_mm;
  const double depth_mm = grid.y.last_mm() - grid.y.first_mm;
  if (grid.x.n_nodes != grid.y.n_nodes || grid.x.n_nodes % 2 == 0 ||
      std::abs(width_mm - depth_mm) > 2 * kKlipperRounding_mm) {
    return false;
  }
  KlipperBed bed;
  bed.origin_mm = {grid.x.first_mm + width_mm / 2, grid.y.first_mm + depth_mm / 2};
  return leave_out_beyond_radius(bed, std::max(width_mm, depth_mm) / 2, grid).has_value();
}

void leave_out_faulty(const KlipperBed& bed, ReadGrid& grid) {
  for (std::size_t k = 0; k < grid.nodes.size(); ++k) {
    const auto n_columns = static_cast<std::size_t>(grid.x.n_nodes);
    const Eigen::Vector2d place_mm(grid.x.at_mm(static_cast<int>(k % n_columns)),
                                   grid.y.at_mm(static_cast<int>(k / n_columns)));
    for (const KlipperBed::Region& region : bed.faulty) {
      if (!region.low_mm || !region.high_mm) continue;
      const bool is_within = (place_mm - *region.low_mm).minCoeff() >= -kKlipperRounding_mm &&
                             (*region.high_mm - place_mm).minCoeff() >= -kKlipperRounding_mm;
      if (!is_within) continue;
      grid.nodes[k].height.reset();
      grid.nodes[k].reason =
          fmt::format("in {}: Klipper averages the probes about it", region.name);
    }
  }
}

}  // namespace

Expected<const KlipperProfile*> chosen_profile(const std::vector<KlipperProfile>& profiles,
                                               const std::string& file,
                                               const ProbeFileOptions& options) {
  std::vector<std::string> names;
  const KlipperProfile* chosen = nullptr;
  for (const KlipperProfile& profile : profiles) {
    names.push_back(quoted(profile.name.text));
    if (options.profile == profile.name.text || options.profile.empty()) chosen = &profile;
  }
  if (names.empty()) {
    return failure({Code::MeasurementFile,
                    {file, 0, 0},
                    "no bed mesh is saved in it",
                    "a [bed_mesh NAME] of BED_MESH_CALIBRATE and SAVE_CONFIG"});
  }
  if (chosen != nullptr && (profiles.size() == 1 || !options.profile.empty())) return chosen;
  return failure({Code::MeasurementFile,
                  {file, 0, 0},
                  options.profile.empty() ? fmt::format("{} bed meshes", names.size())
                                          : fmt::format("no bed mesh {}", quoted(options.profile)),
                  fmt::format("--profile with one of {}", fmt::join(names, ", "))});
}

Expected<ProbeFile> file_of_profile(ProbeFormat format,
                                    const std::string& file,
                                    const KlipperProfile& profile,
                                    const KlipperBed& bed,
                                    const ProbeFileOptions& options) {
  ReadGrid grid;
  PANELCAL_TRY(grid.x, klipper_axis(file, profile, 'x'));
  PANELCAL_TRY(grid.y, klipper_axis(file, profile, 'y'));
  PANELCAL_CHECK(check_grid(file, profile.name, grid.x, grid.y));
  PANELCAL_CHECK(read_heights(file, profile, grid));
  if (bed.radius_mm) {
    PANELCAL_CHECK(leave_out_beyond_radius(bed, *bed.radius_mm, grid));
  } else if (bed.may_be_round && is_filled_up_as_round(grid)) {
    return failure({Code::MeasurementFile,
                    grid.nodes.front().from,
                    fmt::format("bed mesh {} has the heights that Klipper makes up on a round bed",
                                quoted(profile.name.text)),
                    "its printer.cfg, which says in [bed_mesh] whether there is a mesh_radius"});
  }
  leave_out_faulty(bed, grid);
  ProbeFile out = file_of_grid(format, file, grid, options);
  out.zero = fmt::format("the printer's zero, heights from {}; mesh {}",
                         bed.zero.empty() ? "its nozzle at Z 0" : bed.zero,
                         quoted(profile.name.text));
  return out;
}

}  // namespace panelcal::internal
