// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "machine/calibrate/surface/record.h"
#include "machine/calibrate/surface/run.h"
#include "surface/map/file.h"
#include "tools/calibrate/calibrate.h"
#include "tools/calibrate/record.h"
#include "tools/surface/difference.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal::calibrate {
namespace {

/// A map that was probed by hand, and its figures of the table.
struct GivenMap {
  StoredMap stored;
  SurfaceFigures figures;
};

/// Over the area that nights probe, so that they compare; else over the map's probes.
Expected<GivenMap> read_given(const CalibrateOptions& options, const MachineConfig& config) {
  PANELCAL_TRY(StoredMap stored, read_map_file(options.map));
  const bool is_of_nights = config.nightly && !config.nightly->surface.file.empty();
  const SurfaceArea area = is_of_nights ? area_of(config.nightly->surface) : area_of(stored.map);
  auto figures = figures_of(stored.map, area);
  if (figures) return GivenMap{std::move(stored), *std::move(figures)};
  Diagnostic problem = std::move(figures).error();
  problem.place = {options.map, 0, 0};
  return failure(std::move(problem));
}

/// Nights are held to it as well.
std::string refusal(const GivenMap& given, const MachineConfig& config) {
  if (!config.nightly || config.nightly->surface.file.empty()) return {};
  const Length sigma = largest_sigma(given.stored.map, given.figures.area);
  const Length limit = config.nightly->surface.sigma;
  if (sigma <= limit) return {};
  return fmt::format("sigma of the map is up to {:.1f} um, limit {:.1f} um ([nightly.surface])",
                     sigma.in_um(),
                     limit.in_um());
}

/// Map in force, and the change against it.
struct MapInForce {
  StoredMap stored;
  SurfaceChange change;
};

/// Empty where there is none, and where the two cannot be compared.
Expected<std::optional<MapInForce>> compared(const Recorder& recorder,
                                             const LedgerKey& key,
                                             const StoredMap& stored) {
  std::optional<MapInForce> out;
  PANELCAL_TRY(const std::optional<std::string> text, recorder.text_in_force(key));
  if (!text) return out;
  PANELCAL_TRY(StoredMap before, parse_map_file(*text, "the ledger"));
  auto change = change_between(before, stored);
  if (change) out.emplace(MapInForce{std::move(before), *std::move(change)});
  return out;
}

std::string surface_text(const CalibrateOptions& options,
                         const GivenMap& given,
                         const std::optional<MapInForce>& before) {
  const HeightMap& map = given.stored.map;
  std::string out = fmt::format("{}: {} probes, {} make the map: {}\n",
                                options.map,
                                given.stored.points.size(),
                                map.kept().size(),
                                map.surface().summary());
  for (const SurfaceOutlier& outlier : map.outliers()) out += "left out: " + outlier.text() + "\n";
  out += report(given.figures);
  if (!before) return out;
  return out + surface::difference_text({"the map in force",
                                         options.map,
                                         before->stored,
                                         given.stored,
                                         before->change.difference});
}

std::string surface_json(const CalibrateOptions& options,
                         const GivenMap& given,
                         const std::optional<MapInForce>& before,
                         const std::string& refused,
                         const std::optional<std::int64_t>& entry) {
  nlohmann::ordered_json json;
  json["map"] = options.map;
  json["probes"] = given.stored.points.size();
  json["left_out"] = given.stored.map.outliers().size();
  for (int i = 0; i < SurfaceFigures::kSize; ++i) {
    const std::string name(SurfaceFigures::kNames[static_cast<std::size_t>(i)]);
    json["figures_mm"][name] = {{"value", given.figures.value_mm[i]},
                                {"sigma", std::sqrt(given.figures.cov_mm2(i, i))}};
  }
  if (before) {
    const surface::ComparedMaps maps = {
        "the map in force", options.map, before->stored, given.stored, before->change.difference};
    json["change"] = surface::difference_figures(maps);
  }
  if (!refused.empty()) json["refusal"] = refused;
  if (entry) json["ledger"] = *entry;
  return json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) + "\n";
}

/// Path of an installed map: -o, else the file of nights.
std::filesystem::path file_of(const CalibrateOptions& options, const MachineConfig& config) {
  if (!options.output.empty() || !config.nightly) return options.output;
  return config.nightly->surface.file;
}

}  // namespace

Expected<Answer> surface(const CalibrateOptions& options, CommandContext& /*context*/) {
  PANELCAL_TRY(RecordWords words, words_of(options));
  PANELCAL_TRY(const MachineConfig config, read_machine_config(options.machine));
  PANELCAL_TRY(const GivenMap given, read_given(options, config));
  PANELCAL_TRY(Recorder recorder, Recorder::open(options, config, words.date, false));
  const std::string refused = options.force ? std::string() : refusal(given, config);
  PANELCAL_TRY(const auto before, compared(recorder, surface_key(config), given.stored));
  std::optional<std::int64_t> entry;
  if (options.install) {
    judge(refused, words);
    const auto change = before ? std::optional(before->change) : std::nullopt;
    PANELCAL_TRY(LedgerDraft draft,
                 surface_draft(config, given.stored, given.figures, change, words));
    PANELCAL_TRY(LedgerInput input, input_of(options.map, kMaxMapBytes));
    draft.record.inputs.push_back(std::move(input));
    PANELCAL_TRY(entry, recorder.record(draft, file_of(options, config)));
  } else if (!options.output.empty() && refused.empty()) {
    PANELCAL_TRY(const std::string text, text_with_head(config, map_file_text(given.stored)));
    PANELCAL_CHECK(write_file(options.output, text));
  }
  const ExitCode code = refused.empty() ? ExitCode::Done : ExitCode::GateFailed;
  if (options.json) return Answer{surface_json(options, given, before, refused, entry), code};
  return Answer{surface_text(options, given, before) + verdict_line(refused, entry), code};
}

}  // namespace panelcal::calibrate
