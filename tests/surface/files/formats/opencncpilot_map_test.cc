// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "surface/files/probe_file.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

const std::string kOpen =
    "<heightmap MinX=\"-10\" MinY=\"0\" MaxX=\"10\" MaxY=\"30\" SizeX=\"3\" SizeY=\"2\">\n";
const std::string kClose = "</heightmap>\n";

Expected<ProbeFile> read(const std::string& text) {
  return parse_probe_file(text, "board.hmap");
}

TEST(OpenCncPilotMap, ReadsPointsAndMissesTheOthers) {
  const auto found = read("\xEF\xBB\xBF<?xml version=\"1.0\" encoding=\"utf-8\"?>\r\n" + kOpen +
                          "  <point X=\"0\" Y=\"0\">0.125</point>\r\n"
                          "  <!-- the clamp --> <point Y=\"1\" X='2' > -1E-05 </point>\n" +
                          kClose);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->points.size(), 2U);
  EXPECT_EQ(found->points[0].measured.height, mm(0.125));
  EXPECT_EQ(found->points[0].from.line, 3);
  EXPECT_EQ(found->points[0].from.column, 22);
  EXPECT_THAT(found->points[1].place.in_mm(), ElementsAre(10, 30));
  EXPECT_EQ(found->points[1].name, "column 2 row 1");
  EXPECT_EQ(found->points[1].measured.height, mm(-1e-5));
  ASSERT_EQ(found->missing.size(), 4U);
  EXPECT_EQ(found->missing[0].name, "column 1 row 0");
  EXPECT_EQ(found->missing[3].name, "column 1 row 1");
}

TEST(OpenCncPilotMap, RefusesWhatIsNone) {
  const auto refused = [](const std::string& text, const char* message) {
    EXPECT_THAT(read(text), FailsWith(Code::MeasurementFile, message));
  };
  refused("", "board.hmap:1:1: error[measurement-file]");
  refused("<?xml version=\"1.0\"", ":1:1: ");
  refused("<!DOCTYPE a [<!ENTITY b \"c\">]>", ":1:2: error[measurement-file]");
  refused("<html>", ":1:2: error[measurement-file]");
  refused("<heightmap MinX=1", ":1:17: error[measurement-file]");
  refused("<heightmap MinX=\"1", ":1:1");
  refused("<heightmap MinX=\"&a;\">", ":1:1");
  refused("<heightmap MinX=\"1\" MinX=\"2\">", ":1:21: error[measurement-file]");
  refused("<heightmap Minx=\"1\">", ":1:12: error[measurement-file]");
  refused("<heightmap MinX=\"1\" MinY=\"2\">", "MaxX");
  const std::string point = "<point X=\"0\" Y=\"0\">1</point>";
  refused(kOpen, ":2:1: error[measurement-file]");
  refused(kOpen + point + "</map>", ":2:29: error[measurement-file]");
  refused(kOpen + point + kClose + "<more/>", ":3:1: error[measurement-file]");
  refused(kOpen + "<point X=\"3\" Y=\"0\">1</point>", ":2:11: error[measurement-file]");
  refused(kOpen + "<point X=\"0\" Y=\"0\"/>", ":2:");
  refused(kOpen + "<point X=\"0\" Y=\"0\">1,5</point>", ":2:20: error[measurement-file]");
  refused(kOpen + "<point X=\"0\" Y=\"0\">1<b/></point>", ":2:21: error[measurement-file]");
  refused(kOpen + point + point, "column 0 row 0");
  refused("<heightmap MinX=\"0\" MinY=\"0\" MaxX=\"0\" MaxY=\"1\" SizeX=\"2\" SizeY=\"2\"/>",
          ":1:");
  refused(
      "<heightmap MinX=\"0\" MinY=\"0\" MaxX=\"9\" MaxY=\"1\" SizeX=\"99999\" SizeY=\"99999\"/>",
      "100000");
}

}  // namespace
}  // namespace panelcal
