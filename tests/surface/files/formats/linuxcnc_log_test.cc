// SPDX-License-Identifier: Apache-2.0
#include "surface/files/probe_file.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

Expected<ProbeFile> read(std::string_view text) {
  return parse_probe_file(text, "probe-results.txt", {.format = ProbeFormat::LinuxCncLog});
}

TEST(LinuxCncLog, ReadsPlacesAndHeights) {
  const auto found = read(
      "10.000000 20.500000 -0.125000 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000\n"
      "\n"
      "  -3 4\t0.5\r\n"
      "0 0 1 -0.000000 0 0 0 0 0.25");
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->points.size(), 3U);
  EXPECT_THAT(found->points[0].place.in_mm(), ElementsAre(10, 20.5));
  EXPECT_EQ(found->points[0].measured.height, mm(-0.125));
  EXPECT_THAT(found->points[1].place.in_mm(), ElementsAre(-3, 4));
  EXPECT_EQ(found->points[1].name, "probe of line 3");
  EXPECT_EQ(found->points[1].from.line, 3);
  EXPECT_EQ(found->points[1].from.column, 3);
  // W carries the same tool as Z.
  EXPECT_EQ(found->points[2].measured.height, mm(1.25));
  EXPECT_TRUE(found->missing.empty());
  EXPECT_FALSE(found->grid);
}

TEST(LinuxCncLog, RefusesWhatIsNoLog) {
  const auto refused = [](std::string_view text, const char* message) {
    EXPECT_THAT(read(text), FailsWith(Code::MeasurementFile, message));
  };
  refused("1 2 3\n1 2\n", "probe-results.txt:2:1: error[measurement-file]");
  refused("1 2 3 0 0 0 0 0 0 0\n", ":1:1: error[measurement-file]");
  refused("1 2 z\n", ":1:5: error[measurement-file]");
  refused("1 2 inf\n", ":1:5: ");
  refused("1 2e7 3\n", ":1:3: ");
  refused("1 2 +3\n", ":1:5: ");
  refused("1 2 3 90\n", ":1:7: error[measurement-file]");
  refused("1 2 3 0 0 0 0 5\n", ":1:15: error[measurement-file]");
}

TEST(LinuxCncLog, EndsBeforeMemoryDoes) {
  std::string text;
  for (std::size_t i = 0; i < kMaxFileProbes; ++i) text += "1 2 3\n";
  EXPECT_TRUE(read(text));
  EXPECT_THAT(read(text + "1 2 3\n"), FailsWith(Code::MeasurementFile, "100000"));
}

}  // namespace
}  // namespace panelcal
