// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/made_facts.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tools/surface/shapes.h"

namespace panelcal::surface {
namespace {

using facts::Json;

constexpr int kSurfaceVersion = 1;
/// Of what is drawn: 10 nm of height, 1 nm of sigma.
constexpr double kHeightsPerMm = 1e5;
constexpr double kSigmasPerUm = 1e3;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

Json point_mm(const Position<frame::Nominal>& place) {
  return facts::point(place.in_mm());
}

Json height_extreme(const Extreme& extreme) {
  return {{"height_mm", extreme.value.in_mm()}, {"at_mm", point_mm(extreme.at)}};
}

/// A probe that makes no surface, and why.
Json refused(const std::string& name,
             const Place& from,
             const Position<frame::Nominal>& place,
             const std::string& reason) {
  return {{"name", name},
          {"file", from.file},
          {"line", from.line},
          {"place_mm", point_mm(place)},
          {"reason", reason}};
}

Json left_out_facts(const StoredMap& stored) {
  Json out = Json::array();
  for (const SurfaceOutlier& outlier : stored.map.outliers()) {
    const ProbePoint& probe = stored.points[outlier.i_point];
    out.push_back({{"name", outlier.name},
                   {"file", probe.from.file},
                   {"line", probe.from.line},
                   {"place_mm", point_mm(probe.place)},
                   {"height_mm", probe.measured.height.in_mm()},
                   {"deviation_mm", outlier.deviation.in_mm()},
                   {"sigma_um", outlier.sigma.in_um()},
                   {"chance", outlier.chance}});
  }
  return out;
}

/// Columns of the probes that make the surface.
Json kept_facts(const StoredMap& stored) {
  const HeightMap& map = stored.map;
  std::vector<double> x_mm, y_mm, height_mm, sigma_um, residual_um, deviation_um, chance;
  std::vector<std::uint32_t> line;
  std::vector<std::string> names, files;
  for (std::size_t k = 0; k < map.kept().size(); ++k) {
    const ProbePoint& probe = stored.points[map.kept()[k]];
    const LeftOutProbe& left_out = map.surface().left_out()[k];
    x_mm.push_back(probe.place.in_mm().x());
    y_mm.push_back(probe.place.in_mm().y());
    height_mm.push_back(probe.measured.height.in_mm());
    sigma_um.push_back(probe.measured.sigma.in_um());
    residual_um.push_back((probe.measured.height - map.surface().at(probe.place).height).in_um());
    deviation_um.push_back(left_out.deviation ? left_out.deviation->in_um() : kNone);
    chance.push_back(left_out.deviation ? left_out.chance : kNone);
    line.push_back(static_cast<std::uint32_t>(probe.from.line));
    names.push_back(name_of(probe));
    files.push_back(probe.from.file);
  }
  return {{"x_mm", column(x_mm)},
          {"y_mm", column(y_mm)},
          {"height_mm", column(height_mm)},
          {"sigma_um", column(sigma_um)},
          {"residual_um", column(residual_um)},
          {"deviation_um", column(deviation_um)},
          {"chance", column(chance)},
          {"name", word_column(names)},
          {"file", word_column(files)},
          {"line", column(line)}};
}

/// Heights and sigmas for pictures; null where the map gives none.
Json field_facts(const MadeMap& made, std::size_t i_zone) {
  const HeightMap& map = made.zones[i_zone].stored.map;
  std::vector<Eigen::Vector2d> hull_mm;
  for (const auto& corner : map.hull()) hull_mm.push_back(corner.in_mm());
  const PictureGrid grid(hull_mm, map.options().max_extrapolation);
  Json out = grid.facts();
  Json heights = Json::array(), sigmas = Json::array();
  // A letter for each node: measured, filled, extrapolated, blank, or - for no height.
  std::string sources;
  for (const auto& node : grid.nodes()) {
    const auto found = map.height_at(node);
    heights.push_back(
        found ? Json(std::round(found->height.in_mm() * kHeightsPerMm) / kHeightsPerMm) : Json());
    sigmas.push_back(found ? Json(std::round(found->sigma.in_um() * kSigmasPerUm) / kSigmasPerUm)
                           : Json());
    sources += !found                                    ? '-'
               : is_blank(made.stored.map, i_zone, node) ? 'b'
                                                         : source_word(found->source).front();
  }
  out["height_mm"] = std::move(heights);
  out["sigma_um"] = std::move(sigmas);
  out["source"] = std::move(sources);
  return out;
}

}  // namespace

Json surface_envelope(std::string_view command) {
  Json out = facts::envelope("surface", kSurfaceVersion);
  out["command"] = command;
  return out;
}

Json provenance_facts(const Provenance& provenance) {
  Json out = Json::array();
  for (const auto& [what, value] : provenance) out.push_back({what, value});
  return out;
}

std::string_view source_word(HeightSource source) {
  switch (source) {
    case HeightSource::Measured:
      return "measured";
    case HeightSource::Filled:
      return "filled";
    case HeightSource::InVoid:
      return "void";
    case HeightSource::Extrapolated:
      break;
  }
  return "extrapolated";
}

Json zone_facts(const MadeMap& made, std::size_t i_zone) {
  const MadeZone& zone = made.zones[i_zone];
  const HeightMap& map = zone.stored.map;
  const MapFacts& figures = zone.facts;
  Json filled = Json::array();
  for (const FilledArea& area : figures.filled) {
    filled.push_back({{"area_mm2", area.area_mm2}, {"middle_mm", point_mm(area.middle)}});
  }
  Json out = {{"name", zone.name},
              {"probes", zone.stored.points.size()},
              {"model", word(map.surface().model())},
              {"summary", map.surface().summary()},
              {"reason", map.reason()},
              {"lowest", height_extreme(figures.lowest)},
              {"highest", height_extreme(figures.highest)},
              {"residual_rms_um", figures.residual_rms.in_um()},
              {"stated_rms_um", figures.stated_rms.in_um()},
              {"worst_sigma",
               {{"sigma_um", figures.worst_sigma.value.in_um()},
                {"at_mm", point_mm(figures.worst_sigma.at)}}},
              {"usual_sigma_um", figures.usual_sigma.in_um()},
              {"filled_share", figures.filled_share()},
              {"filled", std::move(filled)},
              {"max_extrapolation_mm", map.options().max_extrapolation.in_mm()},
              {"reach_mm", facts::point(*map.options().reach_mm)},
              {"lattice_error_um", map.lattice_error().in_um()},
              {"hull_mm", corners(map.hull())}};
  if (made.has_zones()) out["border_mm"] = border(made.stored.map.zones()[i_zone].area);
  out["left_out"] = left_out_facts(zone.stored);
  out["kept"] = kept_facts(zone.stored);
  out["field"] = field_facts(made, i_zone);
  return out;
}

Json made_facts(const MadeMap& made, const Provenance& provenance) {
  Json out = surface_envelope("fit");
  out["map"] = made.file;
  out["probes"] = made.stored.points.size();
  for (const ProbeSource& source : made.sources) {
    out["sources"].push_back({{"file", source.file},
                              {"format", name_of(source.format)},
                              {"unit", source.unit},
                              {"zero", source.zero},
                              {"probes", source.n_probes},
                              {"missing", source.n_missing}});
  }
  out["zones"] = Json::array();
  for (std::size_t i = 0; i < made.zones.size(); ++i) out["zones"].push_back(zone_facts(made, i));
  out["voids"] = voids_facts(made.stored.map.voids());
  out["unused"] = Json::array();
  for (const UnusedProbe& one : made.stored.map.unused()) {
    const ProbePoint& probe = made.stored.points[one.i_point];
    out["unused"].push_back(refused(probe.name, probe.from, probe.place, one.reason));
  }
  out["missing"] = Json::array();
  for (const MissingProbe& probe : made.missing) {
    out["missing"].push_back(refused(probe.name, probe.from, probe.place, probe.reason));
  }
  out["provenance"] = provenance_facts(provenance);
  return out;
}

}  // namespace panelcal::surface
