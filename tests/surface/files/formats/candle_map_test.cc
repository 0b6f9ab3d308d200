// SPDX-License-Identifier: Apache-2.0
// Candle 1.1 writes the border, the grid, the interpolation, then rows from low y.
#include <string>

#include "surface/files/probe_file.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

const std::string kHead = "-5.00;10.00;40.00;60.00\r\n3.00;2.00;-1.00;1.00\r\n0;1.00;1.00\r\n";

Expected<ProbeFile> read(const std::string& text) {
  return parse_probe_file(text, "board.map");
}

TEST(CandleMap, ReadsTheBorderAndItsRows) {
  const auto found = read(kHead + "0;0.1;-0.2\r\n0.3;nan;0.5\r\n");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->format, ProbeFormat::CandleMap);
  ASSERT_EQ(found->points.size(), 5U);
  EXPECT_THAT(found->points[1].place.in_mm(), ElementsAre(15, 10));
  EXPECT_THAT(found->points[4].place.in_mm(), ElementsAre(35, 70));
  EXPECT_EQ(found->points[4].measured.height, mm(0.5));
  EXPECT_EQ(found->points[4].from.line, 5);
  ASSERT_EQ(found->missing.size(), 1U);
  EXPECT_THAT(found->missing[0].place.in_mm(), ElementsAre(15, 70));
}

TEST(CandleMap, RefusesWhatIsNotWhole) {
  const auto refused = [](const std::string& text, const char* message) {
    EXPECT_THAT(read(text), FailsWith(Code::MeasurementFile, message));
  };
  refused("-5;10;40\r\n", "board.map:1:1: ");
  refused("-5,00;10,00;40,00;60,00\r\n3;2;-1;1\r\n0;1;1\r\n", "board.map:1:1: ");
  refused("-5;10;40;60\r\n2.5;2;-1;1\r\n0;1;1\r\n", "board.map:2:1: ");
  refused("-5;10;40;0\r\n3;2;-1;1\r\n0;1;1\r\n", "board.map:2:1: ");
  refused(kHead + "0;0.1;-0.2\r\n", "board.map:5:1: ");
  refused(kHead + "0;0.1\r\n0.3;0.4\r\n", "board.map:4:1: ");
  refused(kHead + "0;0.1;x\r\n0.3;0.4;0.5\r\n", "board.map:4:7: ");
  refused(kHead + "0;0.1;-0.2\r\n0.3;0.4;0.5\r\n1;2;3\r\n", "board.map:6:1: ");
  refused(kHead + "0;0.1;-0.2\r\n0.3;0.4;0.5", "board.map:5:1: ");
  refused(kHead + "nan;nan;nan\r\nnan;nan;nan\r\n", "no height at all");
}

}  // namespace
}  // namespace panelcal
