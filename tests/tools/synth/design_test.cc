// SPDX-License-Identifier: Apache-2.0
#include "tools/synth/sweep/design.h"

#include <array>
#include <cstdint>
#include <set>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::synth {
namespace {

using testing::Each;
using testing::ElementsAre;

/// How many points of a column lie in each of n equal parts of [0, 1).
std::vector<int> counts(const Eigen::MatrixXd& shares, Eigen::Index column, int n) {
  std::vector<int> out(static_cast<std::size_t>(n));
  for (Eigen::Index row = 0; row < shares.rows(); ++row) {
    ++out.at(static_cast<std::size_t>(shares(row, column) * n));
  }
  return out;
}

TEST(Design, GridHasEachLevelWithEachOtherAndTheLastFactorFirst) {
  const std::array<std::size_t, 2> levels = {2, 3};
  const Eigen::MatrixXd shares = grid_shares(levels);
  ASSERT_EQ(shares.rows(), 6);
  const Eigen::VectorXd first = shares.col(0), second = shares.col(1);
  EXPECT_THAT(first, ElementsAre(0.25, 0.25, 0.25, 0.75, 0.75, 0.75));
  EXPECT_THAT(second, ElementsAre(0.5 / 3, 0.5, 2.5 / 3, 0.5 / 3, 0.5, 2.5 / 3));
}

TEST(Design, LatinHypercubeHasOnePointInEachPartOfEachFactor) {
  constexpr int kPoints = 97;
  const Eigen::MatrixXd shares = latin_hypercube_shares(kPoints, 6, 5);
  for (Eigen::Index column = 0; column < 6; ++column) {
    EXPECT_THAT(counts(shares, column, kPoints), Each(1)) << column;
  }
  EXPECT_NE(shares, latin_hypercube_shares(kPoints, 6, 6));
}

/// Equal parts say nothing of how factors go together: uncorrelated within five sigmas, 1 /
/// sqrt(n).
TEST(Design, LatinHypercubeDoesNotTieFactorsToEachOther) {
  constexpr int kPoints = 2000;
  const Eigen::MatrixXd shares = latin_hypercube_shares(kPoints, 4, 1);
  const Eigen::MatrixXd off = shares.array() - 0.5;
  const Eigen::MatrixXd correlations = 12 * off.transpose() * off / kPoints;
  for (Eigen::Index i = 0; i < 4; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      EXPECT_LT(std::abs(correlations(i, j)), 5 / std::sqrt(kPoints)) << i << " " << j;
    }
  }
}

/// Sobol's first two dimensions by their definition: x_i is the exclusive sum of the direction
/// numbers m_k / 2^k of the bits of i's Gray code, where m_k is 1 in the first dimension and by the
/// primitive polynomial x + 1 m_1 = 1, m_k = 2 m_(k-1) xor m_(k-1) in the second one.
std::array<double, 2> sobol_by_definition(unsigned i) {
  std::array<double, 2> place = {};
  std::array<std::uint64_t, 2> bits = {};
  std::uint64_t m = 1;
  for (unsigned k = 1; k <= 32; ++k) {
    if (((i ^ (i >> 1U)) >> (k - 1U) & 1U) != 0) {
      bits[0] ^= std::uint64_t{1} << (32U - k);
      bits[1] ^= m << (32U - k);
    }
    m = (m << 1U) ^ m;
  }
  for (std::size_t d = 0; d < 2; ++d) place[d] = static_cast<double>(bits[d]) * 0x1p-32;
  return place;
}

/// A share without the digital shift, which the first point is.
double without_shift(double share, double first) {
  const auto bits = [](double v) { return static_cast<std::uint64_t>(v * 0x1p53); };
  return static_cast<double>(bits(share) ^ bits(first)) * 0x1p-53;
}

TEST(Design, SobolIsTheSequenceByItsDefinition) {
  constexpr unsigned kPoints = 256;
  const Eigen::MatrixXd shares = sobol_shares(kPoints, 2, 9);
  for (unsigned i = 0; i < kPoints; ++i) {
    const auto expected = sobol_by_definition(i);
    for (Eigen::Index d = 0; d < 2; ++d) {
      EXPECT_EQ(without_shift(shares(i, d), shares(0, d)), expected.at(static_cast<std::size_t>(d)))
          << i << " " << d;
    }
  }
}

/// A (0, k, 2)-net in base 2: each box of 2^-a by 2^-(k - a) has one of 2^k points, shifted or not.
TEST(Design, SobolFillsEachBoxOfTwoFactorsOnce) {
  constexpr int kBits = 8;
  const Eigen::MatrixXd shares = sobol_shares(1U << kBits, 2, 4);
  for (int a = 0; a <= kBits; ++a) {
    std::set<std::pair<int, int>> boxes;
    for (Eigen::Index i = 0; i < shares.rows(); ++i) {
      boxes.emplace(static_cast<int>(shares(i, 0) * (1 << a)),
                    static_cast<int>(shares(i, 1) * (1 << (kBits - a))));
    }
    EXPECT_EQ(boxes.size(), 1U << kBits) << a;
  }
}

TEST(Design, SobolHasOnePointInEachPartOfEachOfManyFactors) {
  const Eigen::MatrixXd shares = sobol_shares(512, 40, 2);
  for (Eigen::Index column = 0; column < 40; ++column) {
    EXPECT_THAT(counts(shares, column, 512), Each(1)) << column;
  }
  EXPECT_EQ(sobol_shares(100, 40, 2), shares.topRows(100)) << "a longer set has the shorter one";
  EXPECT_NE(sobol_shares(512, 40, 3), shares);
}

TEST(Design, NamesReadBack) {
  for (const Design design : {Design::Grid, Design::LatinHypercube, Design::Sobol}) {
    EXPECT_EQ(design_from_name(name(design)), design);
  }
  EXPECT_EQ(design_from_name("random"), std::nullopt);
}

}  // namespace
}  // namespace panelcal::synth
