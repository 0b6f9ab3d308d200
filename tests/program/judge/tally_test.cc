// SPDX-License-Identifier: Apache-2.0
#include "program/judge/tally.h"

#include <limits>
#include <numbers>

#include "tests/program/operations.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using namespace test;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

/// Sums of a few lengths; far below a nanometre.
constexpr double kTolerance_mm = 1e-9;

Tally tally_of(const std::vector<What>& operations) {
  Tally tally;
  tally.begin(metric_info());
  put_all(tally, operations);
  return tally;
}

Eigen::Vector2d low_mm(const Tally& tally) {
  return tally.corrected_box().low().in_mm();
}
Eigen::Vector2d high_mm(const Tally& tally) {
  return tally.corrected_box().high().in_mm();
}

TEST(Tally, IsEmptyAtFirst) {
  const Tally tally = tally_of({});
  EXPECT_TRUE(tally.nominal_box().is_empty());
  EXPECT_TRUE(tally.corrected_box().is_empty());
  EXPECT_EQ(tally.n_holes() + tally.n_slots() + tally.n_routs(), 0);
  EXPECT_THAT(tally.tools_used(), IsEmpty());
  EXPECT_EQ(tally.tools().size(), 2U);
}

TEST(Tally, KeepsPlacesThatAreNotANumberOutOfItsBoxes) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const Tally tally = tally_of({drill(1, kNaN, 4), drill(1, 2, 3), drill(1, kNaN, kNaN)});
  EXPECT_EQ(low_mm(tally), Eigen::Vector2d(2, 3));
  EXPECT_EQ(high_mm(tally), Eigen::Vector2d(2, 4));
  EXPECT_EQ(tally.nominal_box().low().in_mm(), Eigen::Vector2d(1.75, 2.5));
}

TEST(Tally, CountsByTool) {
  const Tally tally = tally_of({ToolChange{{.number = 7, .diameter = mm(3)}, {}},
                                drill(7, 0, 0),
                                drill(1, 1, 1),
                                drill(1, 2, 2),
                                drill(7, 3, 3),
                                Slot{1, place(0, 0), place(1, 0)},
                                StepSlot{2, place(0, 0), place(1, 0), mm(1), mm(-1)},
                                rapid_move(0, 0),
                                Plunge{5},
                                rout_line(5, 1, 0),
                                rout_line(5, 1, 1),
                                Retract{}});
  EXPECT_THAT(tally.holes_by_tool(), ElementsAre(Pair(1, 2), Pair(7, 2)));
  EXPECT_THAT(tally.slots_by_tool(), ElementsAre(Pair(1, 1), Pair(2, 1)));
  EXPECT_THAT(tally.routs_by_tool(), ElementsAre(Pair(5, 2)));
  EXPECT_EQ(tally.n_holes(), 4);
  EXPECT_EQ(tally.n_slots(), 2);
  EXPECT_EQ(tally.n_routs(), 2);
  EXPECT_THAT(tally.tools_used(), ElementsAre(1, 2, 5, 7));
  EXPECT_EQ(tally.tools().at(7).diameter, mm(3));
}

TEST(Tally, ACopyCountsForItself) {
  const Tally original = tally_of({drill(1, 0, 0)});
  Tally copy = original;
  copy.put({1, {}, drill(1, 0, 0), {}, nullptr});
  Tally assigned = tally_of({drill(1, 0, 0), drill(1, 0, 0)});
  assigned = original;
  assigned.put({1, {}, drill(1, 0, 0), {}, nullptr});
  EXPECT_THAT(original.holes_by_tool(), ElementsAre(Pair(1, 1)));
  EXPECT_THAT(copy.holes_by_tool(), ElementsAre(Pair(1, 2)));
  EXPECT_THAT(assigned.holes_by_tool(), ElementsAre(Pair(1, 2)));
}

TEST(Tally, BoundsHolesAndSlots) {
  const Tally tally = tally_of({drill(1, -3, 4), Slot{1, place(5, 7), place(9, 1)}});
  EXPECT_EQ(low_mm(tally), Eigen::Vector2d(-3, 1));
  EXPECT_EQ(high_mm(tally), Eigen::Vector2d(9, 7));
  EXPECT_EQ(tally.nominal_box().low().in_mm(), Eigen::Vector2d(-3.25, 0.5));
  EXPECT_EQ(tally.nominal_box().high().in_mm(), Eigen::Vector2d(8.75, 6.5));
  EXPECT_NEAR(tally.max_shift().in_mm(), std::hypot(0.25, 0.5), kTolerance_mm);
  EXPECT_NEAR(tally.max_sigma().in_mm(), 0.003, kTolerance_mm);
}

TEST(Tally, BoundsRoutsButNoWaysToThem) {
  const Tally tally = tally_of({rapid_move(-50, -50),
                                rapid_move(1, 2),
                                Plunge{2},
                                rout_line(2, 3, 5),
                                Retract{},
                                rapid_move(99, 99)});
  EXPECT_EQ(low_mm(tally), Eigen::Vector2d(1, 2));
  EXPECT_EQ(high_mm(tally), Eigen::Vector2d(3, 5));
}

TEST(Tally, ArcsBulgeOut) {
  // The upper half of a circle, either way round.
  for (const bool turned : {false, true}) {
    const double x_mm = turned ? -1 : 1;
    const Tally tally = tally_of(
        {rapid_move(x_mm, 0),
         Plunge{2},
         rout_arc(turned ? RoutKind::Clockwise : RoutKind::Counterclockwise, 2, -x_mm, 0, 0, 0)});
    EXPECT_THAT(low_mm(tally), IsNearMatrix(Eigen::Vector2d(-1, 0), kTolerance_mm));
    EXPECT_THAT(high_mm(tally), IsNearMatrix(Eigen::Vector2d(1, 1), kTolerance_mm));
    EXPECT_NEAR(tally.routed_length().in_mm(), std::numbers::pi, kTolerance_mm);
  }
}

TEST(Tally, ShortArcsBulgeOnlyWhereTheyPass) {
  const double k = std::numbers::sqrt2 / 2;
  const Tally across =
      tally_of({rapid_move(k, -k), Plunge{2}, rout_arc(RoutKind::Counterclockwise, 2, k, k, 0, 0)});
  EXPECT_THAT(low_mm(across), IsNearMatrix(Eigen::Vector2d(k, -k), kTolerance_mm));
  EXPECT_THAT(high_mm(across), IsNearMatrix(Eigen::Vector2d(1, k), kTolerance_mm));
  const Tally within =
      tally_of({rapid_move(1, 0), Plunge{2}, rout_arc(RoutKind::Counterclockwise, 2, k, k, 0, 0)});
  EXPECT_THAT(high_mm(within), IsNearMatrix(Eigen::Vector2d(1, k), kTolerance_mm));
  EXPECT_NEAR(within.routed_length().in_mm(), std::numbers::pi / 4, kTolerance_mm);
  const Tally nowhere =
      tally_of({rapid_move(1, 0), Plunge{2}, rout_arc(RoutKind::Counterclockwise, 2, 1, 0, 0, 0)});
  EXPECT_THAT(low_mm(nowhere), IsNearMatrix(Eigen::Vector2d(1, 0), kTolerance_mm));
  EXPECT_NEAR(nowhere.routed_length().in_mm(), 0, kTolerance_mm);
}

TEST(Tally, AddsRoutedLengths) {
  const Tally tally = tally_of({rapid_move(0, 0),
                                Plunge{2},
                                rout_line(2, 3, 4),
                                rout_line(2, 3, 10),
                                Retract{},
                                rapid_move(100, 100),
                                Plunge{2},
                                rout_line(2, 100, 101)});
  EXPECT_NEAR(tally.routed_length().in_mm(), 12, kTolerance_mm);
}

TEST(Tally, KeepsASampleOfTheHoles) {
  Tally tally;
  tally.begin(metric_info());
  constexpr int kHoles = 3 * static_cast<int>(Tally::kSample);
  for (int i = 0; i < kHoles; ++i) tally.put({1, {}, drill(1, i, 0), {}, nullptr});
  EXPECT_EQ(tally.n_holes(), kHoles);
  ASSERT_EQ(tally.sample().size(), kHoles / 4);
  for (std::size_t i = 0; i < tally.sample().size(); ++i) {
    ASSERT_EQ(tally.sample()[i].corrected.in_mm().x(), 4.0 * static_cast<double>(i));
  }
}

}  // namespace
}  // namespace panelcal
