// SPDX-License-Identifier: Apache-2.0
// Bias and sigma of the predictions of maps of simulated warps.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <set>

#include "surface/map/height_map.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/surface/fit/simulated_warp.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::SimulatedWarp;
using Points = std::vector<ProbePoint>;

constexpr int kWarps = 50;
constexpr int kQueries = 31;  ///< along a side
constexpr double kTwoSided95 = 1.959963984540054;

/// Probed lattice: columns and rows, some of which are missing, some wild.
struct Lattice {
  std::size_t n_missing = 0;
  std::size_t n_wild = 0;
  int n_columns = 10;
  int n_rows = 12;
};

struct Warped {
  SimulatedWarp truth;
  Points points;
  std::set<std::size_t> wild;
};

Warped warped(std::uint64_t seed, const Lattice& lattice) {
  Random random = Random(61).fork(seed);
  Warped out{SimulatedWarp(random, static_cast<int>(seed)), {}, {}};
  out.points = test::probed_lattice(random, out.truth, lattice.n_columns, lattice.n_rows);
  const auto any = [&] {
    return static_cast<std::size_t>(random.uniform(0, static_cast<double>(out.points.size())));
  };
  for (std::size_t i = 0; i < lattice.n_missing; ++i) {
    out.points.erase(out.points.begin() + static_cast<std::ptrdiff_t>(any()));
  }
  while (out.wild.size() < lattice.n_wild) out.wild.insert(any());
  for (const std::size_t i : out.wild) {
    const double sign = random.uniform() < 0.5 ? -1 : 1;
    out.points[i].measured.height =
        out.points[i].measured.height + sign * mm(random.uniform(0.1, 2));
  }
  return out;
}

struct Judged {
  double squares_mm2 = 0;
  int n = 0;
  int n_within_95 = 0;
  int n_out_of_range = 0;  ///< of the kept probes, where the truth is not, by more than 3 sigma
  int n_overlooked = 0;
  int n_false_alarms = 0;

  double rms_um() const { return 1e3 * std::sqrt(squares_mm2 / n); }
  double share_within_95() const { return static_cast<double>(n_within_95) / n; }
};

void judge_outliers(const HeightMap& map, const std::set<std::size_t>& wild, Judged& out) {
  std::set<std::size_t> found;
  for (const SurfaceOutlier& outlier : map.outliers()) found.insert(outlier.i_point);
  for (const std::size_t i : wild) out.n_overlooked += found.contains(i) ? 0 : 1;
  for (const std::size_t i : found) out.n_false_alarms += wild.contains(i) ? 0 : 1;
}

void judge(const HeightMap& map, const Warped& warp, Judged& out) {
  judge_outliers(map, warp.wild, out);
  double low_mm = 1, high_mm = -1;
  for (std::size_t i = 0; i < warp.points.size(); ++i) {
    if (warp.wild.contains(i)) continue;
    low_mm = std::min(low_mm, warp.points[i].measured.height.in_mm());
    high_mm = std::max(high_mm, warp.points[i].measured.height.in_mm());
  }
  for (int i = 0; i < kQueries; ++i) {
    for (int j = 0; j < kQueries; ++j) {
      const Vector2d p_mm =
          test::kWarpSide_mm * (Vector2d(i + 0.5, j + 0.5) / kQueries - Vector2d(0.5, 0.5));
      const auto found = map.height_at(position_mm<frame::Nominal>(p_mm));
      // A corner is missing.
      if (!found || found->source == HeightSource::Extrapolated) continue;
      const double height_mm = found->height.in_mm(), sigma_mm = found->sigma.in_mm();
      const double truth_mm = warp.truth(p_mm);
      const double error_mm = height_mm - truth_mm;
      out.n += 1;
      out.squares_mm2 += error_mm * error_mm;
      out.n_within_95 += std::abs(error_mm) <= kTwoSided95 * sigma_mm ? 1 : 0;
      const bool is_out = height_mm > std::max(high_mm, truth_mm) + 3 * sigma_mm ||
                          height_mm < std::min(low_mm, truth_mm) - 3 * sigma_mm;
      out.n_out_of_range += is_out ? 1 : 0;
    }
  }
}

Judged judged(const Lattice& lattice, const HeightMapOptions& options = {}, int n_warps = kWarps) {
  Judged out;
  for (int i = 0; i < n_warps; ++i) {
    const Warped warp = warped(static_cast<std::uint64_t>(i), lattice);
    const auto map = HeightMap::of_probes(warp.points, options);
    EXPECT_TRUE(map) << "warp " << i << ": " << map.error().text();
    if (map) judge(*map, warp, out);
  }
  std::printf("rms %.2f um, %.2f %% within 95 %%, %d of %d out of range, %d overlooked, %d false\n",
              out.rms_um(),
              100 * out.share_within_95(),
              out.n_out_of_range,
              out.n,
              out.n_overlooked,
              out.n_false_alarms);
  return out;
}

void expect_honest(const Judged& found) {
  EXPECT_GE(found.share_within_95(), 0.93);
  EXPECT_LE(found.share_within_95(), 0.97);
  EXPECT_EQ(found.n_out_of_range, 0);
}

TEST(HeightMap, KnowsWarpsAndHowWell) {
  const Judged found = judged({});
  expect_honest(found);
  EXPECT_LT(found.rms_um(), 1.6);
  // One map in a hundred.
  EXPECT_LE(found.n_false_alarms, 4);
}

TEST(HeightMap, KnowsWarpsWithAFifthOfTheNodesMissing) {
  const Judged found = judged({.n_missing = 24});
  expect_honest(found);
  EXPECT_LT(found.rms_um(), 1.8);
  EXPECT_LE(found.n_false_alarms, 4);
}

TEST(HeightMap, KnowsWarpsWithNodesMissingAndWildProbes) {
  const Judged found = judged({.n_missing = 24, .n_wild = 8});
  expect_honest(found);
  EXPECT_LT(found.rms_um(), 1.9);
  EXPECT_EQ(found.n_overlooked, 0);
  EXPECT_LE(found.n_false_alarms, 4);
}

/// Grid models: every probe is believed, so that nothing is smoothed.
TEST(HeightMap, KnowsWarpsThroughEveryProbeOfAGrid) {
  for (const SurfaceModel model : {SurfaceModel::Bilinear, SurfaceModel::MonotoneBicubic}) {
    const Judged found = judged({}, {.model = model});
    expect_honest(found);
    EXPECT_LT(found.rms_um(), 3.2);
    EXPECT_EQ(found.n_false_alarms, 0);
  }
}

TEST(HeightMap, HasNoGridModelWhereANodeIsMissingOrWild) {
  for (const SurfaceModel model : {SurfaceModel::Bilinear, SurfaceModel::MonotoneBicubic}) {
    for (int i = 0; i < kWarps; ++i) {
      const auto seed = static_cast<std::uint64_t>(i);
      EXPECT_THAT(HeightMap::of_probes(warped(seed, {.n_missing = 24}).points, {.model = model}),
                  test::FailsWith(Code::GridInvalid));
      EXPECT_THAT(HeightMap::of_probes(warped(seed, {.n_wild = 8}).points, {.model = model}),
                  test::FailsWith(Code::GridInvalid));
    }
  }
}

/// More probes than tell the shape: honest, and better than the best part that could.
TEST(HeightMap, KnowsWarpsOfManyProbes) {
  constexpr int kFewer = 24;
  const Judged many = judged({.n_missing = 40, .n_wild = 10, .n_columns = 36, .n_rows = 34},
                             {.model = SurfaceModel::GaussianProcess},
                             kFewer);
  expect_honest(many);
  EXPECT_EQ(many.n_overlooked, 0);
  EXPECT_LE(many.n_false_alarms, 2);
  const Judged part =
      judged({.n_columns = 25, .n_rows = 24}, {.model = SurfaceModel::GaussianProcess}, kFewer);
  EXPECT_LT(many.rms_um(), 0.9 * part.rms_um());
}

}  // namespace
}  // namespace panelcal
