// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/change_point.h"

#include <cmath>

#include <gmock/gmock.h>

#include "tests/calib/drift/simulated_nights.h"

namespace panelcal {
namespace {

using test::SimulatedMachine;
using test::SimulatedNights;

constexpr SimulatedMachine kCalm = {.drift = 0.0002};

template <class Fault>
DriftSeries nights_with(const Fault& fault, std::uint64_t seed, int n_nights = 60) {
  SimulatedNights nights(kCalm, Random(seed));
  DriftSeries series = {{"x", "y"}, "mm", {}};
  for (int night = 0; night < n_nights; ++night) {
    series.points.push_back(nights.next(fault(night)));
  }
  return series;
}

TEST(ChangePoint, NamesTheNightOfAStepAndItsSize) {
  const DriftSeries series =
      nights_with([](int night) { return Eigen::Vector2d(night >= 45 ? 0.012 : 0, 0); }, 1);
  const ChangeFound found = *find_change(series, {});
  EXPECT_EQ(found.kind, ChangeKind::Step);
  EXPECT_GT(found.probability, 0.99);
  EXPECT_EQ(found.i_night, 45U);
  EXPECT_GT(found.night_probability, 0.9);
  EXPECT_NEAR(found.size(0), 0.012, 4 * found.size_sigma(0));
  EXPECT_LT(found.size_sigma(0), 0.001);
  EXPECT_THAT(found.axes, testing::ElementsAre(0U));
  EXPECT_THAT(words_of(found, series),
              testing::AllOf(testing::HasSubstr("x moved by +1"),
                             testing::HasSubstr("between the nights of 2026-11-05 and 2026-11-06"),
                             testing::Not(testing::HasSubstr("y moved"))));
}

TEST(ChangePoint, TellsASlopeFromAStep) {
  const DriftSeries series = nights_with(
      [](int night) { return Eigen::Vector2d(0, night > 40 ? -0.0012 * (night - 40) : 0); }, 2);
  const ChangeFound found = *find_change(series, {});
  EXPECT_EQ(found.kind, ChangeKind::Slope);
  EXPECT_GT(found.probability, 0.9);
  EXPECT_NEAR(static_cast<double>(found.i_night), 41, 4);
  EXPECT_LE(found.i_first, 41U);
  EXPECT_GE(found.i_last, 41U);
  EXPECT_NEAR(found.size(1), -0.0012, 4 * found.size_sigma(1));
  EXPECT_THAT(found.axes, testing::ElementsAre(1U));
  EXPECT_THAT(words_of(found, series), testing::HasSubstr("y drifts by -1."));
}

TEST(ChangePoint, SeesNothingInHealthyNights) {
  constexpr int kRuns = 40;
  int n_found = 0;
  for (std::uint64_t seed = 100; seed < 100 + kRuns; ++seed) {
    const DriftSeries series = nights_with([](int) { return Eigen::Vector2d(0, 0); }, seed);
    n_found += find_change(series, {})->kind != ChangeKind::None;
  }
  // Of series where a change is more likely than not, kChangeBefore or fewer are healthy ones.
  EXPECT_LE(n_found, 4);
}

TEST(ChangePoint, NamesTheRightNightAsOftenAsItSays) {
  constexpr int kRuns = 60;
  constexpr std::size_t kNight = 40;
  int n_inside = 0;
  int n_steps = 0;
  for (std::uint64_t seed = 200; seed < 200 + kRuns; ++seed) {
    const DriftSeries series = nights_with(
        [](int night) { return Eigen::Vector2d(night >= 40 ? 0.004 : 0, 0); }, seed, 55);
    const ChangeFound found = *find_change(series, {});
    if (found.kind != ChangeKind::Step) continue;
    ++n_steps;
    n_inside += found.i_first <= kNight && kNight <= found.i_last;
  }
  EXPECT_GE(n_steps, kRuns / 2);
  // 90 % or more, less four standard deviations of so few runs.
  EXPECT_GE(n_inside, n_steps * (0.9 - 4 * 0.3 / std::sqrt(n_steps)));
}

TEST(ChangePoint, SaysThatThereIsNotEnoughHistory) {
  const DriftSeries series = nights_with([](int) { return Eigen::Vector2d(0, 0); }, 3, 10);
  const auto found = find_change(series, {});
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().what, testing::HasSubstr("10 nights"));
  EXPECT_FALSE(find_change({{"x", "y"}, "mm", {}}, {}));
}

}  // namespace
}  // namespace panelcal
