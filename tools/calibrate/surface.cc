// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "machine/calibrate/kinds/kinds.h"
#include "machine/calibrate/surface/record.h"
#include "machine/calibrate/surface/run.h"
#include "surface/map/file.h"
#include "tools/calibrate/session.h"
#include "tools/surface/difference.h"
#include <fmt/format.h>

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
Expected<std::optional<MapInForce>> compared(const Ledger* ledger,
                                             const Calibration& kind,
                                             const StoredMap& stored) {
  std::optional<MapInForce> out;
  if (ledger == nullptr) return out;
  PANELCAL_TRY(const std::optional<std::string> text, kind.text_in_force(*ledger));
  if (!text) return out;
  PANELCAL_TRY(StoredMap before, parse_map_file(*text, "the ledger"));
  auto change = change_between(before, stored);
  if (change) out.emplace(MapInForce{std::move(before), *std::move(change)});
  return out;
}

surface::ComparedMaps with_in_force(const std::string& file,
                                    const GivenMap& given,
                                    const MapInForce& before) {
  return {"the map in force", file, before.stored, given.stored, before.change.difference};
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
  return out + surface::difference_text(with_in_force(options.map, given, *before));
}

/// Of the file that is installed: -o, else that of nights.
std::unique_ptr<Calibration> map_kind_of(const CalibrateOptions& options,
                                         const std::shared_ptr<MachineConfig>& config) {
  NightlyConfig nightly = config->nightly.value_or(NightlyConfig());
  if (!options.output.empty()) nightly.surface.file = options.output;
  return surface_kind(config, nightly);
}

}  // namespace

Expected<Answer> surface(const CalibrateOptions& options, CommandContext& context) {
  PANELCAL_TRY(Session session, Session::begin(options));
  const MachineConfig& config = *session.config();
  PANELCAL_TRY(const GivenMap given, read_given(options, config));
  PANELCAL_CHECK(session.lock(false));
  PANELCAL_CHECK(session.open_ledger());
  const std::unique_ptr<Calibration> kind = map_kind_of(options, session.config());
  PANELCAL_TRY(const auto before, compared(session.ledger(), *kind, given.stored));
  const auto change = before ? std::optional(before->change) : std::nullopt;
  PANELCAL_TRY(LedgerDraft draft,
               surface_draft(config, given.stored, given.figures, change, session.words()));
  PANELCAL_TRY(LedgerInput input, input_of(options.map, kMaxMapBytes));
  draft.record.inputs.push_back(std::move(input));
  PANELCAL_CHECK(session.finish(std::move(draft), *kind, refusal(given, config)));
  facts::Json part = {{"map", options.map},
                      {"probes", given.stored.points.size()},
                      {"left_out", given.stored.map.outliers().size()}};
  if (before) {
    part["change"] = surface::difference_facts(with_in_force(options.map, given, *before), {});
  }
  return session.answer(
      surface_text(options, given, before) + session.verdict_line(), std::move(part), context);
}

}  // namespace panelcal::calibrate
