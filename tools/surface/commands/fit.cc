// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "machine/config/machine_config.h"
#include "machine/config/zones_file.h"
#include "surface/files/probe_file.h"
#include "surface/map/file.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/process/version.h"
#include "tools/surface/commands/subcommand.h"
#include "tools/surface/made_facts.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

const std::string kSurfaceFit = "panelcal surface fit";
/// Diameter of a usual probe's ball.
constexpr Length kUsualTip = mm(1);

std::vector<std::string> inputs_of(const SurfaceOptions& options) {
  std::vector<std::string> out = options.files;
  out.insert(out.end(), options.voids_of.begin(), options.voids_of.end());
  for (const std::string& file : {options.zones, options.machine}) {
    if (!file.empty()) out.push_back(file);
  }
  return out;
}

Expected<void> check_fit_outputs(const SurfaceOptions& options) {
  PANELCAL_CHECK(check_extension(kSurfaceFit, options.output, ".json"));
  PANELCAL_CHECK(check_extension(kSurfaceFit, options.facts.report, ".html"));
  return {};
}

/// All probes of all files, one after the other.
struct Probes {
  std::vector<ProbePoint> points;
  std::vector<MissingProbe> missing;
  std::vector<MapSource> sources;
  std::vector<ProbeSource> files;
  std::optional<int> z_axis;  ///< as in StoredMap
};

Expected<ProbeFileOptions> reading_of(const SurfaceOptions& options) {
  ProbeFileOptions reading;
  if (!options.format.empty()) reading.format = probe_format_from_name(options.format);
  if (options.sigma_um) reading.sigma = um(*options.sigma_um);
  if (!options.unit.empty()) reading.unit = options.unit == "inch" ? inch(1) : mm(1);
  reading.z_axis = options.z_axis;
  reading.profile = options.profile;
  if (options.mesh_mm.empty()) return reading;
  const Eigen::Vector2d low_mm(options.mesh_mm[0], options.mesh_mm[1]);
  const Eigen::Vector2d high_mm(options.mesh_mm[2], options.mesh_mm[3]);
  if (!((high_mm - low_mm).minCoeff() > 0 && (high_mm - low_mm).allFinite())) {
    return failure(usage(kSurfaceFit,
                         "--mesh-mm has no width or no height",
                         "X0,Y0,X1,Y1 with X0 < X1 and Y0 < Y1, mm"));
  }
  reading.mesh = {low_mm, high_mm};
  return reading;
}

Expected<Probes> read_all(const SurfaceOptions& options) {
  PANELCAL_TRY(const ProbeFileOptions reading, reading_of(options));
  Probes out;
  for (const std::string& file : options.files) {
    PANELCAL_TRY(const std::string bytes, read_file(file, kMaxProbeFileBytes));
    PANELCAL_TRY(ProbeFile read, parse_probe_file(bytes, file, reading));
    if (read.z_axis && out.z_axis && *read.z_axis != *out.z_axis) {
      return failure(
          {Code::MeasurementFile,
           {file, 0, 0},
           fmt::format("probes of zaxis {}, behind those of zaxis {}", *read.z_axis, *out.z_axis),
           "one Z axis a map: --zaxis"});
    }
    if (read.z_axis) out.z_axis = read.z_axis;
    out.files.push_back(
        {file, read.format, read.unit, read.zero, read.points.size(), read.missing.size()});
    std::ranges::move(read.points, std::back_inserter(out.points));
    std::ranges::move(read.missing, std::back_inserter(out.missing));
    out.sources.push_back({file, sha256(bytes)});
  }
  return out;
}

Expected<HeightMapOptions> map_options(const SurfaceOptions& options) {
  HeightMapOptions out;
  out.model = surface_model(options.model);
  if (!options.machine.empty()) {
    PANELCAL_TRY(const MachineConfig config, read_machine_config(options.machine));
    out.max_extrapolation = config.walk.sieb_meyer.grid_hold;
  }
  if (options.max_extrapolation_mm) out.max_extrapolation = mm(*options.max_extrapolation_mm);
  return out;
}

/// Zones and voids of --zones, and voids of --voids-of behind them.
struct Layout {
  std::vector<Zone> zones;
  Voids voids;
  std::vector<std::string> format_files;  ///< of the programs that leave voids, as ProgramHead
};

Expected<Layout> read_layout(const SurfaceOptions& options,
                             const HeightMapOptions& defaults,
                             CommandContext& context) {
  ZonesFile file;
  if (!options.zones.empty()) {
    PANELCAL_TRY(file, read_zones_file(options.zones, defaults));
  }
  std::vector<std::string> format_files;
  for (const std::string& program : options.voids_of) {
    PANELCAL_TRY(ProgramVoids of, program_voids(program, options, context));
    std::ranges::move(of.voids, std::back_inserter(file.voids));
    const bool is_new = std::ranges::find(format_files, of.format_file) == format_files.end();
    if (!of.format_file.empty() && is_new) format_files.push_back(std::move(of.format_file));
  }
  const Length tip =
      options.probe_tip_mm ? mm(*options.probe_tip_mm) : file.probe_tip.value_or(kUsualTip);
  PANELCAL_TRY(Voids voids, Voids::make(std::move(file.voids), 0.5 * tip));
  return Layout{std::move(file.zones), std::move(voids), std::move(format_files)};
}

/// No reader would accept the file.
Expected<void> check_map_size(const std::string& text) {
  if (text.size() <= kMaxMapBytes) return {};
  return failure({Code::NotSupported,
                  {},
                  fmt::format("a map of {} bytes", text.size()),
                  fmt::format("at most {}: fewer voids", kMaxMapBytes)});
}

}  // namespace

Expected<Answer> fit(const SurfaceOptions& options, CommandContext& context) {
  PANELCAL_CHECK(check_fit_outputs(options));
  PANELCAL_TRY(const HeightMapOptions how, map_options(options));
  PANELCAL_TRY(Layout layout, read_layout(options, how, context));
  PANELCAL_TRY(Probes probes, read_all(options));
  context.console.progress("fitting a surface to the probes");
  auto map =
      ZonedMap::of_probes(probes.points, std::move(layout.zones), std::move(layout.voids), how);
  if (!map) {
    Diagnostic problem = std::move(map).error();
    if (problem.place.file.empty()) problem.place.file = options.files.front();
    return failure(std::move(problem));
  }
  const MadeMap made = made_map({std::move(probes.points),
                                 *std::move(map),
                                 std::move(probes.sources),
                                 std::string("panelcal ") + kVersion,
                                 probes.z_axis},
                                std::move(probes.missing),
                                options.output,
                                std::move(probes.files));
  const std::string text = map_file_text(made.stored);
  PANELCAL_CHECK(check_map_size(text));
  PANELCAL_CHECK(write_file(options.output, text));
  std::vector<std::string> inputs = inputs_of(options);
  std::ranges::move(layout.format_files, std::back_inserter(inputs));
  const auto document = [&] {
    return facts::text(made_facts(made, provenance_of(context, inputs)));
  };
  return state_facts(
      context, options.facts, "Surface map " + made.file, document, {made_text(made)});
}

}  // namespace panelcal::surface
