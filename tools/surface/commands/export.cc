// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "surface/files/height_grid.h"
#include "surface/files/probe_text.h"
#include "surface/map/file.h"
#include "tools/cli/output_paths.h"
#include "tools/surface/commands/grid.h"
#include "tools/surface/commands/subcommand.h"
#include "tools/surface/made_facts.h"
#include "tools/surface/text.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

const std::string kSurfaceExport = "panelcal surface export";
/// Of a cell, between its nodes along either side.
constexpr int kWithinCell = 4;

/// Summary of the written file, for people.
struct Exported {
  ProbeFormat format = ProbeFormat::HeightMapCsv;
  std::size_t n_heights = 0;
  std::optional<GridAxes> axes;
  std::size_t n_missing = 0;
  Length worst_sigma;
  /// Of what lies bilinearly between the nodes from the map, where four nodes have a height.
  std::optional<Length> worst_between;
};

/// --format, else what the name's extension tells.
Expected<ProbeFormat> format_of(const SurfaceOptions& options) {
  if (!options.format.empty()) {
    if (const auto format = probe_format_from_name(options.format)) return *format;
  }
  const std::string extension = extension_of(options.output);
  if (extension == ".csv") return ProbeFormat::HeightMapCsv;
  if (extension == ".probe") return ProbeFormat::BcncProbe;
  if (extension == ".hmap") return ProbeFormat::OpenCncPilotMap;
  if (extension == ".jsonl") return ProbeFormat::RecordedProbes;
  return failure(usage(kSurfaceExport,
                       "no format belongs to the output's name " + quoted(options.output),
                       "--format, or a name that ends in .csv, .probe, .hmap or .jsonl"));
}

/// Of --zero, 0 without.
Expected<Length> zero_of(const SurfaceOptions& options, const ZonedMap& map) {
  if (options.zero_mm.empty()) return mm(0);
  const auto place = position_mm<frame::Nominal>(options.zero_mm[0], options.zero_mm[1]);
  PANELCAL_TRY(const ZonedHeight found, map.height_at(place));
  return found.height.height;
}

Length worst_between(const ZonedMap& map, const HeightGrid& grid, Length zero) {
  const auto n_columns = static_cast<std::size_t>(grid.x.n_nodes);
  double worst_mm = 0;
  for (int row = 0; row + 1 < grid.y.n_nodes; ++row) {
    for (int column = 0; column + 1 < grid.x.n_nodes; ++column) {
      const auto first = grid.heights.begin() + row * grid.x.n_nodes + column;
      const auto above = first + static_cast<std::ptrdiff_t>(n_columns);
      if (!first[0] || !first[1] || !above[0] || !above[1]) continue;
      for (int k = 0; k < kWithinCell * kWithinCell; ++k) {
        const double u = (k % kWithinCell + 0.5) / kWithinCell;
        const double v = (k / kWithinCell + 0.5) / kWithinCell;
        const auto found = map.height_at(position_mm<frame::Nominal>(
            grid.x.at_mm(column) + u * grid.x.step_mm, grid.y.at_mm(row) + v * grid.y.step_mm));
        if (!found) continue;
        const Length low = (1 - u) * *first[0] + u * *first[1];
        const Length high = (1 - u) * *above[0] + u * *above[1];
        const Length between = (1 - v) * low + v * high;
        worst_mm = std::max(worst_mm, std::abs((between - (found->height.height - zero)).in_mm()));
      }
    }
  }
  return mm(worst_mm);
}

Length worst_sigma(const ZonedMap& map, const HeightGrid& grid) {
  Length out;
  std::size_t k = 0;
  for (int row = 0; row < grid.y.n_nodes; ++row) {
    for (int column = 0; column < grid.x.n_nodes; ++column) {
      if (!grid.heights[k++]) continue;
      const auto found =
          map.height_at(position_mm<frame::Nominal>(grid.x.at_mm(column), grid.y.at_mm(row)));
      if (found) out = std::max(out, found->height.sigma);
    }
  }
  return out;
}

Expected<std::string> grid_text(const SurfaceOptions& options,
                                const ZonedMap& map,
                                Length zero,
                                Exported& out) {
  PANELCAL_TRY(out.axes, grid_axes(kSurfaceExport, options.grid, map));
  PANELCAL_TRY(
      HeightGrid grid,
      height_grid(
          map, out.axes->x, out.axes->y, options.fill ? GridFill::Filled : GridFill::Measured));
  out.worst_sigma = worst_sigma(map, grid);
  for (std::optional<Length>& height : grid.heights) {
    if (height) *height = *height - zero;
    ++(height ? out.n_heights : out.n_missing);
  }
  out.worst_between = worst_between(map, grid, zero);
  return probe_file_text(out.format, grid);
}

Expected<std::string> points_text(const StoredZones& stored, Length zero, Exported& out) {
  std::vector<ProbePoint> points;
  for (std::size_t i = 0; i < stored.map.maps().size(); ++i) {
    std::ranges::move(stored.zone(i).kept_points(), std::back_inserter(points));
  }
  for (ProbePoint& point : points) {
    point.measured.height = point.measured.height - zero;
    out.worst_sigma = std::max(out.worst_sigma, point.measured.sigma);
  }
  out.n_heights = points.size();
  return probe_file_text(out.format, points);
}

std::string export_text(const SurfaceOptions& options, const Exported& made) {
  const auto line = [](std::string_view what, const std::string& text) {
    return fmt::format("{:<11}{}\n", what, text);
  };
  const std::string to = fmt::format(", written to {}", options.output);
  if (!made.axes) return line("probes", amount(made.n_heights, "height") + to);
  std::string out = line("grid",
                         fmt::format("{} x {} nodes every {:.3f} x {:.3f} mm, {}{}",
                                     made.axes->x.n_nodes,
                                     made.axes->y.n_nodes,
                                     made.axes->x.step_mm,
                                     made.axes->y.step_mm,
                                     amount(made.n_heights, "height"),
                                     to));
  if (made.n_missing > 0) {
    out += line("missing",
                fmt::format("{} that no probe vouches for{}",
                            amount(made.n_missing, "node"),
                            options.fill ? " or that lie outside of the probes"
                                         : "; --fill predicts those between the probes"));
  }
  out +=
      line("sigma", um_text(made.worst_sigma) + " at the worst node; the file has no place for it");
  return out + line("between",
                    "straight lines from node to node are off the map by up to " +
                        um_text(*made.worst_between));
}

facts::Json export_facts(const SurfaceOptions& options, const Exported& made) {
  facts::Json out = surface_envelope("export");
  out.update({{"file", options.output},
              {"format", name_of(made.format)},
              {"heights", made.n_heights},
              {"worst_sigma_um", made.worst_sigma.in_um()}});
  if (made.axes) {
    out.update({{"columns", made.axes->x.n_nodes},
                {"rows", made.axes->y.n_nodes},
                {"step_mm", {made.axes->x.step_mm, made.axes->y.step_mm}},
                {"missing", made.n_missing},
                {"worst_between_um", made.worst_between->in_um()}});
  }
  return out;
}

}  // namespace

Expected<Answer> export_map(const SurfaceOptions& options, CommandContext& context) {
  Exported made;
  PANELCAL_TRY(made.format, format_of(options));
  const bool is_log =
      made.format == ProbeFormat::LinuxCncLog || made.format == ProbeFormat::RecordedProbes;
  if (options.grid.empty() && !is_log) {
    return failure(usage(kSurfaceExport,
                         fmt::format("a file of format {} is a grid", name_of(made.format)),
                         "--grid NXxNY, such as 11x7"));
  }
  PANELCAL_TRY(const StoredZones stored, read_zoned_map_file(options.map));
  PANELCAL_TRY(const Length zero, zero_of(options, stored.map));
  auto text = options.grid.empty() ? points_text(stored, zero, made)
                                   : grid_text(options, stored.map, zero, made);
  if (!text) {
    Diagnostic problem = std::move(text).error();
    if (problem.place.file.empty()) problem.place.file = options.output;
    return failure(std::move(problem));
  }
  const auto document = [&] { return facts::text(export_facts(options, made)); };
  Answer answer = state_facts(context, options.facts, {}, document, {export_text(options, made)});
  if (answer.code != ExitCode::Done) return Answer{{}, answer.code};
  if (options.output != "-") {
    PANELCAL_CHECK(write_file(options.output, *text));
    return answer;
  }
  context.console.say(answer.text);
  answer.text = *std::move(text);
  return answer;
}

}  // namespace panelcal::surface
