// SPDX-License-Identifier: Apache-2.0
// GRBL 1.1 interface: [PRB:x,y,z:1] is in machine coordinates, work = machine - (G54 + G92 + TLO).
#include <string>

#include "surface/files/probe_file.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kRounding_mm = 1e-9;

Expected<ProbeFile> read(const std::string& text, const ProbeFileOptions& options = {}) {
  return parse_probe_file(text, "grbl.log", options);
}

void refused(const std::string& text, const char* message) {
  EXPECT_THAT(read(text), FailsWith(Code::MeasurementFile, message));
}

TEST(GrblConsole, TakesTheWorkOffsetOffEachProbe) {
  const auto found = read(
      "ok\n<Idle|MPos:-90.000,-70.000,-1.000|FS:0,0|WCO:-100.000,-80.000,-21.500>\n"
      "> G38.2 Z-3 "
      "F50\n[PRB:-90.000,-75.000,-21.400:1]\nok\n[PRB:-80.000,-75.000,-21.550:1]\nok\n");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->format, ProbeFormat::GrblConsole);
  ASSERT_EQ(found->points.size(), 2U);
  EXPECT_THAT(found->points[0].place.in_mm(), ElementsAre(10, 5));
  EXPECT_THAT(found->points[0].measured.height.in_mm(), DoubleNear(0.1, kRounding_mm));
  EXPECT_THAT(found->points[1].measured.height.in_mm(), DoubleNear(-0.05, kRounding_mm));
  EXPECT_EQ(found->points[1].name, "probe of line 6");
  EXPECT_EQ(found->points[1].from.line, 6);
  EXPECT_EQ(found->points[1].from.column, 6);
  EXPECT_EQ(found->zero, "the work zero, by WCO of line 2");
  EXPECT_EQ(found->unit, "mm, as none is stated");
}

TEST(GrblConsole, AddsG54AndG92AndToolLengthUp) {
  const auto found = read(
      "[G54:1.000,2.000,3.000]\n[G92:0.500,0.000,0.250]\n[TLO:-1.000]\n[PRB:0.000,0.000,0.000:0]"
      "\nok\n"
      "[PRB:11.500,22.000,2.300:1]\n");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_THAT(found->points[0].place.in_mm(), ElementsAre(10, 20));
  EXPECT_THAT(found->points[0].measured.height.in_mm(), DoubleNear(0.05, kRounding_mm));
  EXPECT_THAT(found->zero, HasSubstr("G54 + G92 + TLO of line 1, taken as active"));
}

TEST(GrblConsole, NamesTheMachinesZeroWhereNoWorkZeroIsStated) {
  const auto found = read("[PRB:1.000,2.000,-3.000:1]\n[PRB:2.000,2.000,-3.010:1]\n");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_THAT(found->points[0].place.in_mm(), ElementsAre(1, 2));
  EXPECT_EQ(found->zero, "the machine's zero: the console has neither WCO nor $#");
}

TEST(GrblConsole, CountsNeitherFailedProbesNorWhatParametersRepeat) {
  const auto found = read(
      "[PRB:0.000,0.000,0.000:0]\n[PRB:1.000,2.000,-3.000:1]\nok\n[PRB:5.000,2.000,-9.000:0]\nok\n"
      "[TLO:0.000]\n[PRB:1.000,2.000,-3.000:1]\nok\n");
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->points.size(), 1U);
  ASSERT_EQ(found->missing.size(), 1U);
  EXPECT_THAT(found->missing[0].place.in_mm(), ElementsAre(5, 2));
  EXPECT_EQ(found->missing[0].reason, "the probe touched nothing");
  EXPECT_EQ(found->missing[0].from.line, 4);
}

TEST(GrblConsole, TakesInchesFromSetting13OrTheOption) {
  const auto stated = read("$13=1\n[PRB:1.0000,2.0000,-0.5000:1]\n");
  ASSERT_TRUE(stated) << stated.error().text();
  EXPECT_THAT(stated->points[0].place.in_mm(), ElementsAre(25.4, 50.8));
  EXPECT_EQ(stated->points[0].measured.height, mm(-12.7));
  const auto told = read("[PRB:1.0000,2.0000,-0.5000:1]\n", {.unit = inch(1)});
  ASSERT_TRUE(told) << told.error().text();
  EXPECT_EQ(told->points[0].measured.height, mm(-12.7));
  EXPECT_EQ(told->unit, "inch, by --unit");
  EXPECT_THAT(read("$13=0\n[PRB:1.000,2.000,3.000:1]\n", {.unit = inch(1)}),
              FailsWith(Code::MeasurementFile, "grbl.log:1:1: "));
  refused("[PRB:1.0000,2.0000,-0.5000:1]\n", "grbl.log:1:6: ");
  refused("$13=0\n[PRB:1.000,2.000,3.000:1]\n$13=1\n", "grbl.log:3:5: ");
}

TEST(GrblConsole, RefusesAWorkZeroThatMoved) {
  const std::string first = "<Idle|MPos:0,0,0|WCO:1.000,0.000,0.000>\n[PRB:1.000,2.000,3.000:1]\n";
  refused(first + "<Idle|MPos:0,0,0|WCO:2.000,0.000,0.000>\n", "grbl.log:3:1: ");
  // What held ahead of the probing does not matter.
  EXPECT_TRUE(read("<Idle|MPos:0,0,0|WCO:9.000,0.000,0.000>\n" + first));
  // The sum of what $# says is another.
  refused(first + "[G54:1.000,0.000,0.010]\n[TLO:0.000]\n", "grbl.log:1:1: ");
  EXPECT_TRUE(read(first + "[G54:9.000,0.000,0.000]\n[G55:1.000,0.000,0.000]\n"));
  refused(first + "[GC:G0 G54 G17]\n[G54:9.000,0.000,0.000]\n[G55:1.000,0.000,0.000]\n",
          "grbl.log:1:1: ");
  refused("[GC:G0 G56 G17]\n[G54:1.000,0.000,0.000]\n[PRB:1.000,2.000,3.000:1]\n", ":1:8: ");
  refused("[GC:G0 G54]\n[PRB:1.000,2.000,3.000:1]\n[GC:G0 G55]\n", "grbl.log:3:8: ");
  refused("G55\nok\n[G54:1.000,0.000,0.000]\n[PRB:1.000,2.000,3.000:1]\n", "grbl.log:1:1: ");
}

TEST(GrblConsole, RefusesProbesOnBothSidesOfALostPosition) {
  const std::string probe = "[PRB:1.000,2.000,3.000:1]\n";
  refused(probe + "ALARM:1\n" + probe, "grbl.log:2:1: ");
  refused(probe + "Grbl 1.1h ['$' for help]\n" + probe, "grbl.log:2:1: ");
  EXPECT_TRUE(read("Grbl 1.1h ['$' for help]\n" + probe + "ALARM:5\n" + probe + "ALARM:1\n"));
}

TEST(GrblConsole, RefusesDamagedProbes) {
  refused("ok\n[PRB:1.000,2.000,3.000:1", "grbl.log:2:2: ");
  refused("[PRB:1.000,2.000,3.000]\n", "grbl.log:1:");
  refused("[PRB:1.000,2.000,3.000:2]\n", "grbl.log:1:24: ");
  refused("[PRB:1.000,2.000:1]\n", "grbl.log:1:6: ");
  refused("[PRB:1.000,nan,3.000:1]\n", "grbl.log:1:12: ");
  refused("[PRB:1.000,2.000,1e9:1]\n", "grbl.log:1:18: ");
  refused("[PRB:1.000,2.000,3.000,0.000:1]\n[PRB:1.000,2.000,3.000,9.000:1]\n", "grbl.log:2:6: ");
  refused("[PRB:0.000,0.000,0.000:0]\n", "no height at all");
}

}  // namespace
}  // namespace panelcal
