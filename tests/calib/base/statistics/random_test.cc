// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/random.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/support/statistics.h"

namespace panelcal {
namespace {

TEST(Random, ASeedNamesOneSequenceForEver) {
  Random random(42);
  EXPECT_EQ(random.uniform(), 0.75515553295453897);
  EXPECT_EQ(random.uniform(), 0.63903139385469743);
  EXPECT_EQ(random.uniform(), 0.7521452007480266);
  Random normal(42);
  // The standard does not fix the last digit of log and cos.
  EXPECT_DOUBLE_EQ(normal.normal(), -1.0771745442782885);
  EXPECT_DOUBLE_EQ(normal.normal(), 1.0945198485006107);
  EXPECT_DOUBLE_EQ(normal.normal(), 1.7947316657951717);
  Random fork = Random(42).fork(7);
  EXPECT_EQ(fork.uniform(), 0.13100682362436922);
  EXPECT_EQ(fork.uniform(), 0.12099539351499145);
}

TEST(Random, ForksDoNotDependOnWhatWasDrawn) {
  Random fresh(5);
  Random used(5);
  for (int i = 0; i < 100; ++i) used.uniform();
  EXPECT_EQ(fresh.fork(3).uniform(), used.fork(3).uniform());
  EXPECT_NE(fresh.fork(3).uniform(), fresh.fork(4).uniform());
  EXPECT_NE(fresh.fork(0).uniform(), Random(5).uniform());
}

TEST(Random, UniformFillsItsInterval) {
  constexpr int kDraws = 100000;
  constexpr int kBins = 20;
  Random random(6);
  std::vector<int> counts(kBins);
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    ++counts[static_cast<std::size_t>(u * kBins)];
  }
  double chi_square = 0;
  for (const int n : counts) {
    const double expected = static_cast<double>(kDraws) / kBins;
    chi_square += (n - expected) * (n - expected) / expected;
  }
  // 0.1 % and 99.9 % quantiles of chi square with 19 degrees of freedom.
  EXPECT_GT(chi_square, 5.41);
  EXPECT_LT(chi_square, 43.82);
}

TEST(Random, NormalHasUnitVarianceAndNoMean) {
  constexpr int kDraws = 20000;
  Random random(7);
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double z = random.normal();
    sum += z;
    squares += z * z;
  }
  EXPECT_TRUE(test::mean_agrees(sum / kDraws, 0, 1, kDraws));
  EXPECT_TRUE(test::chi_square_agrees(squares, kDraws));
}

TEST(Random, NeighbouringSeedsAndForksAreUnrelated) {
  constexpr int kPairs = 2000;
  double seeds = 0;
  double forks = 0;
  const Random parent(8);
  for (std::uint64_t i = 0; i < kPairs; ++i) {
    seeds += Random(i).normal() * Random(i + 1).normal();
    forks += parent.fork(i).normal() * parent.fork(i + 1).normal();
  }
  EXPECT_TRUE(test::mean_agrees(seeds / kPairs, 0, 1, kPairs));
  EXPECT_TRUE(test::mean_agrees(forks / kPairs, 0, 1, kPairs));
}

}  // namespace
}  // namespace panelcal
