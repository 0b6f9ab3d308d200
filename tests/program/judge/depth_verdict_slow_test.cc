// SPDX-License-Identifier: Apache-2.0
// Depths of simulated boards: as many must break their tolerance as were predicted.
#include <cmath>
#include <vector>

#include "program/judge/depth_verdict.h"
#include "surface/control/grid_map.h"

#include "tests/program/operations.h"
#include "tests/surface/fit/simulated_warp.h"

namespace panelcal {
namespace {

constexpr int kWarps = 100;
constexpr int kQueries = 25;  ///< along a side
constexpr Length kDepthSigma = um(3);

TEST(DepthVerdict, ForetellsHowManyDepthsBreakTheirTolerance) {
  Tolerances tolerances;
  tolerances.depth = {um(5), um(8)};
  double shallow_foretold = 0, deep_foretold = 0, squares = 0;
  int n_shallow = 0, n_deep = 0, n = 0;
  for (int i_warp = 0; i_warp < kWarps; ++i_warp) {
    Random random = Random(77).fork(static_cast<std::uint64_t>(i_warp));
    const test::SimulatedWarp truth(random, i_warp);
    const std::vector<ProbePoint> probes = test::probed_lattice(random, truth, 10, 12);
    auto map = HeightMap::of_probes(probes);
    ASSERT_TRUE(map) << map.error().text();
    std::vector<GridPoint> nodes;
    for (const ProbePoint& probe : probes) nodes.push_back({probe.place.in_mm(), {probe.measured}});
    const auto grid = GridMap::from_points(nodes);
    ASSERT_TRUE(grid);
    DepthVerdict verdict(tolerances, kDepthSigma, *std::move(map));
    for (int i = 0; i < kQueries * kQueries; ++i) {
      const Eigen::Vector2d p_mm =
          test::kWarpSide_mm *
          (Eigen::Vector2d(random.uniform(), random.uniform()) - Eigen::Vector2d(0.5, 0.5));
      Drill hole;
      hole.nominal = position_mm<frame::Nominal>(p_mm);
      hole.cut = {std::nullopt, mm(0.2), grid->height_at(p_mm).heights.front().height};
      verdict.put({1, {}, hole, {}});
      const double deeper_um =
          1e3 * (truth(p_mm) - hole.cut.surface->in_mm()) + kDepthSigma.in_um() * random.normal();
      n_shallow += deeper_um < -5 ? 1 : 0;
      n_deep += deeper_um > 8 ? 1 : 0;
      squares += deeper_um * deeper_um;
      ++n;
    }
    const auto& tool = verdict.by_tool().begin()->second;
    ASSERT_EQ(tool.places.n_unjudged, 0);
    shallow_foretold += tool.expected_too_shallow;
    deep_foretold += tool.expected_too_deep;
  }
  RecordProperty("places", n);
  RecordProperty("shallow_over_foretold", std::to_string(n_shallow / shallow_foretold));
  RecordProperty("deep_over_foretold", std::to_string(n_deep / deep_foretold));
  RecordProperty("rms_um", std::to_string(std::sqrt(squares / n)));
  EXPECT_GT(n_shallow, 1000);
  EXPECT_GT(n_deep, 100);
  EXPECT_NEAR(n_shallow / shallow_foretold, 1, 0.1);
  EXPECT_NEAR(n_deep / deep_foretold, 1, 0.2);
}

}  // namespace
}  // namespace panelcal
