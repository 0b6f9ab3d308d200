// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/plan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "surface/fit/fit.h"
#include "tools/surface/made_facts.h"
#include "tools/surface/shapes.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

using facts::Json;

std::string plan_line(std::string_view what, std::string_view text) {
  return fmt::format("{:<11}{}\n", what, text);
}

std::string worst_text(const WorstSigma& worst) {
  return fmt::format("{} at {}", um_text(worst.sigma), place_text(worst.at));
}

Json worst_facts(const WorstSigma& worst) {
  return {{"sigma_um", worst.sigma.in_um()}, {"at_mm", facts::point(worst.at.in_mm())}};
}

std::vector<double> sigmas_um(const PlannedProbes& planned,
                              const std::vector<Position<frame::Nominal>>& places) {
  std::vector<ProbePoint> points = planned.request.present;
  for (const auto& place : planned.plan.probes) {
    points.push_back({place, {mm(0), planned.request.probe_sigma}, "", {}});
  }
  std::vector<double> out;
  const auto fit = fit_surface(points, planned.request.model, planned.request.shape());
  if (!fit) return out;
  for (const HeightEstimate& height : fit->at(places)) out.push_back(height.sigma.in_um());
  return out;
}

/// The sigma that the map will have, over what may be probed.
Json planned_field(const PlannedProbes& planned) {
  const PictureGrid grid(planned.outline, mm(0));
  const auto nodes = grid.nodes();
  Json out = grid.facts();
  out["sigma_um"] = Json::array();
  for (const double sigma_um : sigmas_um(planned, nodes)) {
    out["sigma_um"].push_back(std::round(1e3 * sigma_um) / 1e3);
  }
  // A letter for each node: planned, or blank.
  std::string sources;
  for (const auto& node : nodes) {
    const bool is_surface = !planned.map || !is_blank(*planned.map, planned.i_zone, node);
    sources += is_surface ? 'p' : 'b';
  }
  out["source"] = std::move(sources);
  return out;
}

/// Of many that lie together, which no picture could tell apart, one stands for all.
Json pictured_places(const PlannedProbes& planned) {
  constexpr double kCells = 1000;
  Eigen::Vector2d low_mm = planned.outline.front(), high_mm = low_mm;
  for (const Eigen::Vector2d& corner_mm : planned.outline) {
    low_mm = low_mm.cwiseMin(corner_mm);
    high_mm = high_mm.cwiseMax(corner_mm);
  }
  const double cell_mm = (high_mm - low_mm).maxCoeff() / kCells;
  std::set<std::pair<long, long>> seen;
  std::vector<double> x_mm, y_mm;
  for (const auto& place : planned.request.places) {
    const Eigen::Vector2d& at_mm = place.in_mm();
    if (!seen.emplace(std::lround(at_mm.x() / cell_mm), std::lround(at_mm.y() / cell_mm)).second) {
      continue;
    }
    x_mm.push_back(at_mm.x());
    y_mm.push_back(at_mm.y());
  }
  return {{"x_mm", column(x_mm)}, {"y_mm", column(y_mm)}};
}

}  // namespace

std::string plan_text(const PlannedProbes& planned) {
  const ProbePlan& plan = planned.plan;
  const ProbePlanRequest& request = planned.request;
  const std::string asked = fmt::format(
      "a sigma of {} at {}", um_text(request.tolerance), amount(request.places.size(), "place"));
  std::string out = plan_line("panel", planned.belief);
  if (!request.present.empty()) {
    out += plan_line(
        "present",
        fmt::format("{}; {}",
                    amount(request.present.size(), "probe"),
                    plan.before ? "worst " + worst_text(*plan.before) : "they make no surface"));
  }
  if (!plan.is_reached) return out + plan_line("no plan", asked + ": " + plan.why_not);
  if (plan.probes.empty()) return out + plan_line("plan", "nothing is missing for " + asked);
  out += plan_line("plan", fmt::format("{} for {}", amount(plan.probes.size(), "probe"), asked));
  out += plan_line("worst", worst_text(plan.worst));
  if (plan.grid) {
    out += plan_line("grid",
                     fmt::format("a regular one needs {} ({} x {}) for that: worst {}",
                                 amount(plan.grid->n_probes(), "probe"),
                                 plan.grid->n_columns,
                                 plan.grid->n_rows,
                                 worst_text(plan.grid->worst)));
  } else {
    out +=
        plan_line("grid", fmt::format("no regular one of up to {} probes does it", kMostPlanned));
  }
  out += plan_line("way", fmt::format("{:.0f} mm from the first to the last", plan.way.in_mm()));
  for (std::size_t k = 0; k < plan.probes.size(); ++k) {
    out += fmt::format("{:5}  {}\n", k + 1, place_text(plan.probes[k]));
  }
  return out;
}

Json plan_facts(const PlannedProbes& planned, const Provenance& provenance) {
  const ProbePlan& plan = planned.plan;
  const ProbePlanRequest& request = planned.request;
  Json out = surface_envelope("plan");
  out.update({{"reached", plan.is_reached},
              {"tolerance_um", request.tolerance.in_um()},
              {"probe_sigma_um", request.probe_sigma.in_um()},
              {"belief", planned.belief},
              {"kernel", word(request.kernel)},
              {"amplitude_mm", request.amplitude.in_mm()},
              {"length_mm", request.length.in_mm()},
              {"trend", request.n_trend},
              {"places", request.places.size()},
              {"candidates", request.candidates.size()},
              {"present", request.present.size()}});
  if (plan.before) out["before"] = worst_facts(*plan.before);
  if (plan.is_reached) {
    out["worst"] = worst_facts(plan.worst);
    if (plan.grid) {
      out["grid"] = {{"columns", plan.grid->n_columns},
                     {"rows", plan.grid->n_rows},
                     {"worst", worst_facts(plan.grid->worst)}};
    }
    out["way_mm"] = plan.way.in_mm();
  } else {
    out["reason"] = plan.why_not;
  }
  out["probes_mm"] = corners(plan.probes);
  std::vector<Position<frame::Nominal>> present;
  for (const ProbePoint& probe : request.present) present.push_back(probe.place);
  out["present_mm"] = corners(present);
  out["pictured_places"] = pictured_places(planned);
  out["outline_mm"] = Json::array();
  for (const auto& corner_mm : planned.outline) {
    out["outline_mm"].push_back(facts::point(corner_mm));
  }
  if (planned.map) {
    out["voids"] = voids_facts(planned.map->voids());
    const auto zones = planned.map->zones();
    if (!zones.empty()) {
      out["zone"] = zones[planned.i_zone].name;
      out["border_mm"] = border(zones[planned.i_zone].area);
    }
  }
  out["field"] = planned_field(planned);
  out["provenance"] = provenance_facts(provenance);
  return out;
}

std::string plan_csv(const PlannedProbes& planned) {
  std::string out = "x,y\n";
  for (const auto& place : planned.plan.probes) {
    out += fmt::format("{:.9g},{:.9g}\n", place.in_mm().x(), place.in_mm().y());
  }
  return out;
}

}  // namespace panelcal::surface
