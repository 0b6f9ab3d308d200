// SPDX-License-Identifier: Apache-2.0
#include "panelcal/surface/height_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <fmt/format.h>

#include "panelcal/calib/convex_hull.h"
#include "panelcal/surface/surface_choice.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using Places = std::vector<Position<frame::Nominal>>;

/// Coordinates that differ by less are of one column or row, and such a distance is none.
constexpr double kSamePlace_mm = 1e-3;
/// What the lattice may add to a sigma, and what is always good enough.
constexpr double kMostLatticeError = 0.1;
constexpr double kGoodLatticeError_mm = 1e-5;
/// Cells by the side of the square that each probe has, at first; nodes at most.
constexpr double kFirstRefinement = 4;
constexpr double kMostNodes = 60000;

Position<frame::Nominal> nominal(const Vector2d& p_mm) {
  return position_mm<frame::Nominal>(p_mm);
}

Expected<void> check(const HeightMapOptions& options) {
  const auto bad = [](const char* name, double value, const char* expected) {
    return failure(
        {Code::ConfigValue, {}, fmt::format("{} is {}", name, value), std::string(expected)});
  };
  const double most_mm = options.max_extrapolation.in_mm();
  if (!(most_mm >= 0) || !std::isfinite(most_mm)) {
    return bad("max_extrapolation_mm", most_mm, "0 mm or more");
  }
  const double false_alarm = options.outliers.false_alarm;
  if (!(false_alarm > 0 && false_alarm < 1)) return bad("false_alarm", false_alarm, "0 to 1");
  const double most = options.outliers.most;
  if (!(most >= 0 && most <= 0.5)) return bad("most outliers", most, "0 to 0.5 of the probes");
  const double noise = options.outliers.most_noise;
  if (!(noise > 0)) return bad("most_noise", noise, "above 0");
  if (options.reach_mm) {
    const double least_mm = options.reach_mm->minCoeff();
    if (!(least_mm > 0) || !options.reach_mm->allFinite()) {
      return bad("reach_mm", least_mm, "above 0 mm");
    }
  }
  return {};
}

/// Columns or rows, rising.
std::vector<double> distinct(std::span<const ProbePoint> points, int axis) {
  std::vector<double> all;
  for (const ProbePoint& point : points) all.push_back(point.place.in_mm()[axis]);
  std::ranges::sort(all);
  std::vector<double> out;
  for (const double value : all) {
    if (out.empty() || value - out.back() > kSamePlace_mm) out.push_back(value);
  }
  return out;
}

double greatest_gap(const std::vector<double>& rising) {
  double gap = 0;
  for (std::size_t i = 1; i < rising.size(); ++i) gap = std::max(gap, rising[i] - rising[i - 1]);
  return gap;
}

double median_neighbor_mm(std::span<const ProbePoint> points) {
  std::vector<double> nearest_mm;
  for (const ProbePoint& a : points) {
    double least_mm = std::numeric_limits<double>::infinity();
    for (const ProbePoint& b : points) {
      const double distance_mm = (a.place - b.place).in_mm().norm();
      if (distance_mm > kSamePlace_mm) least_mm = std::min(least_mm, distance_mm);
    }
    nearest_mm.push_back(least_mm);
  }
  const auto middle = nearest_mm.begin() + static_cast<std::ptrdiff_t>(nearest_mm.size() / 2);
  std::ranges::nth_element(nearest_mm, middle);
  return *middle;
}

Vector2d reach_of(std::span<const ProbePoint> points) {
  const std::vector<double> columns = distinct(points, 0), rows = distinct(points, 1);
  // Half of the nodes or more: columns and rows that have gaps, no places at random.
  if (columns.size() * rows.size() <= 2 * points.size()) {
    return 0.5 * Vector2d(greatest_gap(columns), greatest_gap(rows));
  }
  return Vector2d::Constant(median_neighbor_mm(points));
}

LatticeAxis axis(double low_mm, double high_mm, double step_mm) {
  const int n_cells = std::max(1, static_cast<int>(std::ceil((high_mm - low_mm) / step_mm)));
  return {low_mm, (high_mm - low_mm) / n_cells, n_cells + 1};
}

/// A surface on a lattice.
struct Sampled {
  HeightLattice heights;
  HeightLattice sigmas;
  double error_mm = 0;
  bool is_good = false;
};

Sampled sample(const SurfaceFit& surface,
               const LatticeAxis& x,
               const LatticeAxis& y,
               LatticeInterpolation interpolation) {
  Places nodes, middles;
  for (int j = 0; j < y.n_nodes; ++j) {
    for (int i = 0; i < x.n_nodes; ++i) {
      nodes.push_back(nominal({x.at_mm(i), y.at_mm(j)}));
      if (i + 1 == x.n_nodes || j + 1 == y.n_nodes) continue;
      middles.push_back(nodes.back() +
                        displacement_mm<frame::Nominal>(0.5 * x.step_mm, 0.5 * y.step_mm));
    }
  }
  std::vector<double> heights_mm, sigmas_mm;
  for (const HeightEstimate& node : surface.at(nodes)) {
    heights_mm.push_back(node.height.in_mm());
    sigmas_mm.push_back(node.sigma.in_mm());
  }
  Sampled out{HeightLattice(x, y, heights_mm, interpolation),
              HeightLattice(x, y, sigmas_mm, LatticeInterpolation::Bilinear)};
  out.is_good = true;
  const std::vector<HeightEstimate> right = surface.at(middles);
  for (std::size_t i = 0; i < middles.size(); ++i) {
    const Vector2d& p_mm = middles[i].in_mm();
    const double error_mm = std::abs(out.heights.height_mm(p_mm) - right[i].height.in_mm());
    out.error_mm = std::max(out.error_mm, error_mm);
    const double sigma_mm = right[i].sigma.in_mm();
    if (error_mm > std::max(kGoodLatticeError_mm, kMostLatticeError * sigma_mm)) {
      out.is_good = false;
    }
  }
  return out;
}

/// Refines until the lattice is good or has as many nodes as it may have.
Sampled sample_finely(const SurfaceFit& surface,
                      const Vector2d& low_mm,
                      const Vector2d& high_mm,
                      double spacing_mm,
                      LatticeInterpolation interpolation) {
  const Vector2d size_mm = high_mm - low_mm;
  double step_mm = spacing_mm / kFirstRefinement;
  while (true) {
    const LatticeAxis x = axis(low_mm.x(), high_mm.x(), step_mm);
    const LatticeAxis y = axis(low_mm.y(), high_mm.y(), step_mm);
    Sampled out = sample(surface, x, y, interpolation);
    const double next_nodes = 4 * (size_mm.x() / step_mm + 1) * (size_mm.y() / step_mm + 1);
    if (out.is_good || next_nodes > kMostNodes) return out;
    step_mm *= 0.5;
  }
}

}  // namespace

struct HeightMap::State {
  ChosenSurface chosen;
  HeightMapOptions options;
  Vector2d reach_mm;
  Places kept;
  Places hull;
  Sampled sampled;
  std::vector<std::uint8_t> marks;  ///< cells that are not within the hull

  Length outside(const Vector2d& p_mm) const {
    const Length distance = distance_outside(hull, nominal(p_mm));
    return distance > mm(kSamePlace_mm) ? distance : mm(0);
  }
  Expected<Length> check(const Vector2d& p_mm) const;
  HeightSource source_of(const Vector2d& p_mm, Length outside) const;
  void mark_cells();
};

Expected<Length> HeightMap::State::check(const Vector2d& p_mm) const {
  if (!p_mm.allFinite()) {
    return failure({Code::GridInvalid, {}, "a height is asked for at no place", "finite x and y"});
  }
  const Length distance = outside(p_mm);
  if (distance > options.max_extrapolation) {
    return failure({Code::GridInvalid,
                    {},
                    fmt::format("({:.3f}, {:.3f}) lies {:.3f} mm outside of what was probed",
                                p_mm.x(),
                                p_mm.y(),
                                distance.in_mm()),
                    fmt::format("at most {:.3f} mm", options.max_extrapolation.in_mm())});
  }
  return distance;
}

HeightSource HeightMap::State::source_of(const Vector2d& p_mm, Length outside) const {
  if (outside > mm(0)) return HeightSource::Extrapolated;
  const Vector2d reach = reach_mm + Vector2d::Constant(kSamePlace_mm);
  const auto is_near = [&](const Position<frame::Nominal>& probe) {
    return ((probe.in_mm() - p_mm).cwiseAbs().array() <= reach.array()).all();
  };
  return std::ranges::any_of(kept, is_near) ? HeightSource::Measured : HeightSource::Filled;
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
  PANELCAL_CHECK(check(options));
  std::optional<ChosenSurface> chosen;
  if (options.model) {
    PANELCAL_TRY(SoundSurface surface,
                 fit_without_outliers(points, *options.model, options.outliers));
    chosen = ChosenSurface{std::move(surface), "the model was given"};
  } else {
    PANELCAL_TRY(chosen, choose_surface(points, options.outliers));
  }
  Places kept;
  for (const std::size_t i : chosen->surface.kept) kept.push_back(points[i].place);
  Places hull = convex_hull(kept);
  Vector2d low_mm = hull.front().in_mm(), high_mm = low_mm;
  for (const auto& corner : hull) {
    low_mm = low_mm.cwiseMin(corner.in_mm());
    high_mm = high_mm.cwiseMax(corner.in_mm());
  }
  const double spacing_mm =
      (high_mm - low_mm).norm() / std::sqrt(2 * static_cast<double>(kept.size()));
  // What is inside but for rounding lies in the lattice.
  const double border_mm = options.max_extrapolation.in_mm() + kSamePlace_mm;
  Sampled sampled = sample_finely(chosen->surface.fit,
                                  low_mm - Vector2d::Constant(border_mm),
                                  high_mm + Vector2d::Constant(border_mm),
                                  spacing_mm,
                                  options.interpolation);
  State state{*std::move(chosen),
              options,
              options.reach_mm.value_or(reach_of(points)),
              std::move(kept),
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
                                     std::span<double> heights_mm) const {
  if (!state_->sampled.heights.heights_mm(places_mm, heights_mm, state_->marks)) return {};
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
