// SPDX-License-Identifier: Apache-2.0
#include "panelcal/tools/surface_text.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

#include <fmt/format.h>

#include "panelcal/program/json_text.h"
#include "panelcal/tools/provenance.h"

namespace panelcal::surface {
namespace {

/// Of a list that may be long.
constexpr std::size_t kShown = 10;
/// Chances below are said to be below.
constexpr double kLeastChance = 1e-9;

std::string line(std::string_view what, std::string_view text) {
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

std::string and_more(std::size_t n) {
  return n > kShown ? fmt::format("  ... and {} more\n", n - kShown) : "";
}

std::string number(double value) {
  return std::isfinite(value) ? fmt::format("{:.9g}", value) : "null";
}

std::string point_json(const Position<frame::Nominal>& p) {
  return fmt::format("[{},{}]", number(p.in_mm().x()), number(p.in_mm().y()));
}

std::string text_json(std::string_view text) {
  std::string out;
  append_json_string(out, text);
  return out;
}

std::string extreme_json(const Extreme& extreme) {
  return fmt::format(
      R"({{"value":{},"at":{}}})", number(extreme.value.in_mm()), point_json(extreme.at));
}

}  // namespace

std::string um_text(Length value) {
  // Three digits, as nobody knows a sigma better.
  const double value_um = value.in_um();
  return fmt::format("{:.{}f} um", value_um, value_um >= 99.5 ? 0 : value_um >= 9.95 ? 1 : 2);
}

std::string place_text(const Position<frame::Nominal>& place) {
  return fmt::format("({:.3f}, {:.3f})", place.in_mm().x(), place.in_mm().y());
}

std::string left_out_text(const StoredMap& stored, const SurfaceOutlier& outlier) {
  const Place& from = stored.points[outlier.i_point].from;
  const std::string place = from.file.empty() ? "" : fmt::format("{}:{}: ", from.file, from.line);
  const std::string chance = outlier.chance < kLeastChance ? std::string("below 1e-9")
                                                           : fmt::format("{:.2g}", outlier.chance);
  return fmt::format("{}{}; chance of that {}", place, outlier.text(), chance);
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

std::string made_text(const MadeMap& made) {
  const StoredMap& stored = made.stored;
  const HeightMap& map = stored.map;
  const MapFacts& facts = made.facts;
  std::string out = line("map",
                         fmt::format("{} over {}{}{}",
                                     amount(stored.points.size(), "probe"),
                                     size_text(stored),
                                     made.file.empty() ? "" : ", written to ",
                                     made.file));
  out += line("model", map.surface().summary());
  out += line("why", map.reason());
  out += line("heights",
              fmt::format("{:.3f} to {:.3f} mm, a range of {}; lowest at {}, highest at {}",
                          facts.lowest.value.in_mm(),
                          facts.highest.value.in_mm(),
                          um_text(facts.highest.value - facts.lowest.value),
                          place_text(facts.lowest.at),
                          place_text(facts.highest.at)));
  out += line("residuals",
              fmt::format("{} rms about the surface, of probes that are said to scatter {}",
                          um_text(facts.residual_rms),
                          um_text(facts.stated_rms)));
  out += line("sigma",
              fmt::format("{} at worst, at {}; usually {}",
                          um_text(facts.worst_sigma.value),
                          place_text(facts.worst_sigma.at),
                          um_text(facts.usual_sigma)));
  out += line("coverage", coverage_text(facts));
  out += line("outside",
              fmt::format("heights up to {:g} mm outside of the probes, none beyond",
                          map.options().max_extrapolation.in_mm()));
  out +=
      line("lattice", fmt::format("true to the surface within {}", um_text(map.lattice_error())));
  out += line("left out", map.outliers().empty() ? "none" : amount(map.outliers().size(), "probe"));
  for (std::size_t i = 0; i < std::min(map.outliers().size(), kShown); ++i) {
    out += "  " + left_out_text(stored, map.outliers()[i]) + "\n";
  }
  out += and_more(map.outliers().size());
  if (made.missing.empty()) return out;
  out += line("not probed", amount(made.missing.size(), "place"));
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

std::string made_json(const MadeMap& made) {
  const HeightMap& map = made.stored.map;
  const MapFacts& facts = made.facts;
  std::string filled, left_out, missing;
  for (const FilledArea& area : facts.filled) {
    filled += fmt::format(R"({}{{"area_mm2":{},"middle":{}}})",
                          filled.empty() ? "" : ",",
                          number(area.area_mm2),
                          point_json(area.middle));
  }
  for (const SurfaceOutlier& outlier : map.outliers()) {
    const ProbePoint& probe = made.stored.points[outlier.i_point];
    left_out += fmt::format(
        R"({}{{"name":{},"file":{},"line":{},"place":{},"deviation":{},"sigma":{},"chance":{}}})",
        left_out.empty() ? "" : ",",
        text_json(outlier.name),
        text_json(probe.from.file),
        probe.from.line,
        point_json(probe.place),
        number(outlier.deviation.in_mm()),
        number(outlier.sigma.in_mm()),
        number(outlier.chance));
  }
  for (const MissingProbe& probe : made.missing) {
    missing += fmt::format(R"({}{{"name":{},"file":{},"line":{},"place":{},"reason":{}}})",
                           missing.empty() ? "" : ",",
                           text_json(probe.name),
                           text_json(probe.from.file),
                           probe.from.line,
                           point_json(probe.place),
                           text_json(probe.reason));
  }
  return fmt::format(
      R"({{"map":{},"probes":{},"model":"{}","summary":{},"reason":{},"lowest":{},"highest":{},)"
      R"("residual_rms":{},"stated_rms":{},"worst_sigma":{},"usual_sigma":{},"filled_share":{},)"
      R"("filled":[{}],"max_extrapolation":{},"lattice_error":{},"left_out":[{}],"missing":[{}]}})"
      "\n",
      text_json(made.file),
      made.stored.points.size(),
      word(map.surface().model()),
      text_json(map.surface().summary()),
      text_json(map.reason()),
      extreme_json(facts.lowest),
      extreme_json(facts.highest),
      number(facts.residual_rms.in_mm()),
      number(facts.stated_rms.in_mm()),
      extreme_json(facts.worst_sigma),
      number(facts.usual_sigma.in_mm()),
      number(facts.filled_share()),
      filled,
      number(map.options().max_extrapolation.in_mm()),
      number(map.lattice_error().in_mm()),
      left_out,
      missing);
}

}  // namespace panelcal::surface
