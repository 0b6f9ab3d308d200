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
  refused("", "autolevel.probe: error[measurement-file]");
  refused("0 20\n", "autolevel.probe:1:1: error[measurement-file]");
  refused("0 20 1\n", ":1:6: error[measurement-file]");
  refused("0 20 2.5\n", ":1:6: ");
  refused("20 0 3\n-5 5 2\n-2 3 50\n", "-10 ");
  refused("0 20 99999\n-5 5 99999\n-2 3 50\n", "100000");
  refused(kHeader + "0 -5 0.1\n", "6 nodes");
  refused(kHeader + "1.1 -5 0.1\n", ":6:1: error[measurement-file]");
  refused(kHeader + "0 -3.5 0.1\n", ":6:3: error[measurement-file]");
  refused(kHeader + "30 -5 0.1\n", ":6:1: ");
  refused(kHeader + "0 -5 0.1\n0 -5 0.2\n", ":7:1: error[measurement-file]");
  refused("0 1 2\n0 1 2\n0 1 9\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n2 2 2\n",
          ":8:1: error[measurement-file]");
}

}  // namespace
}  // namespace panelcal
