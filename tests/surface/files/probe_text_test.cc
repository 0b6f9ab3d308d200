// SPDX-License-Identifier: Apache-2.0
#include "surface/files/probe_text.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"
#include "tests/surface/fit/simulated_warp.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::HasSubstr;

HeightGrid three_by_two() {
  return {{-10, 10, 3}, {5, 20, 2}, {um(10), um(20), um(30), mm(-0.010), std::nullopt, mm(0)}};
}

/// 3 x 2 nodes written in a format and read again.
Expected<HeightGrid> again(ProbeFormat format, const HeightGrid& grid) {
  PANELCAL_TRY(const std::string text, probe_file_text(format, grid));
  PANELCAL_TRY(const ProbeFile file, parse_probe_file(text, "again", {.format = format}));
  return height_grid(file);
}

TEST(ProbeText, WritesAHeightMapAsTheFirmwareDoes) {
  const auto text = probe_file_text(ProbeFormat::HeightMapCsv, three_by_two());
  ASSERT_TRUE(text) << text.error().text();
  EXPECT_EQ(*text,
            "RepRapFirmware height map file v2, min error -0.010, max error 0.030, mean 0.010, "
            "deviation 0.014\n"
            "axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1\n"
            "X,Y,-10,10,5,25,-1,10,20,3,2\n"
            "  0.010,  0.020,  0.030\n"
            " -0.010,      0,  0.000\n");
}

TEST(ProbeText, KeepsMissingNodesMissing) {
  const HeightGrid grid = three_by_two();
  for (const ProbeFormat format : {ProbeFormat::HeightMapCsv, ProbeFormat::OpenCncPilotMap}) {
    const auto found = again(format, grid);
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_EQ(found->heights, grid.heights);
    EXPECT_EQ(found->x.n_nodes, 3);
    EXPECT_EQ(found->x.first_mm, -10);
    EXPECT_EQ(found->y.step_mm, 20);
  }
  EXPECT_THAT(probe_file_text(ProbeFormat::BcncProbe, grid),
              FailsWith(Code::GridInvalid, "column 1 row 1"));
  const auto log = probe_file_text(ProbeFormat::LinuxCncLog, grid);
  ASSERT_TRUE(log) << log.error().text();
  EXPECT_EQ(std::ranges::count(*log, '\n'), 5);
  EXPECT_THAT(*log, HasSubstr("10.000000 5.000000 0.030000 0.000000 0.000000 0.000000 0.0"));
}

TEST(ProbeText, WritesAScanForBcncThatKeepsItsDistance) {
  HeightGrid grid = three_by_two();
  grid.heights[4] = mm(-2.5);
  const auto text = probe_file_text(ProbeFormat::BcncProbe, grid);
  ASSERT_TRUE(text) << text.error().text();
  EXPECT_TRUE(text->starts_with("-10 10 3\n5 25 2\n-3.500 3.030 10\n\n\n-10 5 0.01\n")) << *text;
  EXPECT_EQ(again(ProbeFormat::BcncProbe, grid)->heights, grid.heights);
}

TEST(ProbeText, RecordedProbesKeepEveryBit) {
  const std::vector<ProbePoint> points = {
      {position_mm<frame::Nominal>(0.1, -1.0 / 3), {mm(2.0 / 3), mm(1e-3 / 7)}, "a", {}},
      {position_mm<frame::Nominal>(1e-9, 5), {mm(-0.0), um(3)}, "b", {}}};
  const auto text = probe_file_text(ProbeFormat::RecordedProbes, points);
  ASSERT_TRUE(text) << text.error().text();
  const auto found = parse_probe_file(*text, "probes.jsonl");
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->points.size(), 2U);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(found->points[i].place, points[i].place);
    EXPECT_EQ(found->points[i].measured.height, points[i].measured.height);
    EXPECT_EQ(found->points[i].measured.sigma, points[i].measured.sigma);
  }
}

TEST(ProbeText, RefusesWhatTheProgramWouldRefuse) {
  const auto refused = [](ProbeFormat format, const HeightGrid& grid, const char* text) {
    EXPECT_THAT(probe_file_text(format, grid), FailsWith(Code::GridInvalid, text));
  };
  HeightGrid grid = three_by_two();
  grid.x.step_mm = 0.05;
  refused(ProbeFormat::HeightMapCsv, grid, "0.05 mm");
  grid = three_by_two();
  grid.heights[0] = mm(120);
  refused(ProbeFormat::HeightMapCsv, grid, "120 mm");
  grid.heights[0] = mm(std::numeric_limits<double>::quiet_NaN());
  refused(ProbeFormat::OpenCncPilotMap, grid, "error[grid-invalid]");
  grid.heights.pop_back();
  refused(ProbeFormat::OpenCncPilotMap, grid, "5 heights");
  grid.heights.assign(6, std::nullopt);
  refused(ProbeFormat::OpenCncPilotMap, grid, "error[grid-invalid]");
  grid.y.n_nodes = 1;
  refused(ProbeFormat::OpenCncPilotMap, grid, "along y");
  refused(ProbeFormat::RecordedProbes, three_by_two(), "probes");
  EXPECT_THAT(probe_file_text(ProbeFormat::BcncProbe, std::vector<ProbePoint>(1)),
              FailsWith(Code::GridInvalid, "bcnc"));
}

TEST(HeightGrid, OfAMapHasWhatWasMeasuredAndMoreOnlyIfAsked) {
  Random random(90);
  const test::SimulatedWarp warp(random, 1);
  std::vector<ProbePoint> points = test::probed_lattice(random, warp, 7, 6);
  const ProbePoint missing = points[7 * 3 + 2];
  points.erase(points.begin() + 7 * 3 + 2);
  const auto map = HeightMap::of_probes(points, {.model = SurfaceModel::ThinPlate});
  ASSERT_TRUE(map) << map.error().text();
  const double step_x_mm = points[1].place.in_mm().x() - points[0].place.in_mm().x();
  const double step_y_mm = points[7].place.in_mm().y() - points[0].place.in_mm().y();
  const Eigen::Vector2d first_mm = points[0].place.in_mm();
  // A column more than was probed, outside of the hull.
  const LatticeAxis x{first_mm.x(), step_x_mm, 8}, y{first_mm.y(), step_y_mm, 6};
  const auto measured = height_grid(*map, x, y);
  ASSERT_TRUE(measured) << measured.error().text();
  const auto filled = height_grid(*map, x, y, GridFill::Filled);
  ASSERT_TRUE(filled) << filled.error().text();
  for (std::size_t k = 0; k < measured->heights.size(); ++k) {
    const std::size_t column = k % 8, row = k / 8;
    const bool is_outside = column == 7, is_missing = column == 2 && row == 3;
    EXPECT_EQ(measured->heights[k].has_value(), !is_outside && !is_missing) << column << " " << row;
    EXPECT_EQ(filled->heights[k].has_value(), !is_outside) << column << " " << row;
  }
  EXPECT_NEAR(
      filled->heights[8 * 3 + 2]->in_mm(), map->height_at(missing.place)->height.in_mm(), 1e-12);
}

TEST(HeightGrid, RefusesAGridWithoutAnyMeasuredNodeAndHugeOnes) {
  Random random(91);
  const test::SimulatedWarp warp(random, 1);
  const auto map = HeightMap::of_probes(test::probed_lattice(random, warp, 5, 5),
                                        {.model = SurfaceModel::ThinPlate});
  ASSERT_TRUE(map) << map.error().text();
  EXPECT_THAT(height_grid(*map, {5000, 1, 3}, {5000, 1, 3}),
              FailsWith(Code::GridInvalid, "error[grid-invalid]"));
  EXPECT_THAT(height_grid(*map, {0, 0.01, 1000}, {0, 0.01, 1000}),
              FailsWith(Code::GridInvalid, "100000"));
}

}  // namespace
}  // namespace panelcal
