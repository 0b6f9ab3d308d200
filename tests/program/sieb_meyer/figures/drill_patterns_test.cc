// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/figures/drill_patterns.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::sieb_meyer {
namespace {

using Eigen::Vector2d;
using test::IsNearMatrix;
using testing::AllOf;
using testing::HasSubstr;
using Holes = tl::expected<HoleSequence, std::string>;

constexpr double kExact_mm = 1e-10;  // roundings of doubles of some 100 mm
constexpr Nibbling kSequential{.order = NibbleOrder::Sequential};

std::vector<Vector2d> all(const Holes& holes) {
  std::vector<Vector2d> out;
  if (!holes) {
    ADD_FAILURE() << holes.error();
    return out;
  }
  for (std::int64_t i = 0; i < holes->size(); ++i) out.push_back((*holes)[i]);
  return out;
}

std::string error_of(const Holes& holes) {
  return holes ? "no error" : holes.error();
}

void expect_all(const std::vector<Vector2d>& holes, const std::vector<Vector2d>& expected) {
  ASSERT_EQ(holes.size(), expected.size());
  for (std::size_t i = 0; i < holes.size(); ++i) {
    EXPECT_THAT(holes[i], IsNearMatrix(expected[i], kExact_mm)) << i;
  }
}

// --- V1 ------------------------------------------------------------------------------------------

TEST(DualRow, ManualExampleInTheStandardGrid) {
  const std::vector<Vector2d> holes = all(dual_row({30, 70}, {45.24, 62.38}, {}));
  ASSERT_EQ(holes.size(), 14U);
  for (int i = 0; i < 7; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_THAT(holes[k], IsNearMatrix(Vector2d(30 + 2.54 * i, 70), kExact_mm));
    EXPECT_THAT(holes[13 - k], IsNearMatrix(Vector2d(30 + 2.54 * i, 62.38), kExact_mm));
  }
}

TEST(DualRow, ManualExampleInTheFreeGrid) {
  const std::vector<Vector2d> holes = all(dual_row({70, 30}, {77.5, 45}, 7));
  ASSERT_EQ(holes.size(), 14U);
  for (int i = 0; i < 7; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_THAT(holes[k], IsNearMatrix(Vector2d(70, 30 + 2.5 * i), kExact_mm));
    EXPECT_THAT(holes[13 - k], IsNearMatrix(Vector2d(77.5, 30 + 2.5 * i), kExact_mm));
  }
}

TEST(DualRow, TheDiagonalChoosesTheDirection) {
  // The same two diagonals from all four corners, 4 by 2 pitches.
  const Vector2d low(0, 0), high(10.16, 5.08), left(0, 5.08), right(10.16, 0);
  for (const auto& [first, second] : {std::pair(low, high), std::pair(high, low)}) {
    EXPECT_EQ(all(dual_row(first, second, {})).size(), 6U);
  }
  for (const auto& [first, second] : {std::pair(left, right), std::pair(right, left)}) {
    EXPECT_EQ(all(dual_row(first, second, {})).size(), 10U);
  }
  // Rows half a pitch apart would be a tie.
  expect_all(all(dual_row(right, {0, 5.2}, 2)), {{10.16, 0}, {0, 0}, {0, 10.16}, {10.16, 10.16}});
}

TEST(DualRow, TheStandardGridCorrectsTheCorner) {
  // Up to half a pitch (1.27 mm) off in both directions, counted from the first point.
  for (const Vector2d& off : {Vector2d(1.26, 1.26), Vector2d(-1.26, 1.26), Vector2d(0.3, -1.26)}) {
    const std::vector<Vector2d> holes = all(dual_row({30, 70}, Vector2d(22.38, 75.08) + off, {}));
    ASSERT_EQ(holes.size(), 8U);
    EXPECT_THAT(holes[3], IsNearMatrix(Vector2d(22.38, 70), kExact_mm));
    EXPECT_THAT(holes[4], IsNearMatrix(Vector2d(22.38, 75.08), kExact_mm));
    EXPECT_THAT(holes[7], IsNearMatrix(Vector2d(30, 75.08), kExact_mm));
  }
}

TEST(DualRow, TheFreeGridCorrectsTheDistanceOnly) {
  // Five holes on 10 mm: pitch 2.5; rows programmed 4.1 mm apart become 5 mm apart.
  const std::vector<Vector2d> holes = all(dual_row({0, 0}, {10, -4.1}, 5));
  ASSERT_EQ(holes.size(), 10U);
  EXPECT_EQ(holes[4], Vector2d(10, 0));
  EXPECT_THAT(holes[5], IsNearMatrix(Vector2d(10, -5), kExact_mm));
  EXPECT_THAT(holes[9], IsNearMatrix(Vector2d(0, -5), kExact_mm));
}

/// "Programmed with an accuracy of +-1.27 mm": there either place of the grid may be meant.
TEST(DualRow, RefusesACornerHalfWayBetweenTwoPlacesOfTheGrid) {
  const std::string half_way = "half way";
  EXPECT_THAT(error_of(dual_row({0, 0}, {10.16, -3.81}, {})),
              AllOf(HasSubstr(half_way), HasSubstr("3.81 mm"), HasSubstr("2.54 mm")));
  EXPECT_THAT(error_of(dual_row({0, 0}, {3.81, -10.16}, {})), HasSubstr(half_way));
  EXPECT_THAT(error_of(dual_row({0, 0}, {10, -3.75}, 5)), HasSubstr(half_way));
  EXPECT_THAT(error_of(quadruple_row({0, 0}, {10, -3.75}, 5)), HasSubstr(half_way));
  EXPECT_EQ(all(dual_row({0, 0}, {10.16, -3.8}, {})).size(), 10U);
  EXPECT_EQ(all(dual_row({0, 0}, {10.16, -3.82}, {})).size(), 10U);
}

TEST(DualRow, RefusesWhatMakesNoRows) {
  EXPECT_THAT(error_of(dual_row({0, 0}, {10, 0}, {})), HasSubstr("10 by 0 mm"));
  EXPECT_THAT(error_of(dual_row({0, 0}, {0, 10}, 5)), HasSubstr("opposite"));
  EXPECT_THAT(error_of(dual_row({0, 0}, {10, -1.26}, {})),
              AllOf(HasSubstr("1.26 mm"), HasSubstr("2.54 mm")));
  EXPECT_THAT(error_of(dual_row({0, 0}, {1.26, -10}, {})), HasSubstr("half a pitch"));
  EXPECT_THAT(error_of(dual_row({0, 0}, {10, -1.2}, 5)), HasSubstr("2.5 mm"));
  EXPECT_THAT(error_of(dual_row({0, 0}, {10, -5}, 1)), HasSubstr("W is 1"));
  EXPECT_THAT(error_of(dual_row({0, 0}, {10, -5}, -3)), HasSubstr("W is -3"));
  EXPECT_THAT(error_of(dual_row({0, 0}, {NAN, 5}, 3)), HasSubstr("finite"));
  EXPECT_THAT(error_of(dual_row({-1e308, 0}, {1e308, 5}, 3)), HasSubstr("finite"));
  EXPECT_THAT(error_of(dual_row({0, 0}, {1e13, -5}, {})), HasSubstr("too many"));
  EXPECT_THAT(error_of(dual_row({0, 0}, {5, -5}, std::numeric_limits<std::int64_t>::max())),
              HasSubstr("too many"));
}

// --- V2 ------------------------------------------------------------------------------------------

TEST(SingleRow, ManualExample) {
  const std::vector<Vector2d> holes = all(single_row({10, 10}, {37.94, 10}, 12));
  ASSERT_EQ(holes.size(), 12U);
  for (int i = 0; i < 12; ++i) {
    EXPECT_THAT(holes[static_cast<std::size_t>(i)],
                IsNearMatrix(Vector2d(10 + 2.54 * i, 10), kExact_mm));
  }
}

TEST(SingleRow, AnyAngle) {
  expect_all(all(single_row({3, -1}, {-3, 7}, 3)), {{3, -1}, {0, 3}, {-3, 7}});
  expect_all(all(single_row({3, -1}, {-3, 7}, 2)), {{3, -1}, {-3, 7}});
  expect_all(all(single_row({3, -1}, {3, -1}, 1)), {{3, -1}});
}

TEST(SingleRow, RefusesOneHoleOfTwoAndTwoInOnePlace) {
  EXPECT_THAT(error_of(single_row({0, 0}, {1, 0}, 1)), HasSubstr("W is 1"));
  EXPECT_THAT(error_of(single_row({0, 0}, {1, 0}, 0)), HasSubstr("W is 0"));
  EXPECT_THAT(error_of(single_row({2, 3}, {2, 3}, 2)), HasSubstr("2 holes"));
  EXPECT_THAT(error_of(single_row({0, 0}, {INFINITY, 0}, 2)), HasSubstr("finite"));
  EXPECT_THAT(error_of(single_row({0, 0}, {1, 0}, 2'000'000'000'000)), HasSubstr("too many"));
}

// --- V3 ------------------------------------------------------------------------------------------

/// Holes lie on the rectangle's outline, a pitch apart all round, each once.
void expect_ring(const std::vector<Vector2d>& holes,
                 const Vector2d& first,
                 const Vector2d& diagonal,
                 double pitch) {
  const Vector2d low = first.cwiseMin(diagonal);
  const Vector2d high = first.cwiseMax(diagonal);
  ASSERT_EQ(holes.size(), static_cast<std::size_t>(std::llround(2 * (high - low).sum() / pitch)));
  EXPECT_EQ(holes[0], first);
  int n_diagonal = 0;
  for (std::size_t i = 0; i < holes.size(); ++i) {
    EXPECT_NEAR((holes[(i + 1) % holes.size()] - holes[i]).norm(), pitch, kExact_mm) << i;
    const double inside = std::min((holes[i] - low).minCoeff(), (high - holes[i]).minCoeff());
    EXPECT_NEAR(inside, 0, kExact_mm) << i;
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT((holes[i] - holes[j]).norm(), pitch / 2);
    if ((holes[i] - diagonal).norm() < kExact_mm) ++n_diagonal;
  }
  EXPECT_EQ(n_diagonal, 1);
}

TEST(QuadrupleRow, ManualExamplesInTheStandardGrid) {
  // 20 mm are 8 pitches (20.32), 10 mm are 4 (10.16), 30 mm are 12 (30.48).
  expect_ring(all(quadruple_row({30, 10}, {50, 30}, {})), {30, 10}, {50.32, 30.32}, 2.54);
  expect_ring(all(quadruple_row({70, 10}, {80, 40}, {})), {70, 10}, {80.16, 40.48}, 2.54);
}

TEST(QuadrupleRow, ManualExamplesInTheFreeGrid) {
  expect_ring(all(quadruple_row({30, 50}, {50, 70}, 9)), {30, 50}, {50, 70}, 2.5);
  // The manual prints W9 with a pitch of 2.5 mm; 40 mm have it with 17 holes, with 9 it is 5 mm.
  expect_ring(all(quadruple_row({70, 50}, {80, 90}, 17)), {70, 50}, {80, 90}, 2.5);
  expect_ring(all(quadruple_row({70, 50}, {80, 90}, 9)), {70, 50}, {80, 90}, 5);
}

TEST(QuadrupleRow, GoesAlongTheRowOfV1FirstAndRound) {
  expect_all(all(quadruple_row({0, 0}, {2, 4}, 3)),
             {{0, 0}, {0, 2}, {0, 4}, {2, 4}, {2, 2}, {2, 0}});
  expect_all(all(quadruple_row({4, 0}, {0, 2}, 3)),
             {{4, 0}, {2, 0}, {0, 0}, {0, 2}, {2, 2}, {4, 2}});
}

TEST(QuadrupleRow, RefusesWhatV1Refuses) {
  EXPECT_THAT(error_of(quadruple_row({0, 0}, {10, 0}, {})), HasSubstr("opposite"));
  EXPECT_THAT(error_of(quadruple_row({0, 0}, {10, 1}, {})), HasSubstr("half a pitch"));
  EXPECT_THAT(error_of(quadruple_row({0, 0}, {10, 10}, 1)), HasSubstr("W is 1"));
  EXPECT_THAT(error_of(quadruple_row({0, 0}, {2e12, 3}, {})), HasSubstr("too many"));
}

// --- V4 ------------------------------------------------------------------------------------------

TEST(CircularRow, ManualExamples) {
  const std::vector<Vector2d> twelve = all(circular_row({50, 50}, {80, 50}, 12));
  ASSERT_EQ(twelve.size(), 12U);
  EXPECT_EQ(twelve[0], Vector2d(80, 50));
  EXPECT_THAT(twelve[1], IsNearMatrix(Vector2d(50 + 15 * std::sqrt(3), 65), kExact_mm));
  EXPECT_THAT(twelve[2], IsNearMatrix(Vector2d(65, 50 + 15 * std::sqrt(3)), kExact_mm));
  EXPECT_EQ(twelve[3], Vector2d(50, 80));
  EXPECT_EQ(twelve[6], Vector2d(20, 50));

  const std::vector<Vector2d> sixty = all(circular_row({50, 50}, {82, 50}, 60));
  ASSERT_EQ(sixty.size(), 60U);
  for (std::size_t i = 0; i < 60; ++i) {
    EXPECT_NEAR((sixty[i] - Vector2d(50, 50)).norm(), 32, kExact_mm);
    EXPECT_NEAR(
        (sixty[(i + 1) % 60] - sixty[i]).norm(), 64 * std::sin(std::numbers::pi / 60), kExact_mm);
  }
}

TEST(CircularRow, BeginsAtAnyHole) {
  expect_all(all(circular_row({1, 1}, {1, -1}, 4)), {{1, -1}, {3, 1}, {1, 3}, {-1, 1}});
  expect_all(all(circular_row({1, 1}, {4, 5}, 1)), {{4, 5}});
}

TEST(CircularRow, RefusesNoCircle) {
  EXPECT_THAT(error_of(circular_row({1, 1}, {1, 1}, 4)), HasSubstr("centre"));
  EXPECT_THAT(error_of(circular_row({1, 1}, {2, 1}, 0)), HasSubstr("W is 0"));
  EXPECT_THAT(error_of(circular_row({1, 1}, {NAN, 1}, 3)), HasSubstr("finite"));
  EXPECT_THAT(error_of(circular_row({1, 1}, {2, 1}, 1'000'000'000'001)), HasSubstr("too many"));
}

// --- G84 -----------------------------------------------------------------------------------------

TEST(NibbledCircle, ManualExampleByHand) {
  // 10 mm with a tool of 2.4 mm: the centres' circle has a radius of 3.8 mm, and n holes leave
  // cusps of 5 - 3.8 cos(180/n) - sqrt(1.2^2 - (3.8 sin(180/n))^2): 0.019 mm for 64, 0.005 mm for
  // 128.
  const std::vector<Vector2d> holes = all(nibbled_circle({50, 50}, 5, 2.4));
  ASSERT_EQ(holes.size(), 128U);
  EXPECT_EQ(holes[0], Vector2d(53.8, 50));
  EXPECT_EQ(holes[1], Vector2d(46.2, 50));
  EXPECT_EQ(holes[2], Vector2d(50, 53.8));
  EXPECT_EQ(holes[3], Vector2d(50, 46.2));
  const double diagonal = 3.8 * std::numbers::sqrt2 / 2;
  EXPECT_THAT(holes[4], IsNearMatrix(Vector2d(50 + diagonal, 50 + diagonal), kExact_mm));
  EXPECT_THAT(holes[5], IsNearMatrix(Vector2d(50 - diagonal, 50 + diagonal), kExact_mm));
}

TEST(NibbledCircle, TheRoughnessChoosesTheNumber) {
  // As above: 0.019 mm for 64 holes.
  EXPECT_EQ(all(nibbled_circle({50, 50}, 5, 2.4, {.roughness_mm = 0.02})).size(), 64U);
  EXPECT_EQ(all(nibbled_circle({50, 50}, 5, 2.4, {.roughness_mm = 0.019})).size(), 128U);
}

TEST(NibbledCircle, SequentialByHand) {
  // 2 pi 3.8 / 0.381 = 62.7 steps: 63 holes.
  const std::vector<Vector2d> holes = all(nibbled_circle({0, 0}, 5, 2.4, kSequential));
  ASSERT_EQ(holes.size(), 63U);
  EXPECT_EQ(holes[0], Vector2d(3.8, 0));
  EXPECT_GT(holes[1].y(), 0);
  for (std::size_t i = 0; i < 63; ++i) {
    EXPECT_LE((holes[(i + 1) % 63] - holes[i]).norm(), 0.381);
    EXPECT_GT((holes[(i + 1) % 63] - holes[i]).norm(), 0.37);
  }
}

TEST(NibbledCircle, TheWallIsSmoothEnough) {
  Random random(84);
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(trial);
    const double radius = random.uniform(0.5, 20);
    const double tool = radius * random.uniform(0.02, 1);
    const double roughness = random.uniform(0.002, 0.05);
    std::vector<Vector2d> holes =
        all(nibbled_circle({0, 0}, radius, tool, {.roughness_mm = roughness}));
    std::ranges::sort(holes, {}, [](const Vector2d& p) { return std::atan2(p.y(), p.x()); });
    for (std::size_t i = 0; i < holes.size(); ++i) {
      const Vector2d& a = holes[i];
      const Vector2d& b = holes[(i + 1) % holes.size()];
      ASSERT_NEAR(a.norm() + tool / 2, radius, kExact_mm);
      const Vector2d middle = (a + b) / 2;
      const double reach = tool * tool / 4 - (b - a).squaredNorm() / 4;
      ASSERT_GE(reach, 0);  // neighbours meet
      ASSERT_LT(radius - middle.norm() - std::sqrt(reach), roughness);
    }
  }
}

TEST(NibbledCircle, RefusesWhatTheManualForbids) {
  EXPECT_EQ(error_of(nibbled_circle({0, 0}, 0.5, 0.5)), "no error");
  EXPECT_THAT(error_of(nibbled_circle({0, 0}, 0.499, 0.2)),
              AllOf(HasSubstr("0.499 mm"), HasSubstr("0.5 mm")));
  EXPECT_THAT(error_of(nibbled_circle({0, 0}, -5, 0.2)), HasSubstr("-5 mm"));
  EXPECT_THAT(error_of(nibbled_circle({0, 0}, 5, 5.001)),
              AllOf(HasSubstr("5.001 mm"), HasSubstr(" 5 mm")));
  EXPECT_THAT(error_of(nibbled_circle({0, 0}, 5, 0, kSequential)), HasSubstr("above 0"));
  EXPECT_THAT(error_of(nibbled_circle({0, 0}, 5, 1, {.roughness_mm = 0})), HasSubstr("roughness"));
  EXPECT_THAT(error_of(nibbled_circle({0, NAN}, 5, 1)), HasSubstr("finite"));
  EXPECT_THAT(error_of(nibbled_circle({0, 0}, 1e300, 1)), HasSubstr("too many"));
  EXPECT_THAT(error_of(nibbled_circle({0, 0}, 1e300, 1, kSequential)), HasSubstr("too many"));
}

// --- G85 -----------------------------------------------------------------------------------------

TEST(NibbledSlot, GlossaryHoleOrder) {
  // "hole order: 1 6 4 7 3 8 5 9 2": the numbers of the holes from one end to the other. A tool of
  // 1 mm leaves 13 um between holes 2 sqrt(0.013 (1 - 0.013)) = 0.2265 mm apart: 1.8 mm take 8
  // steps.
  const std::vector<int> order = {1, 6, 4, 7, 3, 8, 5, 9, 2};
  const std::vector<Vector2d> holes = all(nibbled_slot({0, 0}, {1.8, 0}, 1));
  ASSERT_EQ(holes.size(), 9U);
  for (std::size_t i = 0; i < 9; ++i) {
    const auto number = static_cast<std::size_t>(order[i]);
    EXPECT_THAT(holes[number - 1],
                IsNearMatrix(Vector2d(0.225 * static_cast<double>(i), 0), kExact_mm));
  }
}

TEST(NibbledSlot, ManualExampleByHand) {
  // 10 mm with a tool of 2.4 mm: holes may be 2 sqrt(0.013 (2.4 - 0.013)) = 0.3523 mm apart, that
  // is 28.4 steps; the next power of two is 32.
  const std::vector<Vector2d> holes = all(nibbled_slot({10, 10}, {20, 10}, 2.4));
  ASSERT_EQ(holes.size(), 33U);
  EXPECT_EQ(holes[0], Vector2d(10, 10));
  EXPECT_EQ(holes[1], Vector2d(20, 10));
  EXPECT_EQ(holes[2], Vector2d(15, 10));
  EXPECT_EQ(holes[3], Vector2d(12.5, 10));
  EXPECT_EQ(holes[4], Vector2d(17.5, 10));
  EXPECT_EQ(holes[32], Vector2d(10 + 10 * 31.0 / 32, 10));
}

TEST(NibbledSlot, SequentialByHand) {
  // 10 / 0.381 = 26.2: 27 steps, in order; 3.81 mm are 10 steps and not 11.
  const std::vector<Vector2d> holes = all(nibbled_slot({10, 10}, {20, 10}, 2.4, kSequential));
  ASSERT_EQ(holes.size(), 28U);
  for (std::size_t i = 0; i < 28; ++i) {
    EXPECT_THAT(holes[i],
                IsNearMatrix(Vector2d(10 + 10 * static_cast<double>(i) / 27, 10), kExact_mm));
  }
  EXPECT_EQ(all(nibbled_slot({0, 0}, {0, 0.381 * 10}, 2.4, kSequential)).size(), 11U);
  EXPECT_EQ(all(nibbled_slot({0, 0}, {0, 0.3}, 0, kSequential)).size(), 2U);
}

TEST(NibbledSlot, AShortSlotIsBothEnds) {
  // As in the order above: below 0.2265 mm nothing comes between them.
  expect_all(all(nibbled_slot({0, 0}, {0.226, 0}, 1)), {{0, 0}, {0.226, 0}});
  expect_all(all(nibbled_slot({0, 0}, {0.228, 0}, 1)), {{0, 0}, {0.228, 0}, {0.114, 0}});
}

TEST(NibbledSlot, NoLengthIsOneHole) {
  expect_all(all(nibbled_slot({4, 5}, {4, 5}, 1)), {{4, 5}});
  expect_all(all(nibbled_slot({4, 5}, {4, 5}, 1, kSequential)), {{4, 5}});
}

TEST(NibbledSlot, RefusesBadNumbers) {
  EXPECT_THAT(error_of(nibbled_slot({0, 0}, {1, 0}, 0)),
              AllOf(HasSubstr("diameter"), HasSubstr("0 mm")));
  EXPECT_THAT(error_of(nibbled_slot({0, 0}, {1, 0}, 1, {.roughness_mm = -1})),
              AllOf(HasSubstr("roughness"), HasSubstr("-1 mm")));
  EXPECT_THAT(error_of(nibbled_slot({0, 0}, {NAN, 0}, 1)), HasSubstr("finite"));
  EXPECT_THAT(error_of(nibbled_slot({0, 0}, {1, 0}, NAN)), HasSubstr("finite"));
  EXPECT_THAT(error_of(nibbled_slot({0, 0}, {1e13, 0}, 1)), HasSubstr("too many"));
  EXPECT_THAT(error_of(nibbled_slot({0, 0}, {1e13, 0}, 1, kSequential)), HasSubstr("too many"));
}

}  // namespace
}  // namespace panelcal::sieb_meyer
