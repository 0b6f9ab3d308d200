// SPDX-License-Identifier: Apache-2.0
#include "surface/plan/probe_plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/advice/convex_hull.h"
#include "calib/advice/visiting_order.h"
#include "surface/fit/fit.h"
#include "surface/plan/probe_search.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using PlanPlaces = std::vector<Position<frame::Nominal>>;

/// Places that the search looks at to begin with; others join when they turn out to be unsure.
constexpr std::size_t kFirstPlaces = 1100;
constexpr std::size_t kJoining = 100;
constexpr int kMostRounds = 12;
/// Thinning works on some of the places; where others break the tolerance then, it is tried again.
constexpr int kThinningRounds = 2;
/// Places nearer than this are one.
constexpr double kSamePlanPlace_mm = 1e-6;

/// Heights at the request's places by a map of these probes and the present ones; empty if they
/// determine no surface.
std::vector<HeightEstimate> predicted_heights(const ProbePlanRequest& request,
                                              const PlanPlaces& probes) {
  std::vector<ProbePoint> points = request.present;
  for (const auto& place : probes) points.push_back({place, {mm(0), request.probe_sigma}, "", {}});
  const auto fit = fit_surface(points, request.model, request.shape());
  return fit ? fit->at(request.places) : std::vector<HeightEstimate>();
}

std::optional<WorstSigma> worst_of(const ProbePlanRequest& request,
                                   const std::vector<HeightEstimate>& heights) {
  const auto worst = std::ranges::max_element(heights, {}, &HeightEstimate::sigma);
  if (worst == heights.end()) return std::nullopt;
  return WorstSigma{worst->sigma,
                    request.places[static_cast<std::size_t>(worst - heights.begin())]};
}

/// Evenly some of the places, or all of them.
PlanPlaces some_of(const PlanPlaces& places, std::size_t n_most) {
  const std::size_t step = (places.size() + n_most - 1) / n_most;
  PlanPlaces out;
  for (std::size_t i = 0; i < places.size(); i += step) out.push_back(places[i]);
  return out;
}

/// Adds the least sure of the places that break the tolerance; whether there were any.
bool join_unsure(const ProbePlanRequest& request,
                 const std::vector<HeightEstimate>& heights,
                 PlanPlaces& places) {
  std::vector<std::size_t> unsure;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    if (heights[i].sigma > request.tolerance) unsure.push_back(i);
  }
  std::ranges::stable_sort(
      unsure, std::greater<>(), [&](std::size_t i) { return heights[i].sigma; });
  unsure.resize(std::min(unsure.size(), kJoining));
  for (const std::size_t i : unsure) places.push_back(request.places[i]);
  return !unsure.empty();
}

/// Columns and rows over the candidates' rectangle, its sides included.
PlanPlaces grid_places(const ProbePlanRequest& request, int n_columns, int n_rows) {
  Eigen::Vector2d low_mm = request.candidates.front().in_mm(), high_mm = low_mm;
  for (const auto& place : request.candidates) {
    low_mm = low_mm.cwiseMin(place.in_mm());
    high_mm = high_mm.cwiseMax(place.in_mm());
  }
  PlanPlaces out;
  for (int j = 0; j < n_rows; ++j) {
    for (int i = 0; i < n_columns; ++i) {
      const Eigen::Vector2d part(i / (n_columns - 1.0), j / (n_rows - 1.0));
      const Eigen::Vector2d place_mm = low_mm + part.cwiseProduct(high_mm - low_mm);
      out.push_back(position_mm<frame::Nominal>(place_mm));
    }
  }
  return out;
}

/// The smallest whose steps along both sides are as equal as they can be.
std::optional<RegularGrid> smallest_grid(const ProbePlanRequest& request) {
  const PlanPlaces corners = grid_places(request, 2, 2);
  const Eigen::Vector2d size_mm = (corners.back() - corners.front()).in_mm();
  if (!(size_mm.minCoeff() > 0)) return std::nullopt;
  int n_columns = 2, n_rows = 2;
  while (static_cast<std::size_t>(n_columns * n_rows) + request.present.size() <= kMostPlanned) {
    const PlanPlaces probes = grid_places(request, n_columns, n_rows);
    const bool is_allowed = !request.may_probe || std::ranges::all_of(probes, request.may_probe);
    const auto worst =
        is_allowed ? worst_of(request, predicted_heights(request, probes)) : std::nullopt;
    if (worst && worst->sigma <= request.tolerance) return RegularGrid{n_columns, n_rows, *worst};
    const bool widens = size_mm.x() / (n_columns - 1) >= size_mm.y() / (n_rows - 1);
    ++(widens ? n_columns : n_rows);
  }
  return std::nullopt;
}

/// Makes candidates of a grid's places, if all of them lie where one may probe; their indices.
std::vector<std::size_t> join_grid(const std::optional<RegularGrid>& grid,
                                   ProbePlanRequest& request) {
  if (!grid) return {};
  const PlanPlaces hull = convex_hull(request.candidates);
  const PlanPlaces places = grid_places(request, grid->n_columns, grid->n_rows);
  for (const auto& place : places) {
    if (distance_outside(hull, place) > mm(kSamePlanPlace_mm)) return {};
  }
  std::vector<std::size_t> out;
  for (const auto& place : places) {
    out.push_back(request.candidates.size());
    request.candidates.push_back(place);
  }
  return out;
}

PlanPlaces places_of(const ProbePlanRequest& request, const std::vector<std::size_t>& chosen) {
  PlanPlaces out;
  for (const std::size_t i : chosen) out.push_back(request.candidates[i]);
  return out;
}

/// Heights that the chosen probes determine. Holes that stand apart may be sure with a probe at
/// each of them, and yet these determine no surface: then some are added where least is known.
std::vector<HeightEstimate> made_a_surface(const ProbePlanRequest& request,
                                           const internal::ProbeSearch& search,
                                           std::vector<std::size_t>& chosen) {
  std::vector<HeightEstimate> out = predicted_heights(request, places_of(request, chosen));
  for (int i = 0; i <= request.n_trend && out.empty(); ++i) {
    chosen.push_back(search.least_known(chosen));
    out = predicted_heights(request, places_of(request, chosen));
  }
  return out;
}

/// Says how far all candidates together come.
ProbePlan unreached(const ProbePlanRequest& request, ProbePlan plan) {
  plan.probes.clear();
  const std::size_t n_free = kMostPlanned - request.present.size();
  const PlanPlaces all = some_of(request.candidates, n_free);
  const auto worst = worst_of(request, predicted_heights(request, all));
  if (!worst) {
    plan.why_not = "probes wherever one may probe make no surface";
    return plan;
  }
  plan.worst = *worst;
  plan.why_not =
      fmt::format("with all of {} probes sigma would still be {:.3g} um at ({:.3f}, {:.3f})",
                  all.size(),
                  worst->sigma.in_um(),
                  worst->at.in_mm().x(),
                  worst->at.in_mm().y());
  return plan;
}

Expected<void> check_plan_request(const ProbePlanRequest& request) {
  const auto bad = [](std::string what, const char* expected) {
    return failure({Code::ConfigValue, {}, std::move(what), expected});
  };
  if (request.places.empty() || request.candidates.empty()) {
    return bad("nothing to plan for", "places where heights matter, and where one may probe");
  }
  if (request.model == SurfaceModel::ThinPlate || is_of_grid(request.model)) {
    return bad(std::string(name_of(request.model)) + " has neither an amplitude nor a length",
               "a plane or a Gaussian process");
  }
  for (const Length sigma : {request.probe_sigma, request.tolerance}) {
    if (sigma > mm(0) && std::isfinite(sigma.in_mm())) continue;
    return bad(fmt::format("a sigma or tolerance is {} mm", sigma.in_mm()), "above 0");
  }
  for (const PlanPlaces* all : {&request.places, &request.candidates}) {
    for (const auto& place : *all) {
      if (!place.in_mm().allFinite()) return bad("a place is no number", "finite x and y");
    }
  }
  return request.shape().validate(request.model);
}

}  // namespace

SurfaceShape ProbePlanRequest::shape() const {
  const double amplitude_mm = amplitude.in_mm();
  return {kernel, length, amplitude_mm * amplitude_mm, 1, n_trend};
}

Expected<ProbePlan> plan_probes(const ProbePlanRequest& asked) {
  PANELCAL_CHECK(check_plan_request(asked));
  ProbePlan plan;
  plan.before = worst_of(asked, predicted_heights(asked, {}));
  if (asked.tolerance < asked.probe_sigma) {
    plan.why_not = fmt::format(
        "a sigma of {:.3g} um is less than what one probe scatters ({:.3g} um): only errors that "
        "average out could give it, and no map can know that they do",
        asked.tolerance.in_um(),
        asked.probe_sigma.in_um());
    return plan;
  }
  if (plan.before && plan.before->sigma <= asked.tolerance) {
    plan.is_reached = true;
    plan.worst = *plan.before;
    return plan;
  }
  if (asked.present.size() >= kMostPlanned) {
    return failure({Code::ConfigValue,
                    {},
                    fmt::format("{} probes are there and not enough", asked.present.size()),
                    fmt::format("fewer than {}, or a plan afresh", kMostPlanned)});
  }
  plan.grid = smallest_grid(asked);
  ProbePlanRequest request = asked;
  const std::vector<std::size_t> of_grid = join_grid(plan.grid, request);
  const internal::HeightBelief belief(request);
  PlanPlaces places = some_of(request.places, kFirstPlaces);
  std::vector<std::size_t> chosen;
  for (int round = 0; round < kMostRounds && !plan.is_reached; ++round) {
    const internal::ProbeSearch search(request, belief, places);
    auto found = search.greedy();
    if (found) search.prune(*found);
    if (search.is_enough(of_grid) && (!found || of_grid.size() < found->size())) {
      found = of_grid;
      search.prune(*found);
    }
    if (!found) break;
    chosen = *std::move(found);
    plan.is_reached = !join_unsure(request, made_a_surface(request, search, chosen), places);
  }
  for (int round = 0; round < kThinningRounds && plan.is_reached; ++round) {
    const internal::ProbeSearch search(request, belief, places);
    std::vector<std::size_t> fewer = chosen;
    search.thin_out(fewer);
    if (join_unsure(request, made_a_surface(request, search, fewer), places)) continue;
    if (fewer.size() < chosen.size()) chosen = std::move(fewer);
    break;
  }
  plan.probes = places_of(request, chosen);
  const auto worst = worst_of(request, predicted_heights(request, plan.probes));
  plan.is_reached = plan.is_reached && worst;
  if (!plan.is_reached) return unreached(request, std::move(plan));
  plan.worst = *worst;
  const std::vector<int> phases(plan.probes.size(), 0);
  const std::vector<std::size_t> order = short_order(plan.probes, phases);
  plan.way = way_length(plan.probes, order);
  PlanPlaces ordered;
  for (const std::size_t i : order) ordered.push_back(plan.probes[i]);
  plan.probes = std::move(ordered);
  return plan;
}

}  // namespace panelcal
