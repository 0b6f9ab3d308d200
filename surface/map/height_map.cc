// SPDX-License-Identifier: Apache-2.0
#include "surface/map/height_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>

#include "calib/advice/convex_hull.h"
#include "calib/base/plane_vectors.h"
#include "surface/map/sampled_surface.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::Vector2d;
using internal::Sampled;
using MapPlaces = std::vector<Position<frame::Nominal>>;

/// Coordinates that differ by less are of one column or row, and such a distance counts as 0.
constexpr double kSameMapPlace_mm = 1e-3;
/// Farther out nothing is known of any panel.
constexpr double kMostExtrapolation_mm = 1000;
/// Probes stand in columns and rows if they do but for this share of their neighbours' distance.
constexpr double kSameColumn = 0.2;
/// By the side of the square that each probe has: probes that stand closer are of one place.
constexpr double kAgain = 0.02;
/// Reach of scattered probes by that distance: they cover the plane nearly.
constexpr double kScatteredReach = 0.75;

Position<frame::Nominal> nominal(const Vector2d& p_mm) {
  return position_mm<frame::Nominal>(p_mm);
}

Expected<void> check_map_options(const HeightMapOptions& options) {
  const auto bad = [](const char* name, double value, const char* expected) {
    return failure(
        {Code::ConfigValue, {}, fmt::format("{} is {}", name, value), std::string(expected)});
  };
  const double most_mm = options.max_extrapolation.in_mm();
  if (!(most_mm >= 0 && most_mm <= kMostExtrapolation_mm)) {
    return bad("max_extrapolation_mm", most_mm, "0 to 1000 mm");
  }
  if (options.reach_mm) {
    const double least_mm = options.reach_mm->minCoeff();
    if (!(least_mm > 0) || !options.reach_mm->allFinite()) {
      return bad("reach_mm", least_mm, "above 0 mm");
    }
  }
  return options.outliers.validate();
}

double by_x(const Vector2d& p_mm) {
  return p_mm.x();
}

/// The lower one of two in the middle. Precondition: not empty.
double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Columns or rows that probes stand in.
struct LatticeColumns {
  std::vector<double> first_mm;  ///< the least coordinate in each, rising
  double widest_mm = 0;

  /// Half of the usual gap, and what the probes stand off their columns: no slit is left between.
  double reach_mm() const {
    std::vector<double> gaps_mm = {};
    for (std::size_t i = 1; i < first_mm.size(); ++i) {
      gaps_mm.push_back(first_mm[i] - first_mm[i - 1]);
    }
    return (gaps_mm.empty() ? 0 : 0.5 * median(std::move(gaps_mm))) + widest_mm;
  }
};

LatticeColumns columns_of(std::span<const ProbePoint> points, int axis, double tolerance_mm) {
  std::vector<double> all_mm;
  for (const ProbePoint& point : points) all_mm.push_back(point.place.in_mm()[axis]);
  std::ranges::sort(all_mm);
  LatticeColumns out;
  for (const double value_mm : all_mm) {
    if (out.first_mm.empty() || value_mm - out.first_mm.back() > tolerance_mm) {
      out.first_mm.push_back(value_mm);
    }
    out.widest_mm = std::max(out.widest_mm, value_mm - out.first_mm.back());
  }
  return out;
}

/// Over the nearest neighbours; what stands much closer than probes do on average is a place that
/// was probed again.
double median_neighbor_mm(std::span<const ProbePoint> points) {
  Vector2d low_mm = points.front().place.in_mm(), high_mm = low_mm;
  for (const ProbePoint& point : points) {
    low_mm = low_mm.cwiseMin(point.place.in_mm());
    high_mm = high_mm.cwiseMax(point.place.in_mm());
  }
  const double area_mm2 = (high_mm - low_mm).prod();
  const double again_mm =
      std::max(kSameMapPlace_mm, kAgain * std::sqrt(area_mm2 / static_cast<double>(points.size())));
  std::vector<Vector2d> sorted_mm;
  for (const ProbePoint& point : points) sorted_mm.push_back(point.place.in_mm());
  std::ranges::sort(sorted_mm, {}, by_x);
  std::vector<double> nearest_mm;
  for (std::size_t i = 0; i < sorted_mm.size(); ++i) {
    double least_mm = std::numeric_limits<double>::infinity();
    const auto is_over = [&](std::size_t k) {
      const Vector2d apart_mm = sorted_mm[k] - sorted_mm[i];
      const double distance_mm = apart_mm.norm();
      if (distance_mm > again_mm) least_mm = std::min(least_mm, distance_mm);
      return std::abs(apart_mm.x()) > least_mm;
    };
    for (std::size_t k = i; k-- > 0 && !is_over(k);) continue;
    for (std::size_t k = i + 1; k < sorted_mm.size() && !is_over(k); ++k) continue;
    nearest_mm.push_back(least_mm);
  }
  return median(std::move(nearest_mm));
}

Vector2d reach_of(std::span<const ProbePoint> points) {
  const double neighbor_mm = median_neighbor_mm(points);
  const double tolerance_mm = std::max(kSameMapPlace_mm, kSameColumn * neighbor_mm);
  const LatticeColumns columns = columns_of(points, 0, tolerance_mm);
  const LatticeColumns rows = columns_of(points, 1, tolerance_mm);
  // Half of the nodes or more: columns and rows that have gaps, no places at random.
  if (columns.first_mm.size() * rows.first_mm.size() <= 2 * points.size()) {
    return {columns.reach_mm(), rows.reach_mm()};
  }
  return Vector2d::Constant(kScatteredReach * neighbor_mm);
}

/// The least distance of two parallel lines that hold the hull between them.
double width_mm(const MapPlaces& hull) {
  double least_mm = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d from_mm = hull[i].in_mm();
    const Vector2d side_mm = hull[(i + 1) % hull.size()].in_mm() - from_mm;
    double farthest_mm = 0;
    for (const auto& corner : hull) {
      const Vector2d to_mm = corner.in_mm() - from_mm;
      const double area = internal::cross(side_mm, to_mm);
      farthest_mm = std::max(farthest_mm, std::abs(area) / side_mm.norm());
    }
    least_mm = std::min(least_mm, farthest_mm);
  }
  return least_mm;
}

}  // namespace

struct HeightMap::State {
  ChosenSurface chosen;
  HeightMapOptions options;
  Vector2d reach_mm;
  std::vector<Vector2d> kept_mm;  ///< by rising x
  MapPlaces hull;
  Sampled sampled;
  std::vector<std::uint8_t> marks;  ///< cells that are not within the hull

  Length outside(const Vector2d& p_mm) const {
    const Length distance = distance_outside(hull, nominal(p_mm));
    return distance > mm(kSameMapPlace_mm) ? distance : mm(0);
  }
  Expected<Length> check(const Vector2d& p_mm) const;
  HeightSource source_of(const Vector2d& p_mm, Length outside) const;
  void mark_cells();
};

Expected<Length> HeightMap::State::check(const Vector2d& p_mm) const {
  if (!p_mm.allFinite()) {
    return failure(
        {Code::GridInvalid, {}, "a height at a place that is not finite", "finite x and y"});
  }
  const Length distance = outside(p_mm);
  if (distance > options.max_extrapolation) {
    return failure({Code::GridInvalid,
                    {},
                    fmt::format("({:.3f}, {:.3f}) lies {:.3f} mm outside of what was probed",
                                p_mm.x(),
                                p_mm.y(),
                                distance.in_mm()),
                    fmt::format("at most {:.3f} mm; it is --max-extrapolation-mm of `surface fit`, "
                                "or grid_hold_mm of [surface]",
                                options.max_extrapolation.in_mm())});
  }
  return distance;
}

HeightSource HeightMap::State::source_of(const Vector2d& p_mm, Length outside) const {
  if (outside > mm(0)) return HeightSource::Extrapolated;
  const Vector2d reach = reach_mm + Vector2d::Constant(kSameMapPlace_mm);
  const auto is_near = [&](const Vector2d& probe_mm) {
    return ((probe_mm - p_mm).cwiseAbs().array() <= reach.array()).all();
  };
  // Wider than the reach by more than rounding.
  const double aside_mm = reach.x() + kSameMapPlace_mm;
  const auto first = std::ranges::lower_bound(kept_mm, p_mm.x() - aside_mm, {}, by_x);
  const auto behind = std::ranges::upper_bound(kept_mm, p_mm.x() + aside_mm, {}, by_x);
  return std::any_of(first, behind, is_near) ? HeightSource::Measured : HeightSource::Filled;
}

/// A cell whose four corners are within the hull is so itself: the hull is convex.
void HeightMap::State::mark_cells() {
  const LatticeAxis& x = sampled.heights.x();
  const LatticeAxis& y = sampled.heights.y();
  const auto is_out = [&](int i, int j) {
    return distance_outside(hull, nominal({x.at_mm(i), y.at_mm(j)})) > mm(0);
  };
  for (int j = 0; j + 1 < y.n_nodes; ++j) {
    for (int i = 0; i + 1 < x.n_nodes; ++i) {
      marks.push_back(is_out(i, j) || is_out(i + 1, j) || is_out(i, j + 1) || is_out(i + 1, j + 1));
    }
  }
}

Expected<HeightMap> HeightMap::of_probes(std::span<const ProbePoint> points,
                                         const HeightMapOptions& options) {
  PANELCAL_CHECK(check_map_options(options));
  if (!options.model) {
    PANELCAL_TRY(ChosenSurface chosen, choose_surface(points, options.outliers));
    return of_surface(points, std::move(chosen), options);
  }
  PANELCAL_TRY(SoundSurface surface,
               fit_without_outliers(points, *options.model, options.outliers));
  std::string reason = "the model was given";
  if (!surface.doubt.empty()) reason += "; " + surface.doubt;
  return of_surface(points, {std::move(surface), std::move(reason)}, options);
}

Expected<HeightMap> HeightMap::of_surface(std::span<const ProbePoint> points,
                                          ChosenSurface chosen,
                                          const HeightMapOptions& options) {
  PANELCAL_CHECK(check_map_options(options));
  MapPlaces kept;
  for (const std::size_t i : chosen.surface.kept) kept.push_back(points[i].place);
  MapPlaces hull = convex_hull(kept);
  if (!(width_mm(hull) > kSameMapPlace_mm)) {
    return failure(
        {Code::GridInvalid,
         points.front().from,
         fmt::format("{} probes in one line but for {:.3g} mm", kept.size(), width_mm(hull)),
         fmt::format("a surface wider than {} mm", kSameMapPlace_mm)});
  }
  Vector2d low_mm = hull.front().in_mm(), high_mm = low_mm;
  for (const auto& corner : hull) {
    low_mm = low_mm.cwiseMin(corner.in_mm());
    high_mm = high_mm.cwiseMax(corner.in_mm());
  }
  const double spacing_mm =
      (high_mm - low_mm).norm() / std::sqrt(2 * static_cast<double>(kept.size()));
  // A place that is inside but for rounding lies in the lattice.
  const double border_mm = options.max_extrapolation.in_mm() + kSameMapPlace_mm;
  PANELCAL_TRY(Sampled sampled,
               internal::sample_finely(chosen.surface.fit,
                                       low_mm - Vector2d::Constant(border_mm),
                                       high_mm + Vector2d::Constant(border_mm),
                                       spacing_mm,
                                       options.interpolation));
  std::vector<Vector2d> kept_mm;
  for (const auto& place : kept) kept_mm.push_back(place.in_mm());
  std::ranges::sort(kept_mm, {}, by_x);
  State state{std::move(chosen),
              options,
              options.reach_mm.value_or(reach_of(points)),
              std::move(kept_mm),
              std::move(hull),
              std::move(sampled),
              {}};
  state.mark_cells();
  return HeightMap(std::make_shared<const State>(std::move(state)));
}

Expected<HeightAt> HeightMap::height_at(const Position<frame::Nominal>& place) const {
  const Vector2d& p_mm = place.in_mm();
  PANELCAL_TRY(const Length outside, state_->check(p_mm));
  const double sigma_mm = state_->sampled.sigmas.height_mm(p_mm);
  return HeightAt{mm(state_->sampled.heights.height_mm(p_mm)),
                  mm(std::hypot(sigma_mm, state_->sampled.error_mm)),
                  state_->source_of(p_mm, outside),
                  outside};
}

Expected<void> HeightMap::heights_at(std::span<const Vector2d> places_mm,
                                     std::span<double> heights_mm,
                                     std::span<HeightSource> sources) const {
  if (heights_mm.size() != places_mm.size() ||
      (!sources.empty() && sources.size() != places_mm.size())) {
    return failure({Code::GridInvalid,
                    {},
                    fmt::format("{} places, {} heights and {} sources",
                                places_mm.size(),
                                heights_mm.size(),
                                sources.size()),
                    "one height, and one source or none, for each place"});
  }
  const bool is_doubtful = state_->sampled.heights.heights_mm(places_mm, heights_mm, state_->marks);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    PANELCAL_TRY(const Length outside, state_->check(places_mm[i]));
    sources[i] = state_->source_of(places_mm[i], outside);
  }
  if (!is_doubtful || !sources.empty()) return {};
  for (const Vector2d& p_mm : places_mm) {
    // Cells at the lattice's border have a mark, and what lies outside of it falls into them.
    if (state_->marks[state_->sampled.heights.cell_of(p_mm)] != 0) {
      PANELCAL_CHECK(state_->check(p_mm));
    }
  }
  return {};
}

const SurfaceFit& HeightMap::surface() const {
  return state_->chosen.surface.fit;
}

std::span<const SurfaceOutlier> HeightMap::outliers() const {
  return state_->chosen.surface.outliers;
}

std::span<const std::size_t> HeightMap::kept() const {
  return state_->chosen.surface.kept;
}

std::span<const Position<frame::Nominal>> HeightMap::hull() const {
  return state_->hull;
}

HeightMapOptions HeightMap::options() const {
  HeightMapOptions options = state_->options;
  options.reach_mm = state_->reach_mm;
  return options;
}

const std::string& HeightMap::reason() const {
  return state_->chosen.reason;
}

const HeightLattice& HeightMap::lattice() const {
  return state_->sampled.heights;
}

Length HeightMap::lattice_error() const {
  return mm(state_->sampled.error_mm);
}

}  // namespace panelcal
