// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/text.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>
#include <variant>

#include "calib/base/json/json_string.h"
#include "tools/cli/provenance.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

/// Of a list that may be long.
constexpr std::size_t kShown = 10;
/// Chances below are said to be below.
constexpr double kLeastChance = 1e-9;
/// In a mm: less is rounding, which differs from compiler to compiler.
constexpr double kPicometres = 1e9;

std::string map_line(std::string_view what, std::string_view text) {
  return fmt::format("{:<11}{}\n", what, text);
}

std::string size_text(const StoredMap& stored) {
  Eigen::Vector2d low_mm = stored.map.hull().front().in_mm(), high_mm = low_mm;
  for (const auto& corner : stored.map.hull()) {
    low_mm = low_mm.cwiseMin(corner.in_mm());
    high_mm = high_mm.cwiseMax(corner.in_mm());
  }
  return fmt::format("{:.1f} x {:.1f} mm", high_mm.x() - low_mm.x(), high_mm.y() - low_mm.y());
}

std::string from_text(const Place& from) {
  return from.file.empty() ? "" : fmt::format("{}:{}: ", from.file, from.line);
}

std::string and_more(std::size_t n) {
  return n > kShown ? fmt::format("  ... and {} more\n", n - kShown) : "";
}

std::string surface_number(double value) {
  return std::isfinite(value) ? fmt::format("{:.9g}", value) : "null";
}

std::string map_point_json(const Position<frame::Nominal>& p) {
  return fmt::format("[{},{}]", surface_number(p.in_mm().x()), surface_number(p.in_mm().y()));
}

std::string text_json(std::string_view text) {
  std::string out;
  append_json_string(out, text);
  return out;
}

std::string extreme_json(const Extreme& extreme) {
  return fmt::format(R"({{"value":{},"at":{}}})",
                     surface_number(extreme.value.in_mm()),
                     map_point_json(extreme.at));
}

}  // namespace

std::string um_text(Length value) {
  // Three digits: no sigma is known better.
  const double value_um = value.in_um();
  return fmt::format("{:.{}f} um", value_um, value_um >= 99.5 ? 0 : value_um >= 9.95 ? 1 : 2);
}

std::string place_text(const Position<frame::Nominal>& place) {
  return fmt::format("({:.3f}, {:.3f})", place.in_mm().x(), place.in_mm().y());
}

std::string left_out_text(const StoredMap& stored, const SurfaceOutlier& outlier) {
  const std::string chance = outlier.chance < kLeastChance ? std::string("below 1e-9")
                                                           : fmt::format("{:.2g}", outlier.chance);
  return fmt::format("{}{}; chance of that {}",
                     from_text(stored.points[outlier.i_point].from),
                     outlier.text(),
                     chance);
}

std::string unused_text(const StoredZones& stored, const UnusedProbe& unused) {
  const ProbePoint& probe = stored.points[unused.i_point];
  return fmt::format("{}{} at {}: {}",
                     from_text(probe.from),
                     probe.name.empty() ? "probe" : probe.name,
                     place_text(probe.place),
                     unused.reason);
}

std::string voids_text(const Voids& voids) {
  std::size_t n_round = 0, n_routed = 0;
  for (const Void& one : voids.all()) {
    n_round += std::holds_alternative<Circle>(one.area) ? 1 : 0;
    n_routed += std::holds_alternative<Track>(one.area) ? 1 : 0;
  }
  const std::size_t n = voids.all().size();
  return fmt::format("{}: {} round, {} routed, {} other; no probe counts within {:g} mm of one",
                     n,
                     n_round,
                     n_routed,
                     n - n_round - n_routed,
                     voids.margin().in_mm());
}

std::string coverage_text(const MapFacts& facts) {
  if (facts.filled.empty()) return "whole: a probe vouches for every place between the probes";
  std::string text = fmt::format("{}, {:.1f} % of the area between the probes, only filled:",
                                 amount(facts.filled.size(), "gap"),
                                 100 * facts.filled_share());
  for (std::size_t i = 0; i < std::min<std::size_t>(facts.filled.size(), 3); ++i) {
    text += fmt::format("{} {:.0f} mm^2 about ({:.0f}, {:.0f})",
                        i > 0 ? "," : "",
                        facts.filled[i].area_mm2,
                        facts.filled[i].middle.in_mm().x(),
                        facts.filled[i].middle.in_mm().y());
  }
  return text + (facts.filled.size() > 3 ? ", ..." : "");
}

namespace {

std::string zone_text(const MadeZone& zone) {
  const StoredMap& stored = zone.stored;
  const HeightMap& map = stored.map;
  const MapFacts& facts = zone.facts;
  std::string out = map_line("model", map.surface().summary());
  out += map_line("why", map.reason());
  out += map_line("heights",
                  fmt::format("{:.3f} to {:.3f} mm, a range of {}; lowest at {}, highest at {}",
                              facts.lowest.value.in_mm(),
                              facts.highest.value.in_mm(),
                              um_text(facts.highest.value - facts.lowest.value),
                              place_text(facts.lowest.at),
                              place_text(facts.highest.at)));
  out += map_line("residuals",
                  fmt::format("{} rms about the surface; stated sigma of the probes {}",
                              um_text(facts.residual_rms),
                              um_text(facts.stated_rms)));
  out += map_line("sigma",
                  fmt::format("{} at worst, at {}; usually {}",
                              um_text(facts.worst_sigma.value),
                              place_text(facts.worst_sigma.at),
                              um_text(facts.usual_sigma)));
  out += map_line("coverage", coverage_text(facts));
  out += map_line("outside",
                  fmt::format("heights up to {:g} mm outside of the probes, none beyond",
                              map.options().max_extrapolation.in_mm()));
  out += map_line("lattice",
                  fmt::format("true to the surface within {}", um_text(map.lattice_error())));
  out += map_line("left out",
                  map.outliers().empty() ? "none" : amount(map.outliers().size(), "probe"));
  for (std::size_t i = 0; i < std::min(map.outliers().size(), kShown); ++i) {
    out += "  " + left_out_text(stored, map.outliers()[i]) + "\n";
  }
  return out + and_more(map.outliers().size());
}

std::string unused_lines(const MadeMap& made) {
  const auto unused = made.stored.map.unused();
  if (unused.empty()) return {};
  std::string out = map_line("not used", amount(unused.size(), "probe"));
  for (std::size_t i = 0; i < std::min(unused.size(), kShown); ++i) {
    out += "  " + unused_text(made.stored, unused[i]) + "\n";
  }
  return out + and_more(unused.size());
}

std::string missing_lines(const MadeMap& made) {
  if (made.missing.empty()) return {};
  std::string out = map_line("not probed", amount(made.missing.size(), "place"));
  for (std::size_t i = 0; i < std::min(made.missing.size(), kShown); ++i) {
    const MissingProbe& missing = made.missing[i];
    out += fmt::format("  {}:{}: {} at {}: {}\n",
                       missing.from.file,
                       missing.from.line,
                       missing.name,
                       place_text(missing.place),
                       missing.reason);
  }
  return out + and_more(made.missing.size());
}

/// The keys that a map has for each of its zones, without braces.
/// In     n_probes: that were read for it
std::string zone_json(const MadeZone& zone, std::size_t n_probes) {
  const StoredMap& stored = zone.stored;
  const HeightMap& map = stored.map;
  const MapFacts& facts = zone.facts;
  std::string filled, left_out;
  for (const FilledArea& area : facts.filled) {
    filled += fmt::format(R"({}{{"area_mm2":{},"middle":{}}})",
                          filled.empty() ? "" : ",",
                          surface_number(area.area_mm2),
                          map_point_json(area.middle));
  }
  for (const SurfaceOutlier& outlier : map.outliers()) {
    const ProbePoint& probe = stored.points[outlier.i_point];
    left_out += fmt::format(
        R"({}{{"name":{},"file":{},"line":{},"place":{},"deviation":{},"sigma":{},"chance":{}}})",
        left_out.empty() ? "" : ",",
        text_json(outlier.name),
        text_json(probe.from.file),
        probe.from.line,
        map_point_json(probe.place),
        surface_number(outlier.deviation.in_mm()),
        surface_number(outlier.sigma.in_mm()),
        surface_number(outlier.chance));
  }
  return fmt::format(
      R"("probes":{},"model":"{}","summary":{},"reason":{},"lowest":{},"highest":{},)"
      R"("residual_rms":{},"stated_rms":{},"worst_sigma":{},"usual_sigma":{},"filled_share":{},)"
      R"("filled":[{}],"max_extrapolation":{},"lattice_error":{},"left_out":[{}])",
      n_probes,
      word(map.surface().model()),
      text_json(map.surface().summary()),
      text_json(map.reason()),
      extreme_json(facts.lowest),
      extreme_json(facts.highest),
      surface_number(facts.residual_rms.in_mm()),
      surface_number(facts.stated_rms.in_mm()),
      extreme_json(facts.worst_sigma),
      surface_number(facts.usual_sigma.in_mm()),
      surface_number(facts.filled_share()),
      filled,
      surface_number(map.options().max_extrapolation.in_mm()),
      surface_number(std::round(map.lattice_error().in_mm() * kPicometres) / kPicometres),
      left_out);
}

/// A probe that makes no surface, and why.
std::string refused_json(std::string_view name,
                         const Place& from,
                         const Position<frame::Nominal>& place,
                         std::string_view reason) {
  return fmt::format(R"({{"name":{},"file":{},"line":{},"place":{},"reason":{}}})",
                     text_json(name),
                     text_json(from.file),
                     from.line,
                     map_point_json(place),
                     text_json(reason));
}

}  // namespace

MadeMap made_map(StoredZones stored, std::vector<MissingProbe> missing, std::string file) {
  MadeMap out{std::move(stored), {}, std::move(missing), std::move(file)};
  const ZonedMap& map = out.stored.map;
  for (std::size_t i = 0; i < map.maps().size(); ++i) {
    StoredMap zone = out.stored.zone(i);
    MapFacts facts = facts_of(zone, [&](const Position<frame::Nominal>& place) {
      return map.zone_at(place) == i && map.voids().at(place) == nullptr;
    });
    out.zones.push_back({map.zones().empty() ? std::string() : map.zones()[i].name,
                         std::move(zone),
                         std::move(facts)});
  }
  return out;
}

std::string made_text(const MadeMap& made) {
  const Voids& voids = made.stored.map.voids();
  std::string out =
      map_line("map",
               fmt::format("{} {}{}{}",
                           amount(made.stored.points.size(), "probe"),
                           made.has_zones() ? "in " + amount(made.zones.size(), "zone")
                                            : "over " + size_text(made.zones[0].stored),
                           made.file.empty() ? "" : ", written to ",
                           made.file));
  if (!voids.all().empty()) out += map_line("voids", voids_text(voids));
  if (!made.has_zones()) out += zone_text(made.zones[0]);
  out += unused_lines(made) + missing_lines(made);
  if (!made.has_zones()) return out;
  for (const MadeZone& zone : made.zones) {
    out += "\n" + map_line("zone",
                           fmt::format("{}: {} over {}",
                                       zone.name,
                                       amount(zone.stored.points.size(), "probe"),
                                       size_text(zone.stored)));
    out += zone_text(zone);
  }
  return out;
}

std::string made_json(const MadeMap& made) {
  std::string zones, unused, missing;
  for (const MadeZone& zone : made.zones) {
    zones += fmt::format(R"({}{{"name":{},{}}})",
                         zones.empty() ? "" : ",",
                         text_json(zone.name),
                         zone_json(zone, zone.stored.points.size()));
  }
  for (const UnusedProbe& one : made.stored.map.unused()) {
    const ProbePoint& probe = made.stored.points[one.i_point];
    unused +=
        (unused.empty() ? "" : ",") + refused_json(probe.name, probe.from, probe.place, one.reason);
  }
  for (const MissingProbe& probe : made.missing) {
    missing += (missing.empty() ? "" : ",") +
               refused_json(probe.name, probe.from, probe.place, probe.reason);
  }
  return fmt::format(
      R"({{"map":{},{},"voids":{},"unused":[{}],"missing":[{}]}})"
      "\n",
      text_json(made.file),
      made.has_zones()
          ? fmt::format(R"("probes":{},"zones":[{}])", made.stored.points.size(), zones)
          : zone_json(made.zones[0], made.stored.points.size()),
      made.stored.map.voids().all().size(),
      unused,
      missing);
}

}  // namespace panelcal::surface
