// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/patterns/canned_cycles.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/base/units.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::excellon {
namespace {

using Eigen::Vector2d;
using test::IsNearMatrix;
using testing::AllOf;
using testing::HasSubstr;

constexpr double kExact_mm = 1e-10;  // roundings of doubles of some 100 mm
constexpr double kStep_mm = inch(1e-4).in_mm();
constexpr double kMaxCusp_mm = inch(0.0005).in_mm();

Vector2d inches(double x, double y) {
  return {inch(x).in_mm(), inch(y).in_mm()};
}

std::vector<Vector2d> all(const Cycle<HoleSequence>& holes) {
  std::vector<Vector2d> out;
  if (!holes) {
    ADD_FAILURE() << holes.error();
    return out;
  }
  for (std::int64_t i = 0; i < holes->size(); ++i) out.push_back((*holes)[i]);
  return out;
}

template <class T>
std::string error_of(const Cycle<T>& cycle) {
  return cycle ? "no error" : cycle.error();
}

// --- G82 -----------------------------------------------------------------------------------------

Cycle<HoleSequence> package(const Vector2d& a_inch,
                            const Vector2d& b_inch,
                            double pitch_inch,
                            double row_inch) {
  return dual_in_line(
      a_inch * 25.4, b_inch * 25.4, inch(pitch_inch).in_mm(), inch(row_inch).in_mm(), kStep_mm);
}

TEST(DualInLine, ManualSampleProgram) {
  // Lines 66 to 80.
  EXPECT_EQ(all(package({0.5, 3.3}, {1.2, 3.6}, 0.1, 0.3)).size(), 16U);
  EXPECT_EQ(all(package({2.0, 3.3}, {3.3, 3.6}, 0.1, 0.4)).size(), 28U);
  EXPECT_EQ(all(package({4.0, 3.3}, {5.4, 3.8}, 0.2, 0.5)).size(), 16U);
  EXPECT_EQ(all(package({4.0, 2.3}, {5.5, 2.9}, 0.1, 0.6)).size(), 32U);
  EXPECT_EQ(all(package({3.7, 4.2}, {4.0, 4.8}, 0.1, 0.3)).size(), 14U);
}

TEST(DualInLine, GoesAlongTheFirstRowAndBackAlongTheSecond) {
  const std::vector<Vector2d> rows = all(package({1.2, 3.6}, {0.5, 3.3}, 0.1, 0.3));
  ASSERT_EQ(rows.size(), 16U);
  EXPECT_EQ(rows[0], Vector2d(inches(1.2, 3.6)));
  EXPECT_THAT(rows[1], IsNearMatrix(inches(1.1, 3.6), kExact_mm));
  EXPECT_THAT(rows[7], IsNearMatrix(inches(0.5, 3.6), kExact_mm));
  EXPECT_EQ(rows[8], Vector2d(inches(0.5, 3.3)));
  EXPECT_THAT(rows[15], IsNearMatrix(inches(1.2, 3.3), kExact_mm));
}

TEST(DualInLine, TheRowSpacingChoosesTheDirection) {
  // 0.3 by 0.6: rows along y if they are 0.3 apart, along x if they are 0.6 apart.
  EXPECT_EQ(all(package({0, 0}, {0.3, 0.6}, 0.1, 0.3)).size(), 14U);
  EXPECT_EQ(all(package({0, 0}, {0.3, 0.6}, 0.1, 0.6)).size(), 8U);
  // None: along the longer side.
  EXPECT_EQ(all(package({0, 0}, {0.3, 0.6}, 0.1, 0.4)).size(), 14U);
  EXPECT_EQ(all(package({0, 0}, {0.6, 0.3}, 0.1, 0.4)).size(), 14U);
}

TEST(DualInLine, NumbersMayBeRounded) {
  // Pitches of 1.27 mm in a file of whole 0.01 mm, a corner off by one of these.
  EXPECT_EQ(all(dual_in_line({0, 0}, {8.9, 7.61}, 1.27, 7.62, 0.01)).size(), 16U);
  EXPECT_THAT(error_of(dual_in_line({0, 0}, {8.92, 7.61}, 1.27, 7.62, 0.01)),
              AllOf(HasSubstr("8.92 mm"), HasSubstr("1.27 mm")));
}

TEST(DualInLine, RefusesWhatIsNoPackage) {
  EXPECT_THAT(error_of(package({0, 0}, {0.3, 0.3}, 0.1, 0.3)), HasSubstr("7.62 by 7.62 mm"));
  EXPECT_THAT(error_of(package({0, 0}, {0.3, 0.3}, 0.1, 0.3)), HasSubstr("square"));
  EXPECT_THAT(error_of(package({0, 0}, {0.3, -0.30004}, 0.1, 0.3)), HasSubstr("square"));
  EXPECT_THAT(error_of(package({0, 0}, {0, 0.3}, 0.1, 0.3)), HasSubstr("opposite"));
  EXPECT_THAT(error_of(package({0, 0}, {0.7, 0}, 0.1, 0.3)), HasSubstr("opposite"));
  // Either side may be meant to lie between the rows.
  EXPECT_THAT(error_of(package({0, 0}, {0.6, 0.3}, 0.1, 0.5)), HasSubstr("either way"));
  EXPECT_THAT(error_of(package({0, 0}, {0.6, 0.3}, 0.1, 0.45)), HasSubstr("either way"));
  EXPECT_THAT(error_of(package({0, 0}, {0.75, 0.3}, 0.1, 0.3)), HasSubstr("whole number"));
  EXPECT_THAT(error_of(package({0, 0}, {0.04, 0.3}, 0.1, 0.3)), HasSubstr("whole number"));
  EXPECT_THAT(error_of(package({0, 0}, {0.7, 0.3}, 0, 0.3)), HasSubstr("above 0"));
  EXPECT_THAT(error_of(package({0, 0}, {0.7, 0.3}, 0.1, -0.3)), HasSubstr("above 0"));
  EXPECT_THAT(error_of(package({0, 0}, {NAN, 0.3}, 0.1, 0.3)), HasSubstr("finite"));
  EXPECT_THAT(error_of(package({0, 0}, {1e13, 0.3}, 0.1, 0.3)), HasSubstr("too many"));
}

TEST(DualInLine, HolesLieOnTwoRowsThroughBothCorners) {
  Random random(31);
  for (int trial = 0; trial < 500; ++trial) {
    SCOPED_TRACE(trial);
    const double pitch = random.uniform(0.5, 5);
    const int n_pitches = 1 + static_cast<int>(random.uniform(0, 30));
    const double row = random.uniform(2, 20);
    const bool along_x = trial % 2 == 0;
    const double length = n_pitches * pitch;
    if (std::abs(length - row) < 0.01) continue;  // a square
    const Vector2d a(random.uniform(-100, 100), random.uniform(-100, 100));
    Vector2d size = along_x ? Vector2d(length, row) : Vector2d(row, length);
    if (trial % 3 == 0) size.x() = -size.x();
    if (trial % 5 == 0) size.y() = -size.y();
    const std::vector<Vector2d> holes = all(dual_in_line(a, a + size, pitch, row, 1e-3));
    ASSERT_EQ(holes.size(), 2U * (static_cast<unsigned>(n_pitches) + 1));
    EXPECT_EQ(holes.front(), a);
    EXPECT_EQ(holes[holes.size() / 2], a + size);
    const int across = along_x ? 1 : 0;
    for (std::size_t i = 0; i < holes.size(); ++i) {
      const bool second = i >= holes.size() / 2;
      EXPECT_NEAR(holes[i][across], a[across] + (second ? size[across] : 0), kExact_mm);
      if (i > 0 && i != holes.size() / 2) {
        EXPECT_NEAR((holes[i] - holes[i - 1]).norm(), pitch, kExact_mm);
      }
    }
    EXPECT_NEAR((holes.back() - holes.front()).norm(), row, kExact_mm);
  }
}

// --- G83 -----------------------------------------------------------------------------------------

TEST(EightPin, ManualSampleProgram) {
  // Lines 43 to 45: 0.3, 4.1 and 0.7, 4.1: a circle of radius 0.2 about 0.5, 4.1.
  const std::vector<Vector2d> holes = all(eight_pin(inches(0.3, 4.1), inches(0.7, 4.1), kStep_mm));
  ASSERT_EQ(holes.size(), 8U);
  const double diagonal = 0.2 * std::numbers::sqrt2 / 2;
  const std::vector<Vector2d> expected = {{0.3, 4.1},
                                          {0.5 - diagonal, 4.1 - diagonal},
                                          {0.5, 3.9},
                                          {0.5 + diagonal, 4.1 - diagonal},
                                          {0.7, 4.1},
                                          {0.5 + diagonal, 4.1 + diagonal},
                                          {0.5, 4.3},
                                          {0.5 - diagonal, 4.1 + diagonal}};
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_THAT(holes[i], IsNearMatrix(Vector2d(25.4 * expected[i]), kExact_mm)) << i;
  }
}

TEST(EightPin, MayStandUpright) {
  const std::vector<Vector2d> holes = all(eight_pin({1, 5}, {1, -5}, 0.001));
  ASSERT_EQ(holes.size(), 8U);
  EXPECT_THAT(holes[0], IsNearMatrix(Vector2d(1, 5), kExact_mm));
  EXPECT_EQ(holes[2], Vector2d(-4, 0));
  EXPECT_THAT(holes[4], IsNearMatrix(Vector2d(1, -5), kExact_mm));
}

TEST(EightPin, RefusesOtherDirectionsAndOnePlace) {
  EXPECT_THAT(error_of(eight_pin({0, 0}, {10, 0.01}, 0.001)), HasSubstr("10 by 0.01 mm"));
  EXPECT_EQ(error_of(eight_pin({0, 0}, {10, 0.001}, 0.001)), "no error");
  EXPECT_THAT(error_of(eight_pin({3, 4}, {3, 4}, 0.001)), HasSubstr("opposite"));
  EXPECT_THAT(error_of(eight_pin({3, 4}, {3, INFINITY}, 0.001)), HasSubstr("finite"));
}

// --- G84 -----------------------------------------------------------------------------------------

/// Height to which the material left between two holes of a ring reaches into the big hole, by
/// bisection along the ray halfway between them.
double ring_cusp(double diameter, double tool, double n) {
  const double path = (diameter - tool) / 2;
  const double angle = std::numbers::pi / n;
  const Vector2d hole(path * std::cos(angle), path * std::sin(angle));
  double inside = hole.x();
  double outside = diameter / 2;
  for (int i = 0; i < 100; ++i) {
    const double middle = (inside + outside) / 2;
    ((Vector2d(middle, 0) - hole).norm() < tool / 2 ? inside : outside) = middle;
  }
  return diameter / 2 - outside;
}

TEST(CannedCircle, ManualSampleProgramByHand) {
  // Line 139: 0.5 inch with a tool of 0.125. Path radius 0.1875; the cusp between n holes is
  // 0.25 - 0.1875 cos(180/n) - sqrt(0.0625^2 - (0.1875 sin(180/n))^2):
  // 0.000501 for 86, 0.000490 for 87 holes.
  const std::vector<Vector2d> holes =
      all(canned_circle(inches(0.9, 4.6), inch(0.5).in_mm(), inch(0.125).in_mm()));
  ASSERT_EQ(holes.size(), 87U);
  EXPECT_THAT(holes[0], IsNearMatrix(inches(1.0875, 4.6), kExact_mm));
  EXPECT_GT(holes[1].y(), holes[0].y());
}

TEST(CannedCircle, JustEnoughHolesEvenlySpaced) {
  Random random(32);
  for (int trial = 0; trial < 300; ++trial) {
    SCOPED_TRACE(trial);
    const double tool = random.uniform(0.05, 6.5);
    const double diameter = tool * random.uniform(2, 20);
    const Vector2d center(random.uniform(-100, 100), random.uniform(-100, 100));
    const std::vector<Vector2d> holes = all(canned_circle(center, diameter, tool));
    const auto n = static_cast<double>(holes.size());
    EXPECT_LT(ring_cusp(diameter, tool, n), kMaxCusp_mm);
    EXPECT_GE(ring_cusp(diameter, tool, n - 1), kMaxCusp_mm);
    for (std::size_t i = 0; i < holes.size(); ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / n;
      const double radius = (diameter - tool) / 2;
      ASSERT_THAT(
          holes[i],
          IsNearMatrix(Vector2d(center + radius * Vector2d(std::cos(angle), std::sin(angle))),
                       kExact_mm));
    }
  }
}

TEST(CannedCircle, RefusesCirclesBelowTwoTools) {
  EXPECT_EQ(error_of(canned_circle({0, 0}, inch(0.25).in_mm(), 2 * inch(0.0625).in_mm())),
            "no error");
  EXPECT_THAT(error_of(canned_circle({0, 0}, 3.9, 2)),
              AllOf(HasSubstr("3.9 mm"), HasSubstr("2 mm")));
  EXPECT_THAT(error_of(canned_circle({0, 0}, 5, 0)), HasSubstr("above 0"));
  EXPECT_THAT(error_of(canned_circle({0, 0}, 5, -1)), HasSubstr("above 0"));
  EXPECT_THAT(error_of(canned_circle({0, NAN}, 5, 1)), HasSubstr("finite"));
  EXPECT_THAT(error_of(canned_circle({0, 0}, 1e300, 1)), HasSubstr("too many"));
}

TEST(CannedCircle, TheFinestToolsStillMeet) {
  const std::vector<Vector2d> holes = all(canned_circle({0, 0}, 0.025, 0.01));
  ASSERT_EQ(holes.size(), 5U);  // the cusps of 0.0127 mm could be higher than the holes are wide
  EXPECT_LE((holes[1] - holes[0]).norm(), 0.01);
}

// --- G85 -----------------------------------------------------------------------------------------

TEST(CannedSlot, ManualSampleProgramByHand) {
  // Line 50: 0.3 inch with a tool of 0.032: 9 steps of 0.0333. Holes may be
  // 2 sqrt(0.0005 (0.032 - 0.0005)) = 0.00794 apart: three halvings, to 0.00417.
  const std::vector<Vector2d> holes =
      all(canned_slot(inches(3, 5), inches(3, 4.7), inch(0.032).in_mm()));
  ASSERT_EQ(holes.size(), 73U);
  EXPECT_EQ(holes[0], Vector2d(inches(3, 5)));
  EXPECT_THAT(holes[1], IsNearMatrix(inches(3, 5 - 0.3 / 9), kExact_mm));
  EXPECT_EQ(holes[9], Vector2d(inches(3, 4.7)));
  EXPECT_THAT(holes[10], IsNearMatrix(inches(3, 5 - 0.3 / 18), kExact_mm));
  EXPECT_THAT(holes[18], IsNearMatrix(inches(3, 4.7 + 0.3 / 18), kExact_mm));
  EXPECT_THAT(holes[19], IsNearMatrix(inches(3, 5 - 0.3 / 36), kExact_mm));
  EXPECT_THAT(holes[20], IsNearMatrix(inches(3, 5 - 0.9 / 36), kExact_mm));
  EXPECT_THAT(holes[37], IsNearMatrix(inches(3, 5 - 0.3 / 72), kExact_mm));
  EXPECT_THAT(holes[72], IsNearMatrix(inches(3, 4.7 + 0.3 / 72), kExact_mm));
}

TEST(CannedSlot, StepsThatFitExactlyAreNotLost) {
  // 0.3 / 0.1 is a hair below 3: steps of the tool's diameter still fit three times.
  const std::vector<Vector2d> holes = all(canned_slot({0, 0}, {0.3, 0}, 0.1));
  EXPECT_THAT(holes[1], IsNearMatrix(Vector2d(0.1, 0), kExact_mm));
  EXPECT_EQ(holes[3], Vector2d(0.3, 0));
}

TEST(CannedSlot, ShortSlots) {
  EXPECT_EQ(all(canned_slot({1, 2}, {1, 2}, 0.5)), std::vector<Vector2d>({{1, 2}}));
  // Shorter than the tool: both ends, and what the cusps ask for.
  EXPECT_EQ(all(canned_slot({0, 0}, {0.01, 0}, 0.5)), std::vector<Vector2d>({{0, 0}, {0.01, 0}}));
  EXPECT_EQ(all(canned_slot({0, 0}, {0.4, 0}, 0.5)).size(), 5U);
}

TEST(CannedSlot, SmoothEnoughAndNotMore) {
  Random random(33);
  for (int trial = 0; trial < 300; ++trial) {
    SCOPED_TRACE(trial);
    const double tool = random.uniform(0.05, 6.5);
    const Vector2d start(random.uniform(-100, 100), random.uniform(-100, 100));
    const double angle = random.uniform(0, 6);
    const double length = random.uniform(0, 20 * tool);
    const Vector2d end = start + length * Vector2d(std::cos(angle), std::sin(angle));
    const std::vector<Vector2d> holes = all(canned_slot(start, end, tool));
    EXPECT_EQ(holes.front(), start);

    std::vector<double> along;
    for (const Vector2d& hole : holes) {
      along.push_back((hole - start).norm());
      ASSERT_NEAR((hole - start).norm() + (end - hole).norm(), length, kExact_mm);
    }
    std::ranges::sort(along);
    EXPECT_NEAR(along.back(), length, kExact_mm);
    const double spacing = length / static_cast<double>(holes.size() - 1);
    for (std::size_t i = 0; i < along.size(); ++i) {
      ASSERT_NEAR(along[i], static_cast<double>(i) * spacing, kExact_mm);
    }
    const auto cusp = [tool](double apart) {
      return tool / 2 - std::sqrt(std::max(tool * tool - apart * apart, 0.0)) / 2;
    };
    EXPECT_LT(cusp(spacing), kMaxCusp_mm);
    // The first pass ends at the slot's end; every other one has as many holes as all steps before.
    const auto n_steps = static_cast<std::size_t>(std::max(1.0, std::floor(length / tool)));
    EXPECT_EQ(holes[n_steps], end);
    std::size_t n = n_steps;
    while (n + 1 < holes.size()) {
      EXPECT_GE(cusp(length / static_cast<double>(n)), kMaxCusp_mm);
      n *= 2;
    }
    EXPECT_EQ(n + 1, holes.size());
  }
}

TEST(CannedSlot, SizesDoNotNeedMemory) {
  const Cycle<HoleSequence> slot = canned_slot({0, 0}, {1e8, 0}, 0.1);
  ASSERT_TRUE(slot.has_value()) << slot.error();
  EXPECT_EQ(slot->size(), 2'000'000'001);
  EXPECT_THAT((*slot)[slot->size() - 1], IsNearMatrix(Vector2d(1e8 - 0.05, 0), 1e-6));
  EXPECT_THAT(error_of(canned_slot({0, 0}, {1e13, 0}, 0.1)), HasSubstr("too many"));
  EXPECT_THAT(error_of(canned_slot({0, 0}, {9e10, 0}, 0.1)), HasSubstr("too many"));
  EXPECT_THAT(error_of(canned_slot({0, 0}, {1e150, 0}, 1e-150)), HasSubstr("too many"));
  EXPECT_THAT(error_of(canned_slot({0, 0}, {INFINITY, 0}, 0.1)), HasSubstr("finite"));
  EXPECT_THAT(error_of(canned_slot({0, 0}, {1, 0}, 0)),
              AllOf(HasSubstr("diameter"), HasSubstr("0 mm")));
  EXPECT_THAT(error_of(canned_slot({0, 0}, {1, 0}, NAN)), HasSubstr("finite"));
}

// --- G87 -----------------------------------------------------------------------------------------

std::vector<double> depths(double initial, double increment) {
  const Cycle<StepDepths> steps = step_slot_depths(initial, increment);
  std::vector<double> out;
  for (std::int64_t i = 0; steps && i < steps->size(); ++i) out.push_back((*steps)[i]);
  return out;
}

TEST(StepSlotDepths, ManualThreePasses) {
  // Z-.1U.2 over a final depth of -0.05: 0.15, 0.05 and -0.05 inch.
  const std::vector<double> passes = depths(0.2, -0.1);
  ASSERT_EQ(passes.size(), 3U);
  EXPECT_DOUBLE_EQ(passes[0], 0.2);
  EXPECT_DOUBLE_EQ(passes[1], 0.1);
  EXPECT_EQ(passes[2], 0);
}

TEST(StepSlotDepths, TheLastStepIsReduced) {
  const std::vector<double> passes = depths(0.25, -0.1);
  ASSERT_EQ(passes.size(), 4U);
  EXPECT_NEAR(passes[2], 0.05, 1e-15);
  EXPECT_EQ(passes[3], 0);
  EXPECT_EQ(depths(0.05, -0.1), std::vector<double>({0.05, 0}));
  EXPECT_EQ(depths(0, -0.1), std::vector<double>({0}));
}

TEST(StepSlotDepths, ConvertedInchesMakeNoPassOfNothing) {
  for (int n = 1; n <= 1000; ++n) {
    const double step_mm = inch(0.0127).in_mm();
    EXPECT_EQ(depths(inch(0.0127 * n).in_mm(), -step_mm).size(), static_cast<std::size_t>(n + 1));
  }
}

TEST(StepSlotDepths, RefusesTheWrongSigns) {
  EXPECT_THAT(error_of(step_slot_depths(-0.1, -0.1)), HasSubstr("-0.1 mm"));
  EXPECT_THAT(error_of(step_slot_depths(0.1, 0.1)), HasSubstr("0.1 mm"));
  EXPECT_THAT(error_of(step_slot_depths(0.1, 0)), HasSubstr("below 0"));
  EXPECT_THAT(error_of(step_slot_depths(NAN, -1)), HasSubstr("finite"));
  EXPECT_THAT(error_of(step_slot_depths(1, -1e-13)), HasSubstr("too many"));
}

// --- G32, G33 ------------------------------------------------------------------------------------

TEST(RoutedCircle, ManualExampleByHand) {
  // X04Y04A005: about 4, 4 with 0.5 inch; with a compensation of 0.125 the path radius is 0.4375.
  const Cycle<RoutedCircle> circle =
      routed_circle(inches(4, 4), inch(0.5).in_mm(), inch(0.125).in_mm());
  ASSERT_TRUE(circle.has_value()) << circle.error();
  EXPECT_NEAR(circle->radius_mm, inch(0.4375).in_mm(), kExact_mm);
  EXPECT_THAT(circle->plunge_mm, IsNearMatrix(inches(4, 3.5725), kExact_mm));
  EXPECT_THAT(circle->near_mm, IsNearMatrix(inches(4, 3.5625), kExact_mm));
  EXPECT_THAT(circle->far_mm, IsNearMatrix(inches(4, 4.4375), kExact_mm));
  EXPECT_THAT(circle->retract_mm, IsNearMatrix(inches(4, 4.3375), kExact_mm));
}

TEST(RoutedCircle, RetractsNoFurtherThanTheCentre) {
  const Cycle<RoutedCircle> circle = routed_circle({10, 20}, 2.5, 2);
  ASSERT_TRUE(circle.has_value());
  EXPECT_DOUBLE_EQ(circle->radius_mm, 1.5);
  EXPECT_EQ(circle->retract_mm, Vector2d(10, 20));
}

TEST(RoutedCircle, TheSmallestOneIsHalfTheCompensationPlusTenMil) {
  const Cycle<RoutedCircle> least =
      routed_circle({0, 0}, inch(0.0725).in_mm(), inch(0.125).in_mm());
  ASSERT_TRUE(least.has_value()) << least.error();
  EXPECT_THAT(least->plunge_mm, IsNearMatrix(Vector2d(0, 0), kExact_mm));
  EXPECT_THAT(error_of(routed_circle({0, 0}, inch(0.0724).in_mm(), inch(0.125).in_mm())),
              AllOf(HasSubstr("1.83896 mm"), HasSubstr("1.8415 mm")));
  EXPECT_THAT(error_of(routed_circle({0, 0}, 1, -0.1)), HasSubstr("compensation"));
  EXPECT_THAT(error_of(routed_circle({0, 0}, INFINITY, 0)), HasSubstr("finite"));
}

TEST(RoutedCircle, TheFirstArcStaysInside) {
  // The arc of radius_mm from the plunge to the far edge, to the left (clockwise); the other sense
  // is its mirror image.
  for (const double radius : {0.254, 0.3, 1.0, 10.0, 300.0}) {
    const Cycle<RoutedCircle> circle = routed_circle({0, 0}, radius, 0);
    ASSERT_TRUE(circle.has_value());
    const double half_chord = (circle->far_mm - circle->plunge_mm).norm() / 2;
    const Vector2d center(std::sqrt(radius * radius - half_chord * half_chord),
                          circle->far_mm.y() - half_chord);
    const double from = std::atan2(circle->plunge_mm.y() - center.y(), -center.x());
    const double to = std::atan2(circle->far_mm.y() - center.y(), -center.x());
    const double turn = std::remainder(to - from, 2 * std::numbers::pi);
    for (int i = 0; i <= 1000; ++i) {
      const double angle = from + turn * i / 1000;
      EXPECT_LE((center + radius * Vector2d(std::cos(angle), std::sin(angle))).norm(),
                radius + kExact_mm);
    }
  }
}

}  // namespace
}  // namespace panelcal::excellon
