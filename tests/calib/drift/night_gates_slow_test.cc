// SPDX-License-Identifier: Apache-2.0
// 120 simulated nights with bad ones, a slow drift and a moved camera: what is installed is good.
#include <algorithm>
#include <cmath>
#include <iostream>

#include "calib/drift/night_gates.h"
#include <gtest/gtest.h>

#include "tests/calib/drift/simulated_nights.h"

namespace panelcal {
namespace {

constexpr int kNights = 120;
constexpr int kNightMoved = 70;
constexpr int kFirstFaults = 20;  // later than the history that is needed

enum class Fault { None, Wrong, Dirty, Moved };

/// Counts over all runs.
struct Tally {
  int n_healthy = 0;
  int n_healthy_refused = 0;
  int n_wrong = 0;
  int n_wrong_installed = 0;
  int n_dirty = 0;
  int n_dirty_installed = 0;
  int n_moves_held = 0;
  double worst_installed_mm = 0;
};

Fault fault_of(int night, Random& random) {
  if (night == kNightMoved) return Fault::Moved;
  const double dice = random.uniform();
  if (night < kFirstFaults || dice > 0.06) return Fault::None;
  return dice < 0.03 ? Fault::Wrong : Fault::Dirty;
}

void spoil(NightResult& tonight, Fault fault) {
  if (fault == Fault::Wrong) tonight.point.value += Eigen::Vector2d(-0.012, 0.009);
  if (fault == Fault::Dirty) {
    tonight.point.cov *= 25;
    tonight.n_outliers = 4;
  }
}

void count(Tally& tally, Fault fault, NightVerdict verdict) {
  const bool is_installed = verdict == NightVerdict::Install;
  tally.n_healthy += fault == Fault::None;
  tally.n_healthy_refused += fault == Fault::None && !is_installed;
  tally.n_wrong += fault == Fault::Wrong;
  tally.n_wrong_installed += fault == Fault::Wrong && is_installed;
  tally.n_dirty += fault == Fault::Dirty;
  tally.n_dirty_installed += fault == Fault::Dirty && is_installed;
  tally.n_moves_held += fault == Fault::Moved && verdict == NightVerdict::Hold;
}

void run(std::uint64_t seed, Tally& tally) {
  test::SimulatedNights nights({.drift = 0.0003, .temperature_sigma = 1}, Random(seed).fork(0));
  Random random = Random(seed).fork(1);
  DriftSeries history = {{"x", "y"}, "mm", {}};
  std::optional<Eigen::VectorXd> in_force;
  Eigen::Vector2d moved = Eigen::Vector2d::Zero();
  for (int night = 0; night < kNights; ++night) {
    const Fault fault = fault_of(night, random);
    if (fault == Fault::Moved) moved += Eigen::Vector2d(0.040, 0.010);
    if (night > kNightMoved) moved.y() += 0.0002;  // and from then on it creeps
    NightResult tonight = {nights.next(moved), "holes", 9, 0, 0.5, {}};
    // A person looks after the camera was moved.
    tonight.point.is_fresh_start = night == kNightMoved + 1;
    spoil(tonight, fault);
    const auto decision = decide_night(tonight, in_force, history, {}, {});
    ASSERT_TRUE(decision) << decision.error().text();
    count(tally, fault, decision->verdict);
    if (decision->verdict == NightVerdict::Install) {
      in_force = tonight.point.value;
      tally.worst_installed_mm =
          std::max(tally.worst_installed_mm, (*in_force - nights.truth()).norm());
    } else {
      tonight.point.is_left_out = true;
    }
    history.points.push_back(tonight.point);
  }
}

TEST(NightGatesSlow, InstallNothingBadIn120Nights) {
  constexpr int kRuns = 12;
  Tally tally;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) run(seed, tally);
  std::cout << tally.n_healthy_refused << " of " << tally.n_healthy << " healthy nights refused, "
            << tally.n_wrong_installed << " of " << tally.n_wrong << " wrong ones and "
            << tally.n_dirty_installed << " of " << tally.n_dirty << " dirty ones installed, "
            << tally.n_moves_held << " of " << kRuns << " moves held; worst installed error "
            << tally.worst_installed_mm * 1e3 << " um\n";
  EXPECT_EQ(tally.n_wrong_installed, 0);
  EXPECT_EQ(tally.n_dirty_installed, 0);
  EXPECT_EQ(tally.n_moves_held, kRuns);
  // One in NightLimits::nights_per_refusal; the night after the move is looked at by a person.
  const double expected = tally.n_healthy / NightLimits{}.nights_per_refusal;
  EXPECT_LE(tally.n_healthy_refused, expected + 4 * std::sqrt(expected));
  // A night's own error is 1.2 um an axis.
  EXPECT_LE(tally.worst_installed_mm, 0.0012 * 5);
}

}  // namespace
}  // namespace panelcal
