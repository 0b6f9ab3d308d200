// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/table_map.h"

#include <cmath>
#include <limits>

#include "calib/base/statistics/random.h"
#include "calib/correction/table_basis.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearMatrix;
using test::IsNearPosition;

TableGrid uneven_grid() {
  TableGrid g;
  g.low_mm = {-20, 30};
  g.high_mm = {280, 230};
  g.nx = 9;
  g.ny = 6;
  return g;
}

TableMap random_map(const TableGrid& g, double size_mm, std::uint64_t seed) {
  Random random(seed);
  std::vector<Eigen::Vector2d> coefficients_mm;
  for (int i = 0; i < g.n_coefficients(); ++i) {
    const double x_mm = size_mm * random.normal();
    const double y_mm = size_mm * random.normal();
    coefficients_mm.emplace_back(x_mm, y_mm);
  }
  return {g, coefficients_mm};
}

Position<frame::Machine> at(double x_mm, double y_mm) {
  return position_mm<frame::Machine>(x_mm, y_mm);
}

TEST(TableMap, FollowsPolynomialsUpToTheThirdDegreeExactly) {
  const TableGrid g = uneven_grid();
  const internal::TableBasis basis(g);
  const auto modes = internal::polynomial_modes();
  const auto legendre = [](int degree, double t) {
    const double p[] = {1, t, 1.5 * t * t - 0.5, 2.5 * t * t * t - 1.5 * t};
    return std::sqrt(2.0 * degree + 1) * p[degree];
  };
  for (std::size_t k = 0; k < modes.size(); ++k) {
    std::vector<Eigen::Vector2d> coefficients_mm;
    for (Eigen::Index i = 0; i < g.n_coefficients(); ++i) {
      coefficients_mm.push_back(basis.modes.col(static_cast<Eigen::Index>(k)).segment<2>(2 * i));
    }
    const TableMap map(g, coefficients_mm);
    for (const double x : {-1.0, -0.37, 0.0, 0.61, 1.0}) {
      for (const double y : {-1.0, 0.11, 0.9, 1.0}) {
        Eigen::Vector2d expected(0, 0);
        expected[modes[k].coordinate] =
            legendre(modes[k].x_degree, x) * legendre(modes[k].y_degree, y);
        EXPECT_THAT(map.error_mm(at(130 + 150 * x, 130 + 100 * y)), IsNearMatrix(expected, 1e-12));
      }
    }
  }
}

TEST(TableBasis, ItsFunctionalsAreDualToItsModes) {
  const internal::TableBasis basis(uneven_grid());
  const Eigen::MatrixXd product = basis.functionals * basis.modes;
  EXPECT_THAT(product, IsNearMatrix(Eigen::MatrixXd::Identity(20, 20), 1e-12));
}

TEST(TableBasis, ItsBendingIsTheIntegralOfCurvaturesSquared) {
  // Lengths in units of the longer side, 300 mm; the other is 2/3. By hand: of Legendre's second
  // polynomial along x, sqrt 5 (6 x^2 - ..), the curvature is 12 sqrt 5 and the integral over
  // 1 x 2/3 is 480; of 3 (2x - 1)(3y - 1) the mixed one is 18, twice its square times 2/3 is 432.
  const internal::TableBasis basis(uneven_grid());
  const auto modes = internal::polynomial_modes();
  const Eigen::Index n = uneven_grid().n_coefficients();
  for (std::size_t k = 0; k < modes.size(); ++k) {
    if (modes[k].coordinate != 0 || modes[k].x_degree + modes[k].y_degree > 2) continue;
    Eigen::VectorXd one(n);
    for (Eigen::Index i = 0; i < n; ++i) one[i] = basis.modes(2 * i, static_cast<Eigen::Index>(k));
    const double energy = one.dot(basis.bending * one);
    double expected = 0;
    if (modes[k].x_degree == 2) expected = 480;
    if (modes[k].x_degree == 1 && modes[k].y_degree == 1) expected = 432;
    if (modes[k].y_degree == 2) expected = 5 * std::pow(12 * 2.25, 2) * 2 / 3;
    EXPECT_NEAR(energy, expected, 1e-8 * (1 + expected)) << k;
  }
}

TEST(TableMap, ItsSlopeIsThatOfDifferences) {
  const TableMap map = random_map(uneven_grid(), 0.03, 1);
  const double h_mm = 1e-4;
  for (const auto& [x, y] : {std::pair(3.0, 77.0), {-20.0, 230.0}, {113.3, 130.0}, {400.0, 50.0}}) {
    Eigen::Matrix2d expected;
    expected.col(0) = (map.error_mm(at(x + h_mm, y)) - map.error_mm(at(x - h_mm, y))) / (2 * h_mm);
    expected.col(1) = (map.error_mm(at(x, y + h_mm)) - map.error_mm(at(x, y - h_mm))) / (2 * h_mm);
    if (map.covers(at(x - h_mm, y - h_mm)) && map.covers(at(x + h_mm, y + h_mm))) {
      EXPECT_THAT(map.error_slope(at(x, y)), IsNearMatrix(expected, 1e-9));
    }
    if (x > 300) {
      EXPECT_EQ(map.error_slope(at(x, y)).col(0), Eigen::Vector2d(0, 0));
    }
  }
}

TEST(TableMap, IsUndoneByItsCommand) {
  const TableMap map = random_map(uneven_grid(), 0.03, 2);
  for (const auto& [x, y] :
       {std::pair(3.0, 77.0), {-20.0, 230.0}, {113.3, 130.0}, {-90.0, 300.0}}) {
    const auto command = map.command_for(position_mm<frame::Table>(x, y));
    ASSERT_TRUE(command);
    EXPECT_THAT(map(*command), IsNearPosition(position_mm<frame::Table>(x, y), um(1e-5)));
  }
}

TEST(TableMap, BeyondItsGridErrsAsAtItsEdge) {
  const TableMap map = random_map(uneven_grid(), 0.03, 3);
  EXPECT_FALSE(map.covers(at(280.001, 100)));
  EXPECT_TRUE(map.covers(at(280, 30)));
  EXPECT_EQ(map.error_mm(at(500, 100)), map.error_mm(at(280, 100)));
  EXPECT_EQ(map.error_mm(at(-500, 1e9)), map.error_mm(at(-20, 230)));
}

TEST(TableMap, AnswersNothingToNoNumber) {
  const TableMap map = random_map(uneven_grid(), 0.03, 4);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(map.error_mm(at(nan, 0)).x()));
  EXPECT_FALSE(map.covers(at(nan, 50)));
  EXPECT_FALSE(map.command_for(position_mm<frame::Table>(0, nan)));
  EXPECT_EQ(TableMap().error_mm(at(7, -3)), Eigen::Vector2d(0, 0));
  // An error as steep as the way itself has no way back.
  EXPECT_FALSE(random_map(uneven_grid(), 300, 5).command_for(position_mm<frame::Table>(100, 100)));
}

}  // namespace
}  // namespace panelcal
