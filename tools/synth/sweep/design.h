// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include <Eigen/Core>

namespace panelcal::synth {

/// The way in which points are spread over the ranges of the factors.
enum class Design : std::uint8_t {
  Grid,            ///< each level of each factor with each level of all others
  LatinHypercube,  ///< each of n equal parts of each factor's range has one of the n points
  Sobol,           ///< points that fill the space of all factors evenly, however many there are
};

/// "grid", "latin-hypercube", "sobol".
std::string_view name(Design design);
std::optional<Design> design_from_name(std::string_view name);

/// Points of a grid, the last factor fastest.
///
/// In     n_levels: of each factor, 1 or more
/// Out    shares of the ranges, the middles of the levels' parts: a row a point, a column a factor
Eigen::MatrixXd grid_shares(std::span<const std::size_t> n_levels);

/// A Latin hypercube: of each factor's n_points equal parts of [0, 1) each has one point, somewhere
/// in it; which parts of different factors meet is random.
///
/// Source McKay, Beckman and Conover, Technometrics 21, 239-245 (1979)
/// See    tests/tools/synth/design_test.cc
Eigen::MatrixXd latin_hypercube_shares(std::size_t n_points,
                                       std::size_t n_factors,
                                       std::uint64_t seed);

/// The first points of Sobol's sequence, zero included, moved by a digital shift: of the first 2^k
/// points each factor's 2^k equal parts have one each, whatever the seed.
///
/// In     n_factors: at most 3667
/// Source Boost.Random with the direction numbers of Joe and Kuo, SIAM J. Sci. Comput. 30,
///        2635-2654 (2008); zero included: Owen, On dropping the first Sobol' point (2020)
/// See    tests/tools/synth/design_test.cc
Eigen::MatrixXd sobol_shares(std::size_t n_points, std::size_t n_factors, std::uint64_t seed);

}  // namespace panelcal::synth
