// SPDX-License-Identifier: Apache-2.0
// Cuts of contours along the grid: the bound of 10,000 of them, and how few pieces would do.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "surface/control/grid_map.h"
#include <gtest/gtest.h>

#include "tests/surface/fit/simulated_warp.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using Place = std::function<Vector2d(double)>;

constexpr int kContours = 10'000;
constexpr int kSamples = 1000;  ///< of a contour
/// Error that the rounding of both chords adds.
constexpr double kRounding_mm = 1e-9;

GridMap random_map(Random& random, int kind) {
  const test::SimulatedWarp warp(random, kind);
  // Every fourth is rough: probes of 30 um.
  const double sigma_mm = kind % 4 == 0 ? 0.03 : test::kWarpSigma_mm;
  std::vector<GridPoint> nodes;
  for (const ProbePoint& probe : test::probed_lattice(random, warp, 10, 12, sigma_mm)) {
    nodes.push_back({probe.place.in_mm(), {probe.measured}});
  }
  return *GridMap::from_points(nodes);
}

/// The map's heights along a contour at even steps of its parameter.
std::vector<double> profile_mm(const GridMap& map, const Place& place_mm) {
  std::vector<double> heights;
  for (int i = 0; i <= kSamples; ++i) {
    heights.push_back(
        map.height_at(place_mm(static_cast<double>(i) / kSamples)).heights[0].height.in_mm());
  }
  return heights;
}

/// Greatest error of the chords between cuts against the profile.
double worst_mm(const GridMap& map,
                const Place& place_mm,
                const std::vector<double>& profile,
                const std::vector<double>& cuts) {
  double worst = 0, begin = 0;
  std::size_t i = 1;
  for (std::size_t k = 0; k <= cuts.size(); ++k) {
    const double end = k < cuts.size() ? cuts[k] : 1;
    const double z0 = map.height_at(place_mm(begin)).heights[0].height.in_mm();
    const double z1 = map.height_at(place_mm(end)).heights[0].height.in_mm();
    for (; i < profile.size() && static_cast<double>(i) / kSamples <= end; ++i) {
      const double share = (static_cast<double>(i) / kSamples - begin) / (end - begin);
      worst = std::max(worst, std::abs(profile[i] - ((1 - share) * z0 + share * z1)));
    }
    begin = end;
  }
  return worst;
}

/// The fewest chords between samples of the profile that keep within the tolerance at all samples.
///
/// From each sample the slopes that pass all gates so far are an interval, which only shrinks
/// (Imai and Iri 1986); the fewest pieces to each sample follow by dynamic programming.
int fewest_pieces(const std::vector<double>& profile, double tolerance_mm) {
  const std::size_t n = profile.size();
  std::vector<int> pieces(n, std::numeric_limits<int>::max());
  pieces[0] = 0;
  for (std::size_t s = 0; s + 1 < n; ++s) {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    for (std::size_t t = s + 1; t < n && low <= high; ++t) {
      const double steps = static_cast<double>(t - s);
      const double slope = (profile[t] - profile[s]) / steps;
      if (slope >= low && slope <= high) pieces[t] = std::min(pieces[t], pieces[s] + 1);
      low = std::max(low, slope - tolerance_mm / steps);
      high = std::min(high, slope + tolerance_mm / steps);
    }
  }
  return pieces.back();
}

struct Outcome {
  std::size_t n_pieces = 0;
  int fewest = 0;
  bool is_within = true;
};

Outcome outcome_of(const GridMap& map,
                   const Place& place_mm,
                   const std::vector<double>& cuts,
                   double tolerance_mm) {
  const std::vector<double> profile = profile_mm(map, place_mm);
  return {cuts.size() + 1,
          fewest_pieces(profile, tolerance_mm),
          worst_mm(map, place_mm, profile, cuts) <= tolerance_mm + kRounding_mm};
}

Vector2d anywhere(Random& random) {
  return test::kWarpSide_mm * Vector2d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
}

Outcome random_line(const GridMap& map, Random& random, double tolerance_mm) {
  const Vector2d from_mm = anywhere(random), along_mm = anywhere(random) - from_mm;
  const auto cuts = map.split_line(from_mm, from_mm + along_mm, mm(tolerance_mm));
  return outcome_of(
      map, [&](double t) -> Vector2d { return from_mm + t * along_mm; }, cuts, tolerance_mm);
}

Outcome random_arc(const GridMap& map, Random& random, double tolerance_mm) {
  const Vector2d center_mm = 0.5 * anywhere(random);
  const double radius_mm = random.uniform(2, 70);
  const double start_rad = random.uniform(0, 2 * std::numbers::pi);
  const double sweep_rad = random.uniform(-2, 2) * std::numbers::pi;
  const auto cuts = map.split_arc(center_mm, start_rad, sweep_rad, radius_mm, mm(tolerance_mm));
  const auto place_mm = [&](double t) -> Vector2d {
    const double angle_rad = start_rad + t * sweep_rad;
    return center_mm + radius_mm * Vector2d(std::cos(angle_rad), std::sin(angle_rad));
  };
  return outcome_of(map, place_mm, cuts, tolerance_mm);
}

TEST(GridMapSplit, KeepsTheBoundWithFewPieces) {
  std::size_t n_pieces[2] = {}, fewest[2] = {};
  int n_over = 0;
  for (int i = 0; i < kContours; ++i) {
    Random random = Random(5).fork(static_cast<std::uint64_t>(i));
    const GridMap map = random_map(random, i / 2);
    const double tolerance_mm = std::pow(10, random.uniform(-3, -1.5));
    const int kind = i % 2;
    const Outcome outcome =
        kind == 0 ? random_line(map, random, tolerance_mm) : random_arc(map, random, tolerance_mm);
    n_over += outcome.is_within ? 0 : 1;
    n_pieces[kind] += outcome.n_pieces;
    fewest[kind] += static_cast<std::size_t>(outcome.fewest);
  }
  const auto ratio = [&](int kind) {
    return static_cast<double>(n_pieces[kind]) / static_cast<double>(fewest[kind]);
  };
  RecordProperty("lines_over_fewest", std::to_string(ratio(0)));
  RecordProperty("arcs_over_fewest", std::to_string(ratio(1)));
  EXPECT_EQ(n_over, 0);
  EXPECT_LT(ratio(0), 1.3);
  EXPECT_LT(ratio(1), 1.3);
}

}  // namespace
}  // namespace panelcal
