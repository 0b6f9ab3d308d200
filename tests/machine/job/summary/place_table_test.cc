// SPDX-License-Identifier: Apache-2.0
#include "machine/job/summary/place_table.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

PlacedPoint at(double x_mm, double y_mm) {
  PlacedPoint place;
  place.nominal = position_mm<frame::Nominal>(x_mm, y_mm);
  place.corrected = position_mm<frame::Actual>(x_mm + 0.25, y_mm - 0.5);
  place.cov_mm2 = Eigen::Vector2d(9e-6, 4e-6).asDiagonal();
  return place;
}

TEST(PlaceTable, HasShiftSigmaAndRiskOfAHole) {
  PlaceTable table;
  Drill drill;
  static_cast<PlacedPoint&>(drill) = at(10, 20);
  drill.tool = 3;
  drill.risk = 0.125;
  table.put({7, {}, drill, {}, nullptr});
  drill.risk.reset();
  table.put({8, {}, drill, {}, nullptr});
  ASSERT_EQ(table.size(), 2);
  EXPECT_EQ(table.nominal_x_mm[0], 10);
  EXPECT_FLOAT_EQ(table.shift_x_um[0], 250);
  EXPECT_FLOAT_EQ(table.shift_y_um[0], -500);
  EXPECT_FLOAT_EQ(table.sigma_um[0], 3);
  EXPECT_EQ(table.risk[0], 0.125F);
  EXPECT_TRUE(std::isnan(table.risk[1]));
  EXPECT_EQ(table.tool[0], 3);
  EXPECT_EQ(table.line[1], 8);
}

TEST(PlaceTable, HasEndsOfSlotsAndCornersAndStartsOfRouts) {
  PlaceTable table;
  Slot slot;
  slot.start = at(1, 1);
  slot.end = at(2, 1);
  table.put({1, {}, slot, {}, nullptr});
  RapidMove move;
  static_cast<PlacedPoint&>(move) = at(5, 5);
  table.put({2, {}, move, {}, nullptr});
  table.put({3, {}, Plunge(), {}, nullptr});
  Rout rout;
  static_cast<PlacedPoint&>(rout) = at(6, 5);
  table.put({4, {}, rout, {}, nullptr});
  EXPECT_EQ(table.kind, (std::vector<std::uint8_t>{1, 1, 2, 2}));
  EXPECT_EQ(table.nominal_x_mm, (std::vector<double>{1, 2, 5, 6}));
}

TEST(PlaceTable, KnowsBoardsAndFilesByIndex) {
  PlaceTable table;
  const std::vector<int> first = {0, 1};
  const std::vector<int> second = {1, 1};
  table.put({1, first, Drill(), {}, nullptr});
  table.put({2, second, Drill(), "PINS", nullptr});
  table.put({3, second, Drill(), "PINS", nullptr});
  table.put({4, first, Drill(), {}, nullptr});
  EXPECT_EQ(table.board, (std::vector<std::uint32_t>{0, 1, 1, 0}));
  EXPECT_EQ(table.boards, (std::vector<InstancePath>{first, second}));
  EXPECT_EQ(table.file, (std::vector<std::uint32_t>{0, 1, 1, 0}));
  EXPECT_EQ(table.files, (std::vector<std::string>{"", "PINS"}));
}

/// An execution that a fit has made void must not leave its places.
TEST(PlaceTable, ForgetsAnEarlierExecution) {
  PlaceTable table;
  table.put({1, {}, Drill(), {}, nullptr});
  table.begin(ProgramInfo());
  EXPECT_EQ(table.size(), 0);
  table.put({2, {}, Drill(), {}, nullptr});
  EXPECT_EQ(table.line, (std::vector<std::uint32_t>{2}));
}

}  // namespace
}  // namespace panelcal
