// SPDX-License-Identifier: Apache-2.0
#include "surface/map/way_cuts.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

using Profile = std::function<double(double)>;

auto sampled(const Profile& height_mm) {
  return [height_mm](std::size_t n) -> Expected<std::vector<double>> {
    std::vector<double> heights;
    for (std::size_t i = 0; i <= n; ++i) {
      heights.push_back(height_mm(static_cast<double>(i) / static_cast<double>(n)));
    }
    return heights;
  };
}

std::vector<double> cuts(const Profile& height_mm, Length tolerance, std::size_t least = 4) {
  const auto found = way_cuts(sampled(height_mm), least, tolerance);
  EXPECT_TRUE(found);
  return found.value_or(std::vector<double>());
}

TEST(FewestCuts, AreNoneOnAStraightProfile) {
  EXPECT_TRUE(fewest_cuts(std::vector<double>{1, 2, 3, 4, 5}, um(0)).empty());
  EXPECT_TRUE(fewest_cuts(std::vector<double>{1, 2}, um(0)).empty());
  EXPECT_TRUE(fewest_cuts({}, um(0)).empty());
}

TEST(FewestCuts, LieAtTheCornersOfAPolyline) {
  EXPECT_EQ(fewest_cuts(std::vector<double>{0, 1, 2, 1, 0, 0, 0}, um(1)),
            (std::vector<std::size_t>{2, 4}));
  // A spike of 2 um in a profile of millimetres is within 3 um of its neighbours' chord.
  EXPECT_TRUE(fewest_cuts(std::vector<double>{0, 0, 0.002, 0, 0}, um(3)).empty());
}

TEST(WayCuts, CutAParabolaAsOftenAsItMust) {
  // 1 mm t^2 in n pieces is 1 / (4 n^2) mm off: within 1 um from n = 15.8 on. Some of the tolerance
  // goes to what lies between samples, and cuts go to whole samples.
  const auto found = cuts([](double t) { return t * t; }, um(1));
  EXPECT_GE(found.size() + 1, 16U);
  EXPECT_LE(found.size() + 1, 17U);
}

TEST(WayCuts, SeeWhatLiesBetweenTheFirstSamples) {
  const auto wave = [](double t) { return 0.01 * std::sin(40 * t); };
  const auto found = cuts(wave, um(2), 8);
  std::vector<double> ends = found;
  ends.push_back(1);
  double begin = 0, worst_mm = 0;
  for (const double end : ends) {
    for (int i = 0; i <= 50; ++i) {
      const double share = i / 50.0;
      const double chord_mm = (1 - share) * wave(begin) + share * wave(end);
      worst_mm = std::max(worst_mm, std::abs(wave(begin + share * (end - begin)) - chord_mm));
    }
    begin = end;
  }
  EXPECT_LE(worst_mm, 2e-3);
}

TEST(WayCuts, SayWhenATooFineToleranceIsAsked) {
  const auto found = way_cuts(sampled([](double t) { return t < 0.5 ? 0 : 1; }), 4, um(1));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Code::ArgumentInvalid);
}

TEST(WayCuts, PassOnWhatTheProfileSays) {
  const auto found = way_cuts(
      [](std::size_t) -> Expected<std::vector<double>> {
        return failure({Code::GridInvalid, {}, "outside", ""});
      },
      4,
      um(1));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Code::GridInvalid);
}

}  // namespace
}  // namespace panelcal
