// SPDX-License-Identifier: Apache-2.0
#include "surface/files/probe_file.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

constexpr const char* kTwoByTwo =
    "RepRapFirmware height map file v2\n"
    "axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1\n"
    "X,Y,0,10,0,20,-1,10,20,2,2\n"
    "1.5,2.5\n"
    "3.5,4.5\n";

ProbeFormat format_of(const char* text, const std::string& file) {
  const auto found = parse_probe_file(text, file);
  EXPECT_TRUE(found) << found.error().text();
  return found ? found->format : ProbeFormat::BcncProbe;
}

TEST(ProbeFile, KnowsAFormatByItsTextElseByItsName) {
  const char* hmap =
      R"(<heightmap MinX="0" MinY="0" MaxX="1" MaxY="1" SizeX="2" SizeY="2"><point X="0" Y="0">1</point></heightmap>)";
  const char* readings =
      R"({"probe":0,"nominal":[1,2],"status":"found","zaxis":0,"height":1,"sigma":0.01})";
  EXPECT_EQ(format_of(kTwoByTwo, "heightmap.csv"), ProbeFormat::HeightMapCsv);
  EXPECT_EQ(format_of(kTwoByTwo, "-"), ProbeFormat::HeightMapCsv);
  EXPECT_EQ(format_of(hmap, "A.HMAP"), ProbeFormat::OpenCncPilotMap);
  EXPECT_EQ(format_of(hmap, "a"), ProbeFormat::OpenCncPilotMap);
  EXPECT_EQ(format_of(readings, "probes.jsonl"), ProbeFormat::RecordedProbes);
  EXPECT_EQ(format_of(readings, "probes.txt"), ProbeFormat::RecordedProbes);
  EXPECT_EQ(format_of("0 1 2\n0 1 2\n0 1 9\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n", "a.probe"),
            ProbeFormat::BcncProbe);
  EXPECT_EQ(format_of("0 1 2\n", "probe-results.txt"), ProbeFormat::LinuxCncLog);
  // Text rules over names, and tells a grid from a log of as many numbers.
  EXPECT_EQ(format_of("0 1 2\n", "a.csv"), ProbeFormat::LinuxCncLog);
  EXPECT_EQ(format_of("0 1 2\n0 1 2\n0 1 9\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n", "a.txt"),
            ProbeFormat::BcncProbe);
  EXPECT_EQ(format_of("0 1 2\n0 1 2\n0 1 9\n0 0 1\n1 0 1\n0 1 1\n", "a.txt"),
            ProbeFormat::LinuxCncLog);
  // Of a text that is cut off the name says what it was to be.
  EXPECT_THAT(parse_probe_file("0 20\n", "a.probe"),
              FailsWith(Code::MeasurementFile, "a.probe:1:1: error[measurement-file]"));
}

TEST(ProbeFile, NamesWhatIsReadWhereAFileIsNoneOfIt) {
  const auto found = parse_probe_file("\n  Hello\n", "a.txt");
  EXPECT_THAT(found, FailsWith(Code::MeasurementFile, "a.txt:2:1: error[measurement-file]"));
  for (const char* kind : {"\"  Hello\"",
                           "RepRapFirmware's",
                           "LinuxCNC's",
                           "bCNC's",
                           "OpenCNCPilot's",
                           "panelcal's",
                           "Klipper's",
                           "Moonraker's",
                           "Marlin's",
                           "GRBL's",
                           "Candle's",
                           "x, y and z"}) {
    EXPECT_THAT(found, FailsWith(Code::MeasurementFile, kind));
  }
}

TEST(ProbeFile, RefusesSignsOfTwoFormats) {
  EXPECT_THAT(
      parse_probe_file("[PRB:1.000,2.000,3.000:1]\nBed X: 1.000 Y: 2.000 Z: 3.000\n", "a.log"),
      FailsWith(Code::MeasurementFile, "marlin and grbl"));
}

TEST(ProbeFile, RefusesOptionsThatItsFormatDoesNotTake) {
  const auto refused = [](const ProbeFileOptions& options, const char* text) {
    EXPECT_THAT(parse_probe_file(kTwoByTwo, "a.csv", options),
                FailsWith(Code::MeasurementFile, text));
  };
  refused({.profile = "default"}, "--profile");
  refused({.mesh = MeshCorners{{0, 0}, {1, 1}}}, "--mesh-mm");
}

TEST(ProbeFile, StatesUnitAndZero) {
  const auto found = parse_probe_file(kTwoByTwo, "heightmap.csv");
  EXPECT_EQ(found->unit, "mm, as none is stated");
  EXPECT_EQ(found->zero, "the machine's zero");
}

TEST(ProbeFile, NamesItsFormats) {
  for (const ProbeFormat format : {ProbeFormat::HeightMapCsv,
                                   ProbeFormat::LinuxCncLog,
                                   ProbeFormat::BcncProbe,
                                   ProbeFormat::OpenCncPilotMap,
                                   ProbeFormat::RecordedProbes,
                                   ProbeFormat::KlipperConfig,
                                   ProbeFormat::MoonrakerJson,
                                   ProbeFormat::MarlinConsole,
                                   ProbeFormat::GrblConsole,
                                   ProbeFormat::CandleMap,
                                   ProbeFormat::PlainCsv}) {
    EXPECT_EQ(probe_format_from_name(name_of(format)), format);
  }
  EXPECT_EQ(name_of(ProbeFormat::RecordedProbes), "probes");
  EXPECT_FALSE(probe_format_from_name("excel"));
}

TEST(ProbeFile, TakesUnitAndSigmaFromTheOptions) {
  const auto found =
      parse_probe_file(kTwoByTwo, "heightmap.csv", {.sigma = um(7), .unit = inch(1)});
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->points.size(), 4U);
  const ProbePoint& last = found->points.back();
  EXPECT_THAT(last.place.in_mm(), ElementsAre(254, 508));
  EXPECT_EQ(last.measured.height, inch(4.5));
  EXPECT_EQ(last.measured.sigma, um(7));
  EXPECT_EQ(found->grid->y.step_mm, 508);
}

TEST(ProbeFile, RefusesOptionsThatMakeNoSense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const ProbeFileOptions& options, const char* text) {
    EXPECT_THAT(parse_probe_file(kTwoByTwo, "a.csv", options), FailsWith(Code::ConfigValue, text));
  };
  for (const double bad : {0.0, -1.0, nan}) refused({.sigma = mm(bad)}, "sigma_mm");
  for (const double bad : {0.0, nan, 1e9}) refused({.unit = mm(bad)}, "unit_mm");
  refused({.z_axis = -1}, "zaxis is -1");
}

TEST(ProbeFile, RefusesWhatHasNoHeight) {
  EXPECT_THAT(parse_probe_file("", "a.log"), FailsWith(Code::MeasurementFile));
  EXPECT_THAT(parse_probe_file(R"({"probe":0,"nominal":[1,2],"status":"not_found"})", "a.jsonl"),
              FailsWith(Code::MeasurementFile));
  EXPECT_THAT(read_probe_file("/nonexistent/heightmap.csv"), FailsWith(Code::FileUnreadable));
}

}  // namespace
}  // namespace panelcal
