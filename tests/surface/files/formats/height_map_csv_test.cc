// SPDX-License-Identifier: Apache-2.0
#include "surface/files/probe_file.h"
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

constexpr const char* kOldest = "xmin,xmax,ymin,ymax,radius,spacing,xnum,ynum\n";
constexpr const char* kOld = "xmin,xmax,ymin,ymax,radius,xspacing,yspacing,xnum,ynum\n";
constexpr const char* kNew = "axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1\n";
constexpr const char* kRows =
    "  0.010,  0.020,  0.030\n"
    " -0.010,      0,  0.000\n";

Expected<ProbeFile> read(const std::string& text) {
  return parse_probe_file(text, "heightmap.csv", {.format = ProbeFormat::HeightMapCsv});
}

void expect_three_by_two(const Expected<ProbeFile>& found) {
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->points.size(), 5U);
  const ProbePoint& third = found->points[2];
  EXPECT_THAT(third.place.in_mm(), ElementsAre(10, 5));
  EXPECT_EQ(third.measured.height, um(30));
  EXPECT_EQ(third.name, "column 2 row 0");
  EXPECT_EQ(third.from.line, 4);
  EXPECT_EQ(third.from.column, 19);
  EXPECT_EQ(found->points.back().measured.height, mm(0));
  ASSERT_EQ(found->missing.size(), 1U);
  EXPECT_EQ(found->missing[0].name, "column 1 row 1");
  EXPECT_EQ(found->missing[0].reason, "not probed");
  EXPECT_THAT(found->missing[0].place.in_mm(), ElementsAre(0, 25));
  EXPECT_EQ(found->missing[0].from.line, 5);
  EXPECT_EQ(found->missing[0].from.column, 15);
}

TEST(HeightMapCsv, ReadsEveryVersionsHeader) {
  const std::string v1 = "RepRapFirmware height map file v1\n";
  const std::string v2 = "RepRapFirmware height map file v2 generated at 2024-02-29 23:59\r\n";
  expect_three_by_two(read(v2 + kNew + "X,Y,-10,10,5,25,-1.00,10.00,20.00,3,2\n" + kRows));
  expect_three_by_two(read(v1 + kOld + "-10,10,5,25,-1,10,20,3,2\n" + kRows));
  // One spacing for both: the rows end where no other fits.
  const auto oldest = read(v1 + kOldest + "-10,10,5,24,-1,10,3,2\n" + kRows);
  ASSERT_TRUE(oldest) << oldest.error().text();
  EXPECT_EQ(oldest->grid->y.step_mm, 10);
  EXPECT_EQ(oldest->grid->y.last_mm(), 15);
}

TEST(HeightMapCsv, TellsAZeroFromAMissingPoint) {
  const auto found = read(std::string("RepRapFirmware height map file v2\n") + kNew +
                          "X,Y,0,10,0,10,-1,10,10,2,2\n0,0.000\n0.0,-0.000\n");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->points.size(), 3U);
  ASSERT_EQ(found->missing.size(), 1U);
  EXPECT_EQ(found->missing[0].name, "column 0 row 0");
}

TEST(HeightMapCsv, SaysWhatLiesBeyondTheRadius) {
  const auto found = read(std::string("RepRapFirmware height map file v2\n") + kNew +
                          "X,Y,-10,10,-10,10,12,10,10,3,3\n0,0.1,0\n0.1,0.1,0\n0,0.1,0\n");
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->missing.size(), 5U);
  EXPECT_EQ(found->missing[0].reason, "beyond the probed radius of 12");
  EXPECT_EQ(found->missing[2].name, "column 2 row 1");
  EXPECT_EQ(found->missing[2].reason, "not probed");
}

TEST(HeightMapCsv, HoldsTheFirstLinesFiguresAgainstTheHeights) {
  const auto with = [](const std::string& figures) {
    return read("RepRapFirmware height map file v2 generated at 2024-02-29 23:59, " + figures +
                "\n" + kNew + "X,Y,-10,10,5,25,-1.00,10.00,20.00,3,2\n" + kRows);
  };
  // Of 0.01, 0.02, 0.03, -0.01 and 0, root mean square about 0.01: sqrt(0.0002).
  expect_three_by_two(with("min error -0.010, max error 0.030, mean 0.010, deviation 0.014"));
  expect_three_by_two(with("mean error 0.01, deviation 0.01"));
  EXPECT_THAT(with("min error -0.010, max error 0.030, mean 0.013, deviation 0.014"),
              FailsWith(Code::MeasurementFile, "heightmap.csv:1:101: error[measurement-file]"));
  EXPECT_THAT(with("max error 0.032"), FailsWith(Code::MeasurementFile, "\"max error 0.032\""));
  EXPECT_THAT(with("min error 0.010"), FailsWith(Code::MeasurementFile, "-0.010"));
  EXPECT_THAT(with("deviation 0.020"), FailsWith(Code::MeasurementFile, "0.014"));
  EXPECT_THAT(with("deviation much"), FailsWith(Code::MeasurementFile, "\"much\""));
}

TEST(HeightMapCsv, RefusesWhatIsNoHeightMap) {
  const std::string first = "RepRapFirmware height map file v2\n";
  const auto refused = [](const std::string& text, const char* message) {
    EXPECT_THAT(read(text), FailsWith(Code::MeasurementFile, message));
  };
  refused("", "heightmap.csv:1:1: error[measurement-file]");
  refused("RepRapFirmware height map file v3\n", ":1:1: ");
  refused("RepRapFirmware height map file v12\n", ":1:1: ");
  refused(first, ":2:1: error[measurement-file]");
  refused(first + "xmin,xmax\n", ":2:1: error[measurement-file]");
  refused(first + kNew, ":3:1: error[measurement-file]");
  const auto grid = [&](const std::string& values) {
    return first + kNew + values + "\n1.0,1.0\n1.0,1.0\n";
  };
  refused(grid("X,Y,0,10,0,10,-1,10,10,2"), ":3:1: error[measurement-file]");
  refused(grid("X,Z,0,10,0,10,-1,10,10,2,2"), ":3:3: error[measurement-file]");
  refused(grid("X,Y,0,ten,0,10,-1,10,10,2,2"), ":3:7: error[measurement-file]");
  refused(grid("X,Y,0,10,0,10,-1,nan,10,2,2"), ":3:18: ");
  refused(grid("X,Y,0,10,0,10,-1,10,10,2,3"), ":3:26: ");
  refused(grid("X,Y,0,10,0,10,-1,0,10,2,2"), ":3:23: error[measurement-file]");
  refused(grid("X,Y,0,10,0,10,-1,10,10,2,1"), ":3:26: error[measurement-file]");
  refused(grid("X,Y,0,1e5,0,1e5,-1,1,1,100000,100000"), "100000");
  refused(grid("X,Y,0,10,0,10,-1,10,10,2,2") + "1.0,1.0\n", ":6:1: error[measurement-file]");
  const std::string good = first + kNew + "X,Y,0,10,0,10,-1,10,10,2,2\n";
  refused(good + "1.0,1.0\n", ":5:1: error[measurement-file]");
  refused(good + "1.0\n1.0,1.0\n", ":4:1: error[measurement-file]");
  refused(good + "1.0,\n1.0,1.0\n", ":4:5: error[measurement-file]");
  refused(good + "1.0,1.0x\n1.0,1.0\n", ":4:5: error[measurement-file]");
  refused(good + "1.0,1e999\n1.0,1.0\n", ":4:5: ");
  refused(good + std::string(70'000, ',') + "\n", ":4:1: error[measurement-file]");
}

}  // namespace
}  // namespace panelcal
