// SPDX-License-Identifier: Apache-2.0
#include "tools/synth/sweep/design.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <vector>

#include "calib/base/statistics/random.h"
#include <boost/random/sobol.hpp>

namespace panelcal::synth {
namespace {

constexpr std::array<std::pair<Design, std::string_view>, 3> kDesignNames = {
    {{Design::Grid, "grid"},
     {Design::LatinHypercube, "latin-hypercube"},
     {Design::Sobol, "sobol"}}};

/// Bits of a double's fraction in [0, 1).
constexpr int kShareBits = 53;

std::vector<std::size_t> permutation(std::size_t n, Random& random) {
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = n; i > 1; --i) {
    const auto k = static_cast<std::size_t>(random.uniform(0, static_cast<double>(i)));
    std::swap(order[i - 1], order[std::min(k, i - 1)]);
  }
  return order;
}

}  // namespace

std::string_view name(Design design) {
  return std::ranges::find(kDesignNames, design, [](const auto& row) { return row.first; })->second;
}

std::optional<Design> design_from_name(std::string_view name) {
  const auto* const found =
      std::ranges::find(kDesignNames, name, [](const auto& row) { return row.second; });
  if (found == kDesignNames.end()) return std::nullopt;
  return found->first;
}

Eigen::MatrixXd grid_shares(std::span<const std::size_t> n_levels) {
  const std::size_t n_points =
      std::accumulate(n_levels.begin(), n_levels.end(), std::size_t{1}, std::multiplies<>());
  Eigen::MatrixXd shares(n_points, n_levels.size());
  std::size_t n_below = n_points;
  for (std::size_t i_factor = 0; i_factor < n_levels.size(); ++i_factor) {
    const std::size_t n = n_levels[i_factor];
    n_below /= n;
    for (std::size_t i = 0; i < n_points; ++i) {
      const auto level = static_cast<double>(i / n_below % n);
      shares(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i_factor)) =
          (level + 0.5) / static_cast<double>(n);
    }
  }
  return shares;
}

Eigen::MatrixXd latin_hypercube_shares(std::size_t n_points,
                                       std::size_t n_factors,
                                       std::uint64_t seed) {
  Eigen::MatrixXd shares(n_points, n_factors);
  for (Eigen::Index column = 0; column < shares.cols(); ++column) {
    Random random = Random(seed).fork(static_cast<std::uint64_t>(column));
    const std::vector<std::size_t> parts = permutation(n_points, random);
    for (Eigen::Index row = 0; row < shares.rows(); ++row) {
      const auto part = static_cast<double>(parts[static_cast<std::size_t>(row)]);
      shares(row, column) = (part + random.uniform()) / static_cast<double>(n_points);
    }
  }
  return shares;
}

Eigen::MatrixXd sobol_shares(std::size_t n_points, std::size_t n_factors, std::uint64_t seed) {
  constexpr int kDropped = 64 - kShareBits;
  std::vector<std::uint64_t> shift(n_factors);
  for (std::size_t i = 0; i < n_factors; ++i) {
    Random random = Random(seed).fork(i);
    shift[i] = static_cast<std::uint64_t>(random.uniform() * 0x1p53) << kDropped;
  }
  Eigen::MatrixXd shares(n_points, n_factors);
  boost::random::sobol sequence(std::max<std::size_t>(1, n_factors));
  for (Eigen::Index row = 0; row < shares.rows(); ++row) {
    for (Eigen::Index column = 0; column < shares.cols(); ++column) {
      // Boost leaves out the first point, which is zero.
      const std::uint64_t place = row == 0 ? 0 : sequence();
      const std::uint64_t shifted = place ^ shift[static_cast<std::size_t>(column)];
      shares(row, column) = static_cast<double>(shifted >> kDropped) * 0x1p-53;
    }
  }
  return shares;
}

}  // namespace panelcal::synth
