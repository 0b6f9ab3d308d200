// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/table_correction.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/calib/table/table_of.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::IsNearPosition;
using test::Reports;

/// 100 ppm in x, 50 urad out of square, 30 um of bow.
Vector2d error_mm(const Vector2d& c_mm) {
  const double part = c_mm.x() / 300;
  return {1e-4 * c_mm.x() + 5e-5 * c_mm.y(), 0.03 * part * part};
}

TableMap table() {
  return test::table_of({Vector2d(0, -100), Vector2d(300, 200), 10, 10}, error_mm);
}

Position<frame::Machine> at(double x_mm, double y_mm) {
  return position_mm<frame::Machine>(x_mm, y_mm);
}

TEST(TableCorrection, CommandsWhatLeadsToAPlace) {
  const TableCorrection correction(table());
  for (const auto& place : {at(10, 20), at(299, -99), at(150, 50)}) {
    const auto command = correction.command_for(place);
    ASSERT_TRUE(command);
    const Vector2d stands_mm = command->in_mm() + error_mm(command->in_mm());
    EXPECT_THAT(position_mm<frame::Machine>(stands_mm), IsNearPosition(place, um(1e-5)));
    ASSERT_TRUE(correction.place_of(*command));
    EXPECT_THAT(*correction.place_of(*command), IsNearPosition(place, um(1e-5)));
  }
}

TEST(TableCorrection, HasNoAnswerWhereNothingWasMeasured) {
  const TableCorrection correction(table(), {}, "table.cal.json");
  EXPECT_FALSE(correction.command_for(at(300.1, 0)));
  EXPECT_FALSE(correction.command_for(at(-0.1, 0)));
  EXPECT_FALSE(correction.place_of(at(0, 200.001)));
  EXPECT_TRUE(correction.place_of(at(0, 200)));
  EXPECT_FALSE(correction.command_for(at(std::nan(""), 0)));
  const Diagnostic refusal = correction.refusal(at(300.1, 0));
  EXPECT_EQ(refusal.code, Code::TravelExceeded);
  EXPECT_THAT(refusal.text(),
              Reports("table.cal.json: error[travel-exceeded]",
                      "(300.100, 0.000)",
                      "(0.000, -100.000)",
                      "(300.000, 200.000) mm"));
}

TEST(TableCorrection, HoldsTheErrorOfItsEdgeAsFarAsItIsTold) {
  const TableCorrection correction(table(), mm(20));
  const auto beyond = correction.command_for(at(310, 50));
  ASSERT_TRUE(beyond);
  const Vector2d edge_mm = error_mm(Vector2d(300, 50));
  EXPECT_LT((beyond->in_mm() + edge_mm - Vector2d(310, 50)).norm(), 1e-5);
  EXPECT_FALSE(correction.command_for(at(320.1, 50)));
  EXPECT_EQ(correction.nearest_command_for(at(310, 50)), *beyond);
  // However far; where nothing is made.
  EXPECT_LT(
      (correction.nearest_command_for(at(1000, 50)).in_mm() + edge_mm - Vector2d(1000, 50)).norm(),
      1e-5);
}

}  // namespace
}  // namespace panelcal
