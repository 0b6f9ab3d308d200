// SPDX-License-Identifier: Apache-2.0
// Helpers of the tests of G-code.
#pragma once

#include <functional>
#include <string>

#include "program/gcode/leveller.h"
#include "program/gcode/motion.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::test {

/// Probes on a lattice of 100 mm from (0, 0), exact to a tenth of a micrometre.
inline HeightMap probed_map(const std::function<double(double, double)>& height_mm,
                            int n_side = 11,
                            std::optional<SurfaceModel> model = std::nullopt) {
  std::vector<ProbePoint> points;
  for (int j = 0; j < n_side; ++j) {
    for (int i = 0; i < n_side; ++i) {
      const double x_mm = 100.0 * i / (n_side - 1), y_mm = 100.0 * j / (n_side - 1);
      points.push_back(
          {position_mm<frame::Nominal>(x_mm, y_mm), {mm(height_mm(x_mm, y_mm)), um(0.1)}, "", {}});
    }
  }
  HeightMapOptions options;
  options.model = model;
  options.max_extrapolation = mm(1);
  auto map = HeightMap::of_probes(points, options);
  EXPECT_TRUE(map) << map.error().text();
  return *std::move(map);
}

/// 0.1 mm higher at x = 100.
inline HeightMap sloping_map() {
  return probed_map([](double x, double) { return 1e-3 * x; }, 5, SurfaceModel::Plane);
}

inline std::string levelled(const std::string& text,
                            const HeightMap& map,
                            const LevelOptions& options = {}) {
  const auto done = level_gcode({"p.ngc", text}, map, options);
  return done ? done->text : done.error().text();
}

}  // namespace panelcal::test
