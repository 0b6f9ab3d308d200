// SPDX-License-Identifier: Apache-2.0
#include "calib/faults/constellation.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/calib/faults/simulated_boards.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::is_wrong;
using test::Neighbours;
using test::simulated_board;
using test::SimulatedBoard;

constexpr double kPitch_mm = 2.19;

ConstellationCandidate pad(const Vector2d& place_mm, double score = 0.97) {
  return {place_mm, 9e-6 * Eigen::Matrix2d::Identity(), score, true};
}

/// A target that sees pads at these offsets from its expected place, in a view of 8 x 6 mm.
ConstellationTarget target_at(const Vector2d& expected_mm,
                              const std::vector<Vector2d>& offsets_mm) {
  ConstellationTarget target;
  target.expected_mm = expected_mm;
  const Vector2d half(4, 3);
  target.view_mm = {expected_mm - half,
                    expected_mm + Vector2d(4, -3),
                    expected_mm + half,
                    expected_mm + Vector2d(-4, 3)};
  for (const Vector2d& off : offsets_mm) target.candidates.push_back(pad(expected_mm + off));
  return target;
}

ConstellationOptions usual_options() {
  ConstellationOptions options;
  options.limits.rotation = rad(4e-3);
  options.limits.stretch_ppm = 400;
  options.limits.residual = um(40);
  return options;
}

/// The panel is shifted by 2.20 mm where the pitch is 2.19; the first two targets stand in rows
/// along x, the third alone.
std::vector<ConstellationTarget> shifted_board() {
  const Vector2d shift(2.20, 0.01);
  const Vector2d pitch(kPitch_mm, 0);
  return {target_at({0, 0}, {shift - pitch, shift, shift - 2 * pitch}),
          target_at({120, 0}, {shift - pitch, shift}),
          target_at({0, 90}, {shift})};
}

TEST(Constellation, TakesTheShiftThatAllTargetsShare) {
  const Constellation found = assign_jointly(shifted_board(), usual_options());
  ASSERT_TRUE(found.is_decided());
  const Combination& best = found.ranked.front();
  EXPECT_EQ(best.choice, (std::vector<std::optional<std::size_t>>{1, 1, 0}));
  EXPECT_NEAR(best.shift_mm.x(), 2.20, 1e-3);
  EXPECT_GT(best.probability, 0.999);
}

TEST(Constellation, HoldsEqualNeighbourhoods) {
  std::vector<ConstellationTarget> targets = shifted_board();
  targets[2].candidates.push_back(pad(targets[2].expected_mm + Vector2d(0.01, 0.01)));
  const Constellation found = assign_jointly(targets, usual_options());
  EXPECT_FALSE(found.is_decided());
  ASSERT_GE(found.ranked.size(), 2U);
  EXPECT_TRUE(found.ranked[0].is_complete());
  EXPECT_TRUE(found.ranked[1].is_complete());
  EXPECT_NEAR(
      std::abs(found.ranked[0].shift_mm.x() - found.ranked[1].shift_mm.x()), kPitch_mm, 0.01);
}

/// A covered pad may be the target: nothing refutes the shift by one pitch.
TEST(Constellation, HoldsWhereSomethingCoversThePlace) {
  std::vector<ConstellationTarget> targets = shifted_board();
  ConstellationCandidate covered = pad(targets[2].expected_mm + Vector2d(0.01, 0.01), 0.4);
  covered.counts = false;
  targets[2].candidates.push_back(covered);
  EXPECT_FALSE(assign_jointly(targets, usual_options()).is_decided());
}

TEST(Constellation, HoldsWhereThePlaceIsNotSeen) {
  std::vector<ConstellationTarget> targets = shifted_board();
  targets[2].view_mm.reset();
  const Constellation found = assign_jointly(targets, usual_options());
  EXPECT_FALSE(found.is_decided());
  EXPECT_EQ(found.ranked[1].presence[2], Presence::Unseen);
}

/// The camera looks at less than half of where the targets may be.
TEST(Constellation, HoldsWhereMostOfTheSearchedAreaIsNotSeen) {
  std::vector<ConstellationTarget> targets = shifted_board();
  for (ConstellationTarget& target : targets) target.radius_mm = 8;
  const Constellation found = assign_jointly(targets, usual_options());
  EXPECT_FALSE(found.is_decided());
  EXPECT_GT(found.outside, found.false_alarm);
}

/// One target has only a neighbour in its picture.
TEST(Constellation, SaysWhereAMissingTargetIs) {
  std::vector<ConstellationTarget> targets = shifted_board();
  targets[2] = target_at({0, 90}, {Vector2d(-1, 2)});
  targets[1] = target_at({120, 0}, {Vector2d(2.20, 0.01)});
  const Constellation found = assign_jointly(targets, usual_options());
  EXPECT_FALSE(found.is_decided());
  const Combination& best = found.ranked.front();
  EXPECT_EQ(best.presence[2], Presence::Blank);
  EXPECT_LT((best.predicted_mm[2] - Vector2d(2.20, 90.01)).norm(), 0.3);
}

/// Only where every picture prefers one combination.
TEST(Constellation, LetsScoresDecide) {
  std::vector<ConstellationTarget> targets = shifted_board();
  targets[2].candidates.push_back(pad(targets[2].expected_mm + Vector2d(0.01, 0.01)));
  const auto weaken = [&](std::size_t i, std::size_t k) { targets[i].candidates[k].score = 0.7; };
  weaken(0, 0);
  weaken(0, 2);
  weaken(1, 0);
  EXPECT_FALSE(assign_jointly(targets, usual_options()).is_decided());
  weaken(2, 1);
  EXPECT_TRUE(assign_jointly(targets, usual_options()).is_decided());
}

TEST(Constellation, DoesNotDependOnTheOrder) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    SimulatedBoard board = simulated_board(random, Neighbours::Different);
    const Constellation found = assign_jointly(board.targets, board.options);
    std::reverse(board.targets.begin(), board.targets.end());
    for (ConstellationTarget& t : board.targets)
      std::reverse(t.candidates.begin(), t.candidates.end());
    const Constellation reversed = assign_jointly(board.targets, board.options);
    ASSERT_EQ(found.is_decided(), reversed.is_decided()) << "seed " << seed;
    if (!found.is_decided()) continue;
    EXPECT_LT((found.ranked[0].shift_mm - reversed.ranked[0].shift_mm).norm(), 1e-6);
  }
}

/// 48 targets with one candidate each and a second one here and there: still no explosion.
TEST(Constellation, IsQuickForManyTargets) {
  std::vector<ConstellationTarget> targets;
  for (int i = 0; i < 48; ++i) {
    std::vector<Vector2d> offsets = {{0.1, 0.2}};
    if (i % 4 == 0) offsets.emplace_back(0.1 + kPitch_mm, 0.2);
    targets.push_back(target_at({20.0 * (i % 8), 25.0 * (i / 8)}, offsets));
  }
  const Constellation found = assign_jointly(targets, usual_options());
  EXPECT_TRUE(found.is_exhaustive);
  EXPECT_TRUE(found.is_decided());
}

/// The statement of the design: never a wrong assignment, and few boards held that can be told.
TEST(Constellation, ReleasesNoWrongAssignmentOfAThousandBoards) {
  constexpr std::uint64_t kBoards = 1000;
  for (const auto neighbours : {Neighbours::Alike, Neighbours::Different}) {
    int n_held = 0;
    for (std::uint64_t seed = 0; seed < kBoards; ++seed) {
      Random random(seed);
      const SimulatedBoard board = simulated_board(random, neighbours);
      const Constellation found = assign_jointly(board.targets, board.options);
      EXPECT_FALSE(is_wrong(board, found)) << "seed " << seed;
      n_held += !found.is_decided();
    }
    if (neighbours == Neighbours::Different) {
      EXPECT_LE(n_held, 0.1 * kBoards);
    }
  }
}

/// Views that often show less than the searched radius, pads that are often covered or lost.
TEST(Constellation, ReleasesNothingWrongWhereCamerasSeeLittle) {
  const test::BoardTrial bad{.min_view_mm = 3, .max_view_mm = 10, .covered = 0.05, .lost = 5e-4};
  for (const auto neighbours : {Neighbours::Alike, Neighbours::Different}) {
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
      Random random(seed);
      const SimulatedBoard board = simulated_board(random, neighbours, bad);
      EXPECT_FALSE(is_wrong(board, assign_jointly(board.targets, board.options)))
          << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace panelcal
