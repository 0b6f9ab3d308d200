// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/difference.h"

#include <algorithm>
#include <cmath>

#include "tools/surface/made_facts.h"
#include "tools/surface/shapes.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

using facts::Json;

/// Differences are drawn to 10 nm.
constexpr double kPicturedPerUm = 100;
constexpr double kPicturedPerMm = 1e3 * kPicturedPerUm;

std::string difference_line(std::string_view what, std::string_view text) {
  return fmt::format("{:<11}{}\n", what, text);
}

std::string with_sigma(const Measured& measured, std::string_view unit) {
  // Two digits of sigma.
  const int n_decimals =
      std::clamp(1 - static_cast<int>(std::floor(std::log10(measured.sigma))), 0, 6);
  return fmt::format(
      "{:+.{}f} +- {:.{}f} {}", measured.value, n_decimals, measured.sigma, n_decimals, unit);
}

std::string difference_chance_text(double chance) {
  return chance < 1e-9 ? "below 1e-9" : fmt::format("{:.2g}", chance);
}

std::string judged(const DifferencePart& part) {
  return fmt::format("{} (chance {})",
                     part.chance < kSignificant ? "changed" : "no more than scatter",
                     difference_chance_text(part.chance));
}

Json part_facts(const DifferencePart& part) {
  return {
      {"chi_square", part.chi_square}, {"dof", part.degrees_of_freedom}, {"chance", part.chance}};
}

Json measured_facts(const Measured& measured) {
  return {{"value", measured.value}, {"sigma", measured.sigma}};
}

/// Places of the probes that make a map.
Json probe_places(const StoredMap& stored) {
  std::vector<Position<frame::Nominal>> places;
  for (const ProbePoint& probe : stored.kept_points()) places.push_back(probe.place);
  return corners(places);
}

}  // namespace

std::string difference_text(const ComparedMaps& maps) {
  const MapDifference& d = maps.difference;
  const bool stands_in = d.model != maps.before.map.surface().model();
  std::string out = difference_line(
      "compared",
      fmt::format(
          "{} of {} with the prediction of {}{}{}",
          amount(d.n_probes, "probe"),
          maps.after_file,
          maps.before_file,
          stands_in ? fmt::format(", as a {} of its probes", name_of(d.model)) : "",
          d.n_outside > 0 ? fmt::format("; {} more stand outside of it", d.n_outside) : ""));
  out += difference_line(
      "panel",
      d.all.chance < kSignificant
          ? fmt::format("changed: by scatter alone it would look so with a chance of {}",
                        difference_chance_text(d.all.chance))
          : fmt::format("not seen to change: scatter alone does as much with a chance of {}",
                        difference_chance_text(d.all.chance)));
  out += difference_line("offset",
                         fmt::format("{} at ({:.1f}, {:.1f}); {}",
                                     with_sigma(d.offset_um, "um"),
                                     d.center_mm.x(),
                                     d.center_mm.y(),
                                     judged(d.offset)));
  out += difference_line("tilt",
                         fmt::format("{} along x, {} along y; {}",
                                     with_sigma(d.tilt_x, "um/m"),
                                     with_sigma(d.tilt_y, "um/m"),
                                     judged(d.tilt)));
  if (d.bow) {
    out += difference_line("bow",
                           fmt::format("{} along x, {} along y, twist {}; {}",
                                       with_sigma(*d.bow_x_um, "um"),
                                       with_sigma(*d.bow_y_um, "um"),
                                       with_sigma(*d.twist_um, "um"),
                                       judged(*d.bow)));
  } else {
    out += difference_line("bow", "not determined by this number of probes");
  }
  if (d.rest) out += difference_line("rest", "the rest of the difference: " + judged(*d.rest));
  out += difference_line("rms", um_text(d.rms) + " over what both maps probed");
  return out + difference_line("greatest",
                               fmt::format("{:+.1f} um +- {} at {}",
                                           d.greatest.in_um(),
                                           um_text(d.greatest_sigma),
                                           place_text(d.greatest_at)));
}

Json difference_figures(const ComparedMaps& maps) {
  const MapDifference& d = maps.difference;
  Json out = {{"before", maps.before_file},
              {"after", maps.after_file},
              {"changed", d.all.chance < kSignificant},
              {"model", word(d.model)},
              {"probes", d.n_probes},
              {"outside", d.n_outside},
              {"center_mm", facts::point(d.center_mm)},
              {"half_mm", facts::point(d.half_mm)},
              {"all", part_facts(d.all)},
              {"offset", part_facts(d.offset)},
              {"tilt", part_facts(d.tilt)},
              {"offset_um", measured_facts(d.offset_um)},
              {"tilt_x_um_m", measured_facts(d.tilt_x)},
              {"tilt_y_um_m", measured_facts(d.tilt_y)}};
  if (d.bow) {
    out["bow"] = part_facts(*d.bow);
    out["bow_x_um"] = measured_facts(*d.bow_x_um);
    out["bow_y_um"] = measured_facts(*d.bow_y_um);
    out["twist_um"] = measured_facts(*d.twist_um);
  }
  if (d.rest) out["rest"] = part_facts(*d.rest);
  out["rms_um"] = d.rms.in_um();
  out["greatest_um"] = d.greatest.in_um();
  out["greatest_sigma_um"] = d.greatest_sigma.in_um();
  out["greatest_at_mm"] = facts::point(d.greatest_at.in_mm());
  return out;
}

Json difference_facts(const ComparedMaps& maps, const Provenance& provenance) {
  Json out = surface_envelope("diff");
  out.update(difference_figures(maps));
  const PictureGrid grid(maps.difference.common_mm, mm(0));
  Json field = grid.facts();
  field["difference_um"] = Json::array();
  for (const auto& node : grid.nodes()) {
    const double was_mm = maps.before.map.lattice().height_mm(node.in_mm());
    const double is_mm = maps.after.map.lattice().height_mm(node.in_mm());
    field["difference_um"].push_back(std::round(kPicturedPerMm * (is_mm - was_mm)) /
                                     kPicturedPerUm);
  }
  out["common_mm"] = Json::array();
  for (const auto& corner_mm : maps.difference.common_mm) {
    out["common_mm"].push_back(facts::point(corner_mm));
  }
  out["probes_before_mm"] = probe_places(maps.before);
  out["probes_after_mm"] = probe_places(maps.after);
  out["field"] = std::move(field);
  out["provenance"] = provenance_facts(provenance);
  return out;
}

}  // namespace panelcal::surface
