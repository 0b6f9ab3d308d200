// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "program/gcode/leveller.h"
#include "surface/map/zoned_map.h"

#include "tests/program/gcode/gcode_text.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::Reports;
using ::testing::HasSubstr;

Position<frame::Nominal> at(double x_mm, double y_mm) {
  return position_mm<frame::Nominal>(x_mm, y_mm);
}

/// 100 mm square, 0.1 mm higher at x = 100, with two zones that meet at x = 50: the right one is
/// `step_mm` higher; and a hole of 4 mm at (30, 20).
ZonedMap two_zones(double step_mm) {
  std::vector<ProbePoint> points;
  for (int j = 0; j < 5; ++j) {
    for (int i = 0; i < 6; ++i) {
      const double x_mm = 20.0 * i, y_mm = 25.0 * j;
      const double height_mm = 1e-3 * x_mm + (x_mm > 50 ? step_mm : 0);
      points.push_back({at(x_mm, y_mm), {mm(height_mm), um(0.1)}, "", {}});
    }
  }
  const HeightMapOptions options = {.model = SurfaceModel::Plane, .max_extrapolation = mm(12)};
  auto voids = Voids::make({{Circle{at(30, 20), mm(2)}, "hole", {}}});
  EXPECT_TRUE(voids) << voids.error().text();
  auto map = ZonedMap::of_probes(points,
                                 {{rectangle(at(0, 0), at(50, 100)), "left", options},
                                  {rectangle(at(50, 0), at(100, 100)), "right", options}},
                                 *std::move(voids));
  EXPECT_TRUE(map) << map.error().text();
  return *std::move(map);
}

std::string levelled(const std::string& lines, const ZonedMap& map) {
  const auto done = level_gcode({"p.ngc", "G21 G90\nG0 Z2\nG0 X10 Y20\n" + lines}, map);
  return done ? done->text : done.error().text();
}

TEST(GcodeLevellerZones, GoesAcrossAVoidAtThePredictedHeight) {
  const auto done = level_gcode(
      {"p.ngc", "G21 G90\nG0 Z2\nG0 X10 Y20\nG1 Z-0.1 F100\nX45\nG0 Z2\n"}, two_zones(0));
  ASSERT_TRUE(done) << done.error().text();
  EXPECT_THAT(done->text, HasSubstr("G1 F100 Z-0.09\nX45 Z-0.055\nG0 Z2\n"));
  EXPECT_EQ(done->figures.n_over_voids, 1);
  EXPECT_EQ(done->figures.n_levelled, 3);
}

TEST(GcodeLevellerZones, GoesFromZoneToZoneWhereTheyMeet) {
  EXPECT_THAT(levelled("G1 Z-0.1\nX90\n", two_zones(0)), HasSubstr("X90 Z-0.01\n"));
}

TEST(GcodeLevellerZones, KeepsToSmallSteps) {
  // A twentieth of the tolerance of 10 um.
  EXPECT_THAT(levelled("G1 Z-0.1\nX90\n", two_zones(0.0003)), HasSubstr("X90 Z-0.0097\n"));
  EXPECT_THAT(levelled("G1 Z-0.1\nX90\n", two_zones(0.001)), HasSubstr("error[argument-invalid]"));
}

TEST(GcodeLevellerZones, RefusesAStepAtItsLine) {
  EXPECT_THAT(
      levelled("G1 Z-0.1\nX90\n", two_zones(0.3)),
      Reports("p.ngc:5:1: error[argument-invalid]", "+0.3000 mm", "\"left\"", "\"right\"", "(51."));
  // Above the safe height the tool may go anywhere.
  EXPECT_THAT(levelled("G1 Z-0.1\nG0 Z2\nX90\nG1 Z-0.1\n", two_zones(0.3)),
              HasSubstr("X90\nG1 Z0.29\n"));
}

TEST(GcodeLevellerZones, RefusesPlacesInNoZone) {
  EXPECT_THAT(levelled("G1 Z-0.1\nY101\n", two_zones(0)),
              Reports("p.ngc:5:1: error[grid-invalid]", "(10.000, 10", "zone"));
}

}  // namespace
}  // namespace panelcal
