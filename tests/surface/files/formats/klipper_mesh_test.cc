// SPDX-License-Identifier: Apache-2.0
// Klipper, bed_mesh.py, version 1 of profiles; Moonraker's object bed_mesh.
#include <string>

#include "surface/files/probe_file.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kPoints = "#*# points =\n#*# \t0.1, 0.2, 0.3\n#*# \t0.4, 0.5, 0.6\n";
const std::string kPlaces =
    "#*# x_count = 3\n#*# y_count = 2\n#*# min_x = 10.0\n#*# max_x = 50.0\n"
    "#*# min_y = 20.0\n#*# max_y = 80.0\n";

std::string mesh(const std::string& name) {
  return "#*# [bed_mesh " + name + "]\n#*# version = 1\n" + kPoints + kPlaces;
}

Expected<ProbeFile> config(const std::string& text, const ProbeFileOptions& options = {}) {
  return parse_probe_file(text, "printer.cfg", options);
}

void refused(const std::string& text, const char* message, const ProbeFileOptions& options = {}) {
  EXPECT_THAT(config(text, options), FailsWith(Code::MeasurementFile, message));
}

TEST(KlipperConfig, ReadsTheSavedMesh) {
  const auto found =
      config("[bed_mesh]\nspeed: 100\n\n#*# [probe]\n#*# z_offset = 1\n" + mesh("default"));
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->format, ProbeFormat::KlipperConfig);
  ASSERT_EQ(found->points.size(), 6U);
  EXPECT_THAT(found->points[1].place.in_mm(), ElementsAre(30, 20));
  EXPECT_EQ(found->points[1].measured.height, mm(0.2));
  EXPECT_THAT(found->points[3].place.in_mm(), ElementsAre(10, 80));
  EXPECT_EQ(found->points[3].measured.height, mm(0.4));
  EXPECT_EQ(found->points[3].from.line, 10);
  EXPECT_EQ(found->points[3].from.column, 6);
  EXPECT_EQ(found->zero, "the printer's zero, heights from its nozzle at Z 0; mesh \"default\"");
}

TEST(KlipperConfig, WantsOneOfSeveralMeshesByName) {
  refused(mesh("default") + mesh("PEI"), "\"default\", \"PEI\"");
  refused(mesh("default"), "\"default\"", {.profile = "PEI"});
  const auto found = config(mesh("default") + mesh("PEI"), {.profile = "PEI"});
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_THAT(found->zero, HasSubstr("\"PEI\""));
  refused("[bed_mesh]\nspeed: 100\n", "printer.cfg: ");
}

TEST(KlipperConfig, LeavesOutHeightsThatKlipperMadeUp) {
  const auto faulty =
      config("[bed_mesh]\nfaulty_region_1_min: 25, 15\nfaulty_region_1_max: 35, 25\n" + mesh("a"));
  ASSERT_TRUE(faulty) << faulty.error().text();
  ASSERT_EQ(faulty->missing.size(), 1U);
  EXPECT_THAT(faulty->missing[0].place.in_mm(), ElementsAre(30, 20));
  const std::string round =
      "[bed_mesh]\nmesh_radius: 20\nmesh_origin: 30, 20\nzero_reference_position: 30, 20\n";
  // No row of a round bed is beyond its radius.
  refused(round + mesh("a"), "printer.cfg:9:16: ");
}

TEST(KlipperConfig, RefusesMeshesThatAreNotWhole) {
  refused("#*# [bed_mesh a]\n#*# version = 1\n" + kPoints, "printer.cfg:1:15: ");
  refused("#*# [bed_mesh a]\n#*# version = 2\n" + kPoints + kPlaces, "printer.cfg:2:15: ");
  refused("#*# [bed_mesh a]\n#*# points =\n#*# \t0.1, 0.2, 0.3\n" + kPlaces, "printer.cfg:1:15: ");
  refused("#*# [bed_mesh a]\n#*# points =\n#*# \t0.1, 0.2, 0.3\n#*# \t0.4, 0.5\n" + kPlaces,
          "printer.cfg:4:6: ");
  refused("#*# [bed_mesh a]\n#*# points =\n#*# \t0.1, 0.2, nan\n#*# \t0.4, 0.5, 0.6\n" + kPlaces,
          "printer.cfg:3:16: ");
  // Of max_y = 80.0.
  refused(mesh("a").substr(0, mesh("a").size() - 4), "printer.cfg:11:1: ");
  refused(mesh("a") + "#*# x_offset = 3\n", "printer.cfg:12:5: ");
  refused(mesh("a") + "#*# max_y = 3\n", "printer.cfg:12:5: ");
  refused(mesh("a") + mesh("a"), "printer.cfg:12:15: ");
  refused(mesh("a"), "--unit inch", {.unit = inch(1)});
}

std::string answer(const std::string& loaded, const std::string& profiles) {
  return "{\"result\": {\"status\": {\"bed_mesh\": {\"profile_name\": \"a\",\n\"mesh_min\": [10, "
         "20], \"mesh_max\": [50, 80],\n"
         "\"probed_matrix\": " +
         loaded + ",\n\"profiles\": {" + profiles + "}}}}}";
}

std::string profile(const std::string& name, const std::string& points) {
  return "\"" + name + "\": {\"points\": " + points +
         ",\n\"mesh_params\": {\"min_x\": 10, \"max_x\": 50, \"min_y\": 20, \"max_y\": 80, "
         "\"x_count\": 3, \"y_count\": 2}}";
}

const std::string kMatrix = "[[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]";

TEST(MoonrakerJson, ReadsTheLoadedMeshOrAProfile) {
  for (const std::string& text :
       {answer(kMatrix, profile("a", kMatrix)), answer("[[]]", profile("a", kMatrix))}) {
    const auto found = parse_probe_file(text, "answer.json");
    ASSERT_TRUE(found) << found.error().text();
    ASSERT_EQ(found->points.size(), 6U);
    EXPECT_THAT(found->points[3].place.in_mm(), ElementsAre(10, 80));
    EXPECT_EQ(found->points[3].measured.height, mm(0.4));
  }
  const auto found = parse_probe_file(answer(kMatrix, ""), "answer.json");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->points[3].from.line, 3);
  EXPECT_EQ(found->points[3].from.column, 37);
}

TEST(MoonrakerJson, RefusesWhatContradictsItself) {
  const auto refuses = [](const std::string& text, Code code, const char* message) {
    EXPECT_THAT(parse_probe_file(text, "answer.json"), FailsWith(code, message));
  };
  const std::string other = "[[0.1, 0.2, 0.3], [0.4, 0.5, 0.7]]";
  refuses(answer(kMatrix, profile("a", other)), Code::MeasurementFile, "answer.json:3:18: ");
  EXPECT_TRUE(
      parse_probe_file(answer(kMatrix, profile("a", other)), "answer.json", {.profile = "a"}));
  refuses(answer("[[]]", profile("a", kMatrix) + "," + profile("b", kMatrix)),
          Code::MeasurementFile,
          "\"b\"");
  refuses(
      answer("[[0.1, 0.2, 0.3], [0.4, null, 0.6]]", ""), Code::MeasurementFile, "answer.json:3:");
  refuses(answer("[[0.1, 0.2, 0.3], [0.4]]", ""), Code::MeasurementFile, "answer.json:3:");
  refuses(answer(kMatrix, "").substr(0, 150), Code::JsonSyntax, "answer.json:");
}

/// Of the square from (-20, -20) to (20, y_high).
std::string square(const std::string& matrix, const std::string& y_high = "20") {
  return "{\"bed_mesh\": {\"profile_name\": \"a\", \"mesh_min\": [-20, -20], \"mesh_max\": [20, " +
         y_high + "],\n\"probed_matrix\":\n" + matrix + ", \"profiles\": {}}}";
}

// Within a circle of 20 mm lie (0, -20), the middle row and (0, 20); of five rows also three nodes
// of the second and fourth: (10, 10) is at 14.1 mm, (20, 10) at 22.4 mm.
TEST(MoonrakerJson, RefusesHeightsThatKlipperMadeUpOnARoundBed) {
  const std::string first = "[[0.1, 0.1, 0.1], [0.2, 0.3, 0.4], ";
  EXPECT_THAT(parse_probe_file(square(first + "[0.5, 0.5, 0.5]]"), "answer.json"),
              FailsWith(Code::MeasurementFile, "answer.json:3:3: "));
  const std::string middle = "[0.1, 0.2, 0.3, 0.4, 0.5], ";
  const auto five = [&](const std::string& second) {
    return square("[[0.1, 0.1, 0.1, 0.1, 0.1], " + second + ", " + middle +
                  "[0.3, 0.3, 0.4, 0.5, 0.5], [0.6, 0.6, 0.6, 0.6, 0.6]]");
  };
  EXPECT_THAT(parse_probe_file(five("[0.2, 0.2, 0.3, 0.4, 0.4]"), "answer.json"),
              FailsWith(Code::MeasurementFile, "mesh_radius"));
  // Probed there: one end of a row has its own height, or the bed is no square.
  for (const std::string& text : {square(first + "[0.5, 0.5, 0.6]]"),
                                  square(first + "[0.5, 0.5, 0.5]]", "30"),
                                  five("[0.2, 0.2, 0.3, 0.4, 0.5]")}) {
    const auto found = parse_probe_file(text, "answer.json");
    EXPECT_TRUE(found) << found.error().text();
  }
}

}  // namespace
}  // namespace panelcal
