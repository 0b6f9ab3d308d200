// SPDX-License-Identifier: Apache-2.0
// Marlin 1.1 and 2.x: print_2d_array() prints rows from low y, the report of unified bed leveling
// from high y.
#include <string>

#include "surface/files/probe_file.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kGrid =
    "Bilinear Leveling Grid:\n      0      1      2\n 0 +0.010 -0.020 +0.030\n 1 +0.110 -0.120 "
    "======\n\n";
const std::string kReport =
    "Bed Topography Report:\n\n"
    "    ( 10, 80)       ( 50, 80)\n"
    "        0       1       2\n"
    " 1 | +0.110  -0.120    .   \n"
    "   |\n"
    " 0 |[+0.010] -0.020   0.030 \n"
    "        0       1       2\n"
    "    ( 10, 20)       ( 50, 20)\n\nok\n";
const MeshCorners kCorners{{10, 20}, {50, 80}};

Expected<ProbeFile> read(const std::string& text, const ProbeFileOptions& options = {}) {
  return parse_probe_file(text, "marlin.log", options);
}

void refused(const std::string& text, const char* message, const ProbeFileOptions& options = {}) {
  EXPECT_THAT(read(text, options), FailsWith(Code::MeasurementFile, message));
}

/// Columns at x 10, 30, 50, rows at y 20, 80; the last node has no height.
void is_the_mesh(const Expected<ProbeFile>& found) {
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->points.size(), 5U);
  EXPECT_THAT(found->points[1].place.in_mm(), ElementsAre(30, 20));
  EXPECT_EQ(found->points[1].measured.height, mm(-0.02));
  EXPECT_THAT(found->points[3].place.in_mm(), ElementsAre(10, 80));
  EXPECT_EQ(found->points[3].measured.height, mm(0.11));
  ASSERT_EQ(found->missing.size(), 1U);
  EXPECT_THAT(found->missing[0].place.in_mm(), ElementsAre(50, 80));
}

TEST(MarlinConsole, ReadsRowsInTheOrderThatTheyArePrintedIn) {
  const auto grid = read(kGrid, {.mesh = kCorners});
  is_the_mesh(grid);
  EXPECT_EQ(grid->points[3].from.line, 4);
  EXPECT_EQ(grid->points[3].from.column, 4);
  is_the_mesh(read(kReport));
}

TEST(MarlinConsole, TakesThePlacesThatTheConsoleStates) {
  const std::string touches =
      "Bed X: 10.000 Y: 20.000 Z: 0.010\nBed X: 30.000 Y: 20.000 Z: -0.020\n"
      "Bed X: 50.000 Y: 20.000 Z: 0.030\nBed X: 30.000 Y: 80.000 Z: -0.120\n"
      "Bed X: 10.000 Y: 80.000 Z: 0.110\n";
  is_the_mesh(read(touches + kGrid));
  const auto exact = read(
      "X-Axis Mesh Points at: 10.500  30.500  50.500  \n"
      "Y-Axis Mesh Points at: 20.250  80.250  \n" +
      kReport);
  ASSERT_TRUE(exact) << exact.error().text();
  EXPECT_THAT(exact->points[0].place.in_mm(), ElementsAre(10.5, 20.25));
  EXPECT_THAT(exact->zero, HasSubstr("Mesh Points"));
  const auto flags = read(kReport, {.mesh = MeshCorners{{10.75, 20}, {50, 80.9}}});
  ASSERT_TRUE(flags) << flags.error().text();
  EXPECT_THAT(flags->points[0].place.in_mm(), ElementsAre(10.75, 20));
  EXPECT_EQ(read(touches)->points.size(), 5U);
}

TEST(MarlinConsole, RefusesPlacesThatAreUnknownOrContradictEachOther) {
  refused(kGrid, "marlin.log:1:1: ");
  refused(kReport, "marlin.log:1:1: ", {.mesh = MeshCorners{{12, 20}, {50, 80}}});
  refused("X-Axis Mesh Points at: 10.0 30.0\nY-Axis Mesh Points at: 20.0 80.0\n" + kReport,
          ":3:1: ");
  refused("X-Axis Mesh Points at: 10.0 20.0 50.0\nY-Axis Mesh Points at: 20.0 80.0\n" + kReport,
          ":3:1: ");
  refused("X-Axis Mesh Points at: 10.0 30.0\nX-Axis Mesh Points at: 10.0 31.0\n" + kGrid,
          ":2:24: ");
  refused("Bed X: 1.000 Y: 2.000 Z: 0.010\n", "no mesh", {.mesh = kCorners});
}

TEST(MarlinConsole, RefusesAnotherMesh) {
  EXPECT_TRUE(read(kReport + kReport));
  std::string other = kGrid;
  other.replace(other.find("+0.110"), 6, "+0.111");
  refused(kGrid + other, "marlin.log:6:1: ", {.mesh = kCorners});
  refused("Raw " + kGrid, "marlin.log:1:1: ", {.mesh = kCorners});
}

TEST(MarlinConsole, RefusesTablesThatAreCutOffOrDamaged) {
  // Wherever it is cut off ahead of its last corner, or of the line behind the grid.
  for (std::size_t n = 25; n < kReport.find("\n\nok"); ++n) {
    EXPECT_FALSE(read(kReport.substr(0, n))) << kReport.substr(0, n);
  }
  for (std::size_t n = 23; n < kGrid.size(); ++n) {
    EXPECT_FALSE(read(kGrid.substr(0, n), {.mesh = kCorners})) << kGrid.substr(0, n);
  }
  refused(
      "Bilinear Leveling Grid:\n 0 1\n 0 +0.1 +0.2\n 1 +0.1 +0.2\n", ":5:1: ", {.mesh = kCorners});
  refused("Bilinear Leveling Grid:\n 0 2\n", ":2:2: ");
  refused("Bilinear Leveling Grid:\n 0 1\n 0 +0.1\nok\n", ":3:4: ", {.mesh = kCorners});
  refused("Bilinear Leveling Grid:\n 0 1\n 0 +0.1 +-0.2\nok\n", ":3:9: ", {.mesh = kCorners});
  refused("Bilinear Leveling Grid:\n 0 1\n 0 +0.1 nan\nok\n", ":3:9: ", {.mesh = kCorners});
  refused("Bilinear Leveling Grid:\n 0 1\n 0 +0.1 +0.2\nok\n", ":1:1: ", {.mesh = kCorners});
  refused("Bed Topography Report for CSV:\n0.1\t0.2\n0.1\t0.2\n", ":1:1: ", {.mesh = kCorners});
  refused("Bed X: 1.000 Y: 2.000\n", "marlin.log:1:1: ");
  std::string swapped = kReport;
  swapped[swapped.find(" 0 |[") + 1] = '2';
  refused(swapped, "marlin.log:7:2: ");
}

TEST(MarlinConsole, ReadsBehindThePrefixOfALogAndNothingElse) {
  std::string log;
  for (std::size_t at = 0; at < kGrid.size();) {
    const std::size_t end = kGrid.find('\n', at);
    log += "Recv: " + kGrid.substr(at, end - at) + "\nSend: M105\n";
    at = end + 1;
  }
  is_the_mesh(read(log, {.mesh = kCorners}));
}

}  // namespace
}  // namespace panelcal
