// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "surface/files/probe_file.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

Expected<ProbeFile> read(const std::string& text, const ProbeFileOptions& options = {}) {
  return parse_probe_file(text, "table.csv", options);
}

void refused(const std::string& text, const char* message, const ProbeFileOptions& options = {}) {
  EXPECT_THAT(read(text, options), FailsWith(Code::MeasurementFile, message));
}

/// (1.5, 2) has 0.25, (3, 4) has -0.5 mm.
void is_the_table(const Expected<ProbeFile>& found) {
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->format, ProbeFormat::PlainCsv);
  ASSERT_EQ(found->points.size(), 2U);
  EXPECT_THAT(found->points[0].place.in_mm(), ElementsAre(1.5, 2));
  EXPECT_EQ(found->points[0].measured.height, mm(0.25));
  EXPECT_THAT(found->points[1].place.in_mm(), ElementsAre(3, 4));
  EXPECT_EQ(found->points[1].measured.height, mm(-0.5));
}

TEST(PlainCsv, ReadsEverySeparator) {
  is_the_table(read("x,y,z\n1.5,2,0.25\n3,4,-0.5\n"));
  is_the_table(read("x;y;z\n1.5;2;0.25\n3;4;-0.5\n"));
  is_the_table(read("x;y;z\n1,5;2;0,25\n3;4;-0,5\n"));
  is_the_table(read("x\ty\tz\n1.5\t2\t0.25\n3\t4\t-0.5\n"));
  is_the_table(read("x y z\n1.5 2 0.25\n3 4 -0.5\n"));
  is_the_table(read("1.5, 2, 0.25\n3, 4, -0.5\n"));
  is_the_table(read("\xEF\xBB\xBFX; Y; Z\r\n1.5; 2; 0.25\r\n\r\n3; 4; -0.5\r\n"));
  // Blanks and no names: the same as a log.
  EXPECT_EQ(read("1.5 2 0.25\n3 4 -0.5\n")->format, ProbeFormat::LinuxCncLog);
}

TEST(PlainCsv, FindsColumnsByNameInAnyOrder) {
  is_the_table(read("No,Z,Y,X\n1,0.25,2,1.5\n2,-0.5,4,3\n"));
  is_the_table(read("X-Axis,Y-Axis,Probe Z\n1.5,2,0.25\n3,4,-0.5\n"));
  is_the_table(read("x_mm,y_mm,height_um\n1.5,2,250\n3,4,-500\n"));
  is_the_table(read("easting,northing,level\n1.5,2,0.25\n3,4,-0.5\n"));
  is_the_table(read("# x y z\n# by hand\n1.5 2 0.25\n3 4 -0.5\n"));
  const auto found = read("x,y,z,sigma_um\n1.5,2,0.25,4\n3,4,-0.5,6\n");
  is_the_table(found);
  EXPECT_EQ(found->points[1].measured.sigma, um(6));
  EXPECT_FALSE(found->points[1].is_sigma_assumed);
}

TEST(PlainCsv, ReadsAPlanWithHeightsBehindIt) {
  const auto found = read("x,y\n1.5,2,0.25\n3,4,-0.5\n5,6\n7,8,\n");
  is_the_table(found);
  EXPECT_EQ(found->missing.size(), 2U);
  EXPECT_EQ(found->missing[0].reason, "no height in the table");
  refused("x,y\n1.5,2\n3,4\n", "table.csv:2:1: ");
}

TEST(PlainCsv, ConvertsUnitsOfItsNamesOrOfTheOption) {
  const auto named = read("x_in,y_in,z_um\n1,2,10\n");
  ASSERT_TRUE(named) << named.error().text();
  EXPECT_THAT(named->points[0].place.in_mm(), ElementsAre(25.4, 50.8));
  EXPECT_EQ(named->points[0].measured.height, um(10));
  EXPECT_EQ(named->unit, "x in inch, y in inch, height in um (line 1)");
  const auto told = read("x,y,z\n1,2,0.5\n", {.unit = inch(1)});
  ASSERT_TRUE(told) << told.error().text();
  EXPECT_EQ(told->points[0].measured.height, mm(12.7));
  refused("x_mm,y_mm,z\n1,2,3\n", "table.csv:1:1: ", {.unit = inch(1)});
}

TEST(PlainCsv, KnowsUnitsByTheirUsualNames) {
  for (const std::string unit : {"z_um",
                                 "z_microns",
                                 "Z (\xC2\xB5m)",
                                 "Z [\xCE\xBCm]",
                                 "z_\xB5m",
                                 "Height in micrometres"}) {
    is_the_table(read("X in mm,y (mm)," + unit + "\n1.5,2,250\n3,4,-500\n"));
  }
  is_the_table(read("Easting (x),Northing (y),\"Elevation (z)\"\n1.5,2,0.25\n3,4,-0.5\n"));
  for (const std::string unit : {"Z (mil)", "z_thou"}) {
    const auto found = read("x,y," + unit + "\n1,2,10\n");
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_NEAR(found->points[0].measured.height.in_mm(), 0.254, 1e-12);
    EXPECT_EQ(found->unit, "height in mil (line 1)");
  }
}

TEST(PlainCsv, ReadsTheUnitsOfColumnsWithoutAKnownName) {
  const auto found = read("Easting [inch],Northing [inch],Elevation [mm]\n1,2,0.5\n");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_THAT(found->points[0].place.in_mm(), ElementsAre(25.4, 50.8));
  EXPECT_EQ(found->points[0].measured.height, mm(0.5));
  EXPECT_EQ(found->unit, "x in inch, y in inch, height in mm (line 1)");
  refused("Easting [mm],Northing,Elevation\n1,2,3\n", "table.csv:1:1: ", {.unit = inch(1)});
}

TEST(PlainCsv, RefusesUnitsThatItDoesNotKnow) {
  for (const std::string title : {"z [m]",
                                  "z_m",
                                  "z_cm",
                                  "Z (feet)",
                                  "Z (rel)",
                                  "z (mm rel)",
                                  "z (10 um)",
                                  "z (\")",
                                  "um_z",
                                  "z_um_raw"}) {
    refused("x,y," + title + "\n1,2,3\n", "table.csv:1:5: ");
  }
  refused("x_cm,y_cm,z_mm\n1,2,3\n", "\"x_cm\"");
  refused("Easting [m],Northing [m],Elevation [m]\n1,2,3\n", "table.csv:1:1: ");
  refused("xmm,ymm,zum\n1,2,3\n", "mm, um, mil or inch");
}

TEST(PlainCsv, TakesNoRowWithABadCellForNames) {
  refused("0,0,--\n1,2,3\n", "table.csv:1:5: ");
  refused("0;0,5;--\n1;2;3\n", "table.csv:1:7: ");
  refused("x,y,3\n1,2,3\n", "table.csv:1:1: ");
}

TEST(PlainCsv, RefusesNamesThatLeaveAColumnOpen) {
  refused("x,y,temperature\n1,2,3\n", "table.csv:1:1: ");
  refused("x,y,depth\n1,2,3\n", "table.csv:1:1: ");
  refused("x,x,y,z\n1,2,3,4\n", "table.csv:1:3: ");
  refused("x,y,z,height\n1,2,3,4\n", "table.csv:1:7: ");
  refused("a,b,c,d\n1,2,3,4\n", "table.csv:1:1: ");
  refused("1,2,3,4\n", "table.csv:1:1: ");
}

TEST(PlainCsv, RefusesValuesThatAreNone) {
  refused("x,y,z\n1,2,3\n4,5,0.1", "table.csv:3:1: ");
  refused("x,y,z\n1,2,3\n1,2\n", "table.csv:3:1: ");
  refused("x,y,z\n1,2,3\n1,2,3,4\n", "table.csv:3:1: ");
  refused("x,y,z\n1,2,3\n4,,6\n", "table.csv:3:3: ");
  refused("x,y,z\n1,2,3\n4,nan,6\n", "table.csv:3:3: ");
  refused("x,y,z\n1,2,3\n4,5,inf\n", "table.csv:3:5: ");
  refused("x,y,z\n1,2,3\n4,5,1e9\n", "table.csv:3:5: ");
  refused("x,y,z\n1,2,3\n4,5,6mm\n", "table.csv:3:5: ");
  refused("x;y;z\n1,5;2;3\n1.5;2;3\n", "table.csv:3:1: ");
  refused("x;y;z\n1.5;2;3\n1;2;1.234,5\n", "table.csv:3:5: ");
  refused("x,y,z,sigma\n1,2,3,0\n", "table.csv:2:7: ");
  refused("x,y,z\n1,2,nan\n", "table.csv:2:1: ");
}

TEST(PlainCsv, KeepsAPlaceThatWasProbedTwice) {
  EXPECT_EQ(read("x,y,z\n1,2,3\n1,2,3.01\n1,2,3.01\n")->points.size(), 3U);
}

}  // namespace
}  // namespace panelcal
