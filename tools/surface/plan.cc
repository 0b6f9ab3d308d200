// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/plan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "calib/base/append_format.h"
#include "calib/base/json/json_string.h"
#include "surface/fit/fit.h"
#include "tools/figures/contour_map.h"
#include "tools/surface/blanks.h"
#include "tools/surface/text.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

constexpr int kPlanNodes = 70;
constexpr int kPlanLevels = 6;
constexpr std::size_t kMaxProbeNumbers = 150;

std::string plan_line(std::string_view what, std::string_view text) {
  return fmt::format("{:<11}{}\n", what, text);
}

std::string worst_text(const WorstSigma& worst) {
  return fmt::format("{} at {}", um_text(worst.sigma), place_text(worst.at));
}

std::string plan_point_json(const Position<frame::Nominal>& place) {
  return fmt::format("[{:.9g},{:.9g}]", place.in_mm().x(), place.in_mm().y());
}

std::string worst_json(const WorstSigma& worst) {
  return fmt::format(
      R"({{"sigma_um":{:.9g},"at":{}}})", worst.sigma.in_um(), plan_point_json(worst.at));
}

std::string provenance_json(const Provenance& provenance) {
  std::string out;
  for (const auto& [key, value] : provenance) {
    out += out.empty() ? "{" : ",";
    append_json_string(out, key);
    out += ":";
    append_json_string(out, value);
  }
  return out + "}";
}

std::vector<double> sigmas_um(const PlannedProbes& planned,
                              const std::vector<Position<frame::Nominal>>& places) {
  std::vector<ProbePoint> points = planned.request.present;
  for (const auto& place : planned.plan.probes) {
    points.push_back({place, {mm(0), planned.request.probe_sigma}, "", {}});
  }
  std::vector<double> out;
  const auto fit = fit_surface(points, planned.request.model, planned.request.shape());
  if (!fit) return std::vector<double>(places.size(), 0);
  for (const HeightEstimate& height : fit->at(places)) out.push_back(height.sigma.in_um());
  return out;
}

std::string probe_dots(const std::vector<Position<frame::Nominal>>& places,
                       const report::View& view) {
  std::set<std::pair<long, long>> drawn;
  std::string path;
  for (const auto& place : places) {
    const Eigen::Vector2d at = view.at(place.in_mm());
    if (!drawn.emplace(std::lround(2 * at.x()), std::lround(2 * at.y())).second) continue;
    internal::append_format(path, "M{:.1f} {:.1f}h0", at.x(), at.y());
  }
  return fmt::format("<path class=\"dots\" d=\"{}\"/>\n", path);
}

std::string probe_circle(const Eigen::Vector2d& at, double radius, std::string_view css_class) {
  return fmt::format("<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>",
                     css_class,
                     at.x(),
                     at.y(),
                     radius);
}

std::string tour(const PlannedProbes& planned, const report::View& view) {
  std::string way, stops;
  const auto& probes = planned.plan.probes;
  for (std::size_t k = 0; k < probes.size(); ++k) {
    const Eigen::Vector2d at = view.at(probes[k].in_mm());
    internal::append_format(way, "{}{:.1f} {:.1f}", way.empty() ? "M" : "L", at.x(), at.y());
    const bool is_first = k == 0;
    stops += probe_circle(at, 8, is_first ? "stop begin" : "stop");
    if (probes.size() > kMaxProbeNumbers) continue;
    stops += fmt::format("<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n",
                         is_first ? "number first" : "number",
                         at.x(),
                         at.y() + 3.5,
                         k + 1);
  }
  return fmt::format("<path class=\"way\" d=\"{}\"/>\n{}\n", way, stops);
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

std::string plan_json(const PlannedProbes& planned, const Provenance& provenance) {
  const ProbePlan& plan = planned.plan;
  const ProbePlanRequest& request = planned.request;
  std::string probes;
  for (const auto& place : plan.probes)
    probes += (probes.empty() ? "" : ",") + plan_point_json(place);
  std::string out = fmt::format(
      R"({{"reached":{},"tolerance_um":{:.9g},"probe_sigma_um":{:.9g},"kernel":"{}","amplitude":{:.9g},)"
      R"("length":{:.9g},"trend":{},"places":{},"candidates":{},"present":{})",
      plan.is_reached,
      request.tolerance.in_um(),
      request.probe_sigma.in_um(),
      word(request.kernel),
      request.amplitude.in_mm(),
      request.length.in_mm(),
      request.n_trend,
      request.places.size(),
      request.candidates.size(),
      request.present.size());
  if (plan.before) out += ",\"before\":" + worst_json(*plan.before);
  if (!plan.is_reached) {
    out += ",\"reason\":";
    append_json_string(out, plan.why_not);
    return out + "}\n";
  }
  out += ",\"worst\":" + worst_json(plan.worst);
  if (plan.grid) {
    out += fmt::format(R"(,"grid":{{"columns":{},"rows":{},"worst":{}}})",
                       plan.grid->n_columns,
                       plan.grid->n_rows,
                       worst_json(plan.grid->worst));
  }
  out += fmt::format(",\"way\":{:.9g},\"probes\":[{}]", plan.way.in_mm(), probes);
  if (!provenance.empty()) out += ",\"provenance\":" + provenance_json(provenance);
  return out + "}\n";
}

std::string plan_csv(const PlannedProbes& planned) {
  std::string out = "x,y\n";
  for (const auto& place : planned.plan.probes) {
    out += fmt::format("{:.9g},{:.9g}\n", place.in_mm().x(), place.in_mm().y());
  }
  return out;
}

std::string plan_svg(const PlannedProbes& planned, const Provenance& provenance) {
  contours::ContourMap map;
  map.id = "plan";
  map.title = fmt::format("Sigma that the map will have, um; {} for {}",
                          amount(planned.plan.probes.size(), "probe"),
                          um_text(planned.request.tolerance));
  map.unit = "um";
  map.palette = contours::Palette::Sigmas;
  map.outline = planned.outline;
  for (const auto& place : planned.plan.probes) map.marked.push_back(place.in_mm());
  map.field = contours::field_over(
      map.outline, kPlanNodes, [&](const auto& places) { return sigmas_um(planned, places); });
  std::string white;
  const report::View view = contours::view_of(map.outline);
  if (planned.map) {
    map.is_covered = [&](const Eigen::Vector2d& p_mm) {
      return is_blank(*planned.map, planned.i_zone, position_mm<frame::Nominal>(p_mm));
    };
    white = blanks(*planned.map, planned.i_zone, view);
  }
  contours::set_levels(map, kPlanLevels);
  std::string present;
  for (const ProbePoint& probe : planned.request.present) {
    present += probe_circle(view.at(probe.place.in_mm()), 3, "old") + "\n";
  }
  return contours::sheet_svg(
      "Where to probe",
      {{contours::contour_drawing(
          map,
          view,
          white + probe_dots(planned.request.places, view) + present + tour(planned, view))}},
      provenance);
}

}  // namespace panelcal::surface
