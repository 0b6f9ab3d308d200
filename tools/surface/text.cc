// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/text.h"

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>
#include <variant>

#include "tools/cli/provenance.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

/// Of a list that may be long.
constexpr std::size_t kShown = 10;
/// Chances below are said to be below.
constexpr double kLeastChance = 1e-9;

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

/// The format, unit and zero of each file.
std::string source_lines(const MadeMap& made) {
  std::string out;
  for (std::size_t i = 0; i < std::min(made.sources.size(), kShown); ++i) {
    const ProbeSource& source = made.sources[i];
    out += map_line("read",
                    fmt::format("{}: format {}, {}; unit {}; from {}",
                                source.file,
                                name_of(source.format),
                                amount(source.n_probes, "probe"),
                                source.unit,
                                source.zero));
  }
  return out + and_more(made.sources.size());
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

}  // namespace

MadeMap made_map(StoredZones stored,
                 std::vector<MissingProbe> missing,
                 std::string file,
                 std::vector<ProbeSource> sources) {
  MadeMap out{std::move(stored), {}, std::move(missing), std::move(file), std::move(sources)};
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
  out += source_lines(made);
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

}  // namespace panelcal::surface
