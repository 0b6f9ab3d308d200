// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/plan.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/advice/convex_hull.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/median.h"
#include "surface/map/difference.h"
#include "surface/map/file.h"
#include "tools/cli/output_paths.h"
#include "tools/surface/commands/subcommand.h"
#include "tools/surface/text.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

using Eigen::Vector2d;
using Places = std::vector<Position<frame::Nominal>>;

const std::string kSurfacePlan = "panelcal surface plan";
/// Of a fine grid over what may be probed, and of places where nothing else says which count.
constexpr double kCandidates = 600;
constexpr double kPlaces = 1000;
/// Probes are planned in steps that any machine goes to.
constexpr double kStep_mm = 0.01;
/// Larger or smaller areas are no panels.
constexpr double kMaxPlanPlace_mm = 1e5;

/// Reads the believed bending of the panel, of --amplitude-mm and its kin.
Expected<void> believe_options(const SurfaceOptions& options, PlannedProbes& out) {
  if (!options.amplitude_mm || !options.length_mm || !options.probe_sigma_um) {
    return failure(usage(kSurfacePlan,
                         "the bending of such panels is missing",
                         "a MAP, or --amplitude-mm, --length-mm and --probe-sigma-um"));
  }
  out.request.amplitude = mm(*options.amplitude_mm);
  out.request.length = mm(*options.length_mm);
  out.request.probe_sigma = um(*options.probe_sigma_um);
  out.belief = fmt::format(
      "believed to bend by {:g} mm over {:g} mm about a plane (Matern 5/2); a "
      "probe scatters {}",
      *options.amplitude_mm,
      *options.length_mm,
      um_text(out.request.probe_sigma));
  return {};
}

Length median_sigma(const std::vector<ProbePoint>& probes) {
  std::vector<double> sigmas_mm;
  for (const ProbePoint& probe : probes) sigmas_mm.push_back(probe.measured.sigma.in_mm());
  return mm(median(std::move(sigmas_mm)));
}

/// Takes the believed bending of the panel from a map.
Expected<void> believe_map(const SurfaceOptions& options,
                           const StoredMap& stored,
                           PlannedProbes& out) {
  const SurfaceModel model = stored.map.surface().model();
  // Neither has an amplitude and a length that would hold for other panels and other probes.
  const bool stands_in = model == SurfaceModel::ThinPlate || is_of_grid(model);
  std::vector<ProbePoint> probes = stored.kept_points();
  PANELCAL_TRY(const SurfaceFit fit,
               model == SurfaceModel::ThinPlate ? fit_surface(probes, SurfaceModel::GaussianProcess)
                                                : predictor_of(stored));
  ProbePlanRequest& request = out.request;
  request.model = fit.model();
  request.kernel = fit.shape().kernel;
  request.amplitude = fit.amplitude();
  request.length = fit.shape().length;
  request.n_trend = fit.n_trend();
  request.probe_sigma = options.probe_sigma_um ? um(*options.probe_sigma_um)
                                               : fit.noise_factor() * median_sigma(probes);
  out.belief = fmt::format("as {}{} found: {}; a probe scatters {}",
                           stands_in ? "the probes of " : "",
                           options.map,
                           fit.summary(),
                           um_text(request.probe_sigma));
  if (options.afresh) return {};
  for (ProbePoint& probe : probes) {
    probe.measured.sigma = fit.noise_factor() * probe.measured.sigma;
  }
  request.present = std::move(probes);
  return {};
}

Places rectangle(const Vector2d& low_mm, const Vector2d& high_mm) {
  return {position_mm<frame::Nominal>(low_mm),
          position_mm<frame::Nominal>(high_mm.x(), low_mm.y()),
          position_mm<frame::Nominal>(high_mm),
          position_mm<frame::Nominal>(low_mm.x(), high_mm.y())};
}

/// --area, else the rectangle of the program's places, else what the map's probes span.
Expected<Places> area_of(const SurfaceOptions& options,
                         const Places& of_program,
                         const std::optional<StoredMap>& stored) {
  if (!options.area_mm.empty()) {
    const Vector2d low_mm(options.area_mm[0], options.area_mm[1]);
    const Vector2d high_mm(options.area_mm[2], options.area_mm[3]);
    const bool is_area = low_mm.cwiseAbs().maxCoeff() <= kMaxPlanPlace_mm &&
                         high_mm.cwiseAbs().maxCoeff() <= kMaxPlanPlace_mm &&
                         (high_mm - low_mm).minCoeff() > kStep_mm;
    if (is_area) return rectangle(low_mm, high_mm);
    return failure(usage(kSurfacePlan,
                         "--area has no width or no height",
                         "X0,Y0,X1,Y1 with X0 < X1 and Y0 < Y1, mm"));
  }
  if (!of_program.empty()) {
    Vector2d low_mm = of_program.front().in_mm(), high_mm = low_mm;
    for (const auto& place : of_program) {
      low_mm = low_mm.cwiseMin(place.in_mm());
      high_mm = high_mm.cwiseMax(place.in_mm());
    }
    if ((high_mm - low_mm).minCoeff() > kStep_mm) return rectangle(low_mm, high_mm);
    return failure(usage(
        kSurfacePlan, "the program's places lie in one line", "--area, for where one may probe"));
  }
  if (stored) return Places(stored->map.hull().begin(), stored->map.hull().end());
  return failure(usage(kSurfacePlan, "no place counts", "a MAP, --program or --area"));
}

/// About n places of an even grid over a convex area, its corners among them.
Places grid_over(const Places& corners, double n) {
  Vector2d low_mm = corners.front().in_mm(), high_mm = low_mm;
  for (const auto& corner : corners) {
    low_mm = low_mm.cwiseMin(corner.in_mm());
    high_mm = high_mm.cwiseMax(corner.in_mm());
  }
  const Vector2d size_mm = high_mm - low_mm;
  const double step_mm = std::sqrt(size_mm.prod() / n);
  const int nx = std::max(1, static_cast<int>(std::lround(size_mm.x() / step_mm)));
  const int ny = std::max(1, static_cast<int>(std::lround(size_mm.y() / step_mm)));
  Places out;
  for (int j = 0; j <= ny; ++j) {
    for (int i = 0; i <= nx; ++i) {
      const Vector2d part(static_cast<double>(i) / nx, static_cast<double>(j) / ny);
      Vector2d place_mm = low_mm + part.cwiseProduct(size_mm);
      // Division makes 0.07 of 7, multiplication would not.
      for (double& value_mm : place_mm) value_mm = std::round(value_mm / kStep_mm) / (1 / kStep_mm);
      const auto place = position_mm<frame::Nominal>(place_mm);
      if (distance_outside(corners, place) <= mm(kStep_mm)) out.push_back(place);
    }
  }
  for (const auto& corner : corners) {
    if (std::ranges::none_of(out, [&](const auto& place) {
          return (place - corner).in_mm().norm() <= 2 * kStep_mm;
        })) {
      out.push_back(corner);
    }
  }
  return out;
}

/// True if a probe would touch the surface of a zone and no void.
bool is_surface(const ZonedMap& map, std::size_t i_zone, const Position<frame::Nominal>& place) {
  return map.zone_at(place) == i_zone && map.voids().touched_at(place) == nullptr;
}

Expected<void> check_plan_outputs(const SurfaceOptions& options) {
  PANELCAL_CHECK(check_extension(kSurfacePlan, options.output, ".csv"));
  return check_extension(kSurfacePlan, options.facts.report, ".html");
}

}  // namespace

Expected<Answer> plan(const SurfaceOptions& options, CommandContext& context) {
  PANELCAL_CHECK(check_plan_outputs(options));
  PlannedProbes planned;
  std::optional<StoredMap> stored;
  if (options.map.empty()) {
    PANELCAL_CHECK(believe_options(options, planned));
  } else {
    PANELCAL_TRY(const StoredZones read, read_zoned_map_file(options.map));
    PANELCAL_TRY(const std::size_t i_zone, zone_of(read, options.map, kSurfacePlan, options));
    stored.emplace(read.zone(i_zone));
    PANELCAL_CHECK(believe_map(options, *stored, planned));
    planned.map = read.map;
    planned.i_zone = i_zone;
  }
  ProbePlanRequest& request = planned.request;
  request.tolerance = um(*options.tolerance_um);
  ProgramPlaces of;
  if (!options.program.empty()) {
    PANELCAL_TRY(of, program_places(options, context));
    for (const panelcal::plan::PlannedPlace& place : of.places)
      request.places.push_back(place.nominal);
  }
  PANELCAL_TRY(const Places area, area_of(options, request.places, stored));
  for (const auto& corner : area) planned.outline.push_back(corner.in_mm());
  const bool are_places_free = request.places.empty();
  if (are_places_free) request.places = grid_over(area, kPlaces);
  request.candidates = grid_over(area, kCandidates);
  if (planned.map) {
    request.may_probe = [map = *planned.map, i_zone = planned.i_zone](const auto& place) {
      return is_surface(map, i_zone, place);
    };
    // Heights matter at the places where a program works, whatever is there already.
    std::erase_if(request.places, [&](const auto& place) {
      return are_places_free ? !request.may_probe(place)
                             : planned.map->zone_at(place) != planned.i_zone;
    });
    std::erase_if(request.candidates, [&](const auto& place) { return !request.may_probe(place); });
    if (request.places.empty() || request.candidates.empty()) {
      return failure(usage(kSurfacePlan,
                           "all of the area lies in voids or in other zones",
                           "an --area that has a surface"));
    }
  }
  context.console.progress("planning probes");
  auto plan = plan_probes(request);
  if (!plan) return failure(std::move(plan).error());
  planned.plan = *std::move(plan);
  const bool is_reached = planned.plan.is_reached;
  if (is_reached && !options.output.empty()) {
    PANELCAL_CHECK(write_file(options.output, plan_csv(planned)));
  }
  const std::vector<std::string> inputs = {
      options.map, options.program, of.format_file, options.machine};
  const auto document = [&] {
    return facts::text(plan_facts(planned, provenance_of(context, inputs)));
  };
  return state_facts(context,
                     options.facts,
                     "Where to probe",
                     document,
                     {plan_text(planned), is_reached ? ExitCode::Done : ExitCode::GateFailed});
}

}  // namespace panelcal::surface
