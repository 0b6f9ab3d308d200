// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "surface/files/probe_file.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

const std::string kHeader = "0 20 3\n-5 5 2\n-2 3 50\n\n\n";

Expected<ProbeFile> read(const std::string& text) {
  return parse_probe_file(text, "autolevel.probe");
}

TEST(BcncProbe, ReadsNodesInAnyOrder) {
  const auto found = read(kHeader +
                          "0 -5 0.1\n10 -5 0.2\n20 -5 0.3\n\n"
                          "20 5 0.6\n10.9 4.5 0.5\n0 5 0\n\n");
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->points.size(), 6U);
  EXPECT_THAT(found->points[4].place.in_mm(), ElementsAre(10, 5));
  EXPECT_EQ(found->points[4].measured.height, mm(0.5));
  EXPECT_EQ(found->points[4].name, "column 1 row 1");
  EXPECT_EQ(found->points[4].from.line, 11);
  EXPECT_EQ(found->points[4].from.column, 10);
  EXPECT_EQ(found->grid->x.n_nodes, 3);
  EXPECT_EQ(found->grid->y.first_mm, -5);
}

TEST(BcncProbe, RefusesWhatBcncWouldSkip) {
  const auto refused = [](const std::string& text, const char* message) {
    EXPECT_THAT(read(text), FailsWith(Code::MeasurementFile, message));
  };
  refused("",
          "autolevel.probe: error[measurement-file]: the file ends too early, expected xmin xm");
  refused("0 20\n",
          "autolevel.probe:1:1: error[measurement-file]: a line of 2 words, expected xmin");
  refused("0 20 1\n", ":1:6: error[measurement-file]: \"1\", expected a whole number from 2 to");
  refused("0 20 2.5\n", ":1:6: ");
  refused("20 0 3\n-5 5 2\n-2 3 50\n", "nodes that are -10 apart, expected at least 0.001");
  refused("0 20 99999\n-5 5 99999\n-2 3 50\n", "expected at most 100000 in all");
  refused(kHeader + "0 -5 0.1\n", "the file ends too early, expected x y z of 6 nodes, has 1");
  refused(kHeader + "1.1 -5 0.1\n",
          ":6:1: error[measurement-file]: \"1.1\", expected a node of the");
  refused(kHeader + "0 -3.5 0.1\n", ":6:3: error[measurement-file]: \"-3.5\"");
  refused(kHeader + "30 -5 0.1\n", ":6:1: ");
  refused(kHeader + "0 -5 0.1\n0 -5 0.2\n",
          ":7:1: error[measurement-file]: column 0 row 0 again, expected each node once; line 6");
  refused("0 1 2\n0 1 2\n0 1 9\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n2 2 2\n",
          ":8:1: error[measurement-file]: \"2\", expected the end of the file");
}

}  // namespace
}  // namespace panelcal
