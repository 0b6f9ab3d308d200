// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/table_basis.h"

#include <cmath>

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr int kDegrees = 4;

/// Gauss and Legendre's rule of four points on 0 .. 1, exact up to the seventh degree.
struct Node {
  double at;
  double weight;
};
std::array<Node, 4> gauss_nodes() {
  const double inner = std::sqrt(3.0 / 7 - 2.0 / 7 * std::sqrt(1.2));
  const double outer = std::sqrt(3.0 / 7 + 2.0 / 7 * std::sqrt(1.2));
  const double heavy = (18 + std::sqrt(30.0)) / 72;
  const double light = (18 - std::sqrt(30.0)) / 72;
  return {{{0.5 * (1 - outer), light},
           {0.5 * (1 - inner), heavy},
           {0.5 * (1 + inner), heavy},
           {0.5 * (1 + outer), light}}};
}

/// Legendre's polynomials of t in -1 .. 1, with mean square 1.
double scaled_legendre(int degree, double t) {
  switch (degree) {
    case 0:
      return 1;
    case 1:
      return std::sqrt(3.0) * t;
    case 2:
      return std::sqrt(5.0) * (1.5 * t * t - 0.5);
    default:
      return std::sqrt(7.0) * (2.5 * t * t - 1.5) * t;
  }
}

/// The same as a form of three arguments, symmetric and linear in each (its blossom): at three
/// successive knots it is a coefficient of the spline.
double blossom(int degree, double a, double b, double c) {
  const double sum = (a + b + c) / 3;
  const double pairs = (a * b + b * c + c * a) / 3;
  switch (degree) {
    case 0:
      return 1;
    case 1:
      return std::sqrt(3.0) * sum;
    case 2:
      return std::sqrt(5.0) * (1.5 * pairs - 0.5);
    default:
      return std::sqrt(7.0) * (2.5 * a * b * c - 1.5 * sum);
  }
}

/// Curvatures of the four B-splines at t of a step.
std::array<double, 4> curvatures(double t) {
  return {1 - t, 3 * t - 2, 1 - 3 * t, t};
}

}  // namespace

AxisBasis::AxisBasis(int steps) {
  const Index n = steps + 3;
  polynomials = MatrixXd::Zero(n, kDegrees);
  moments = MatrixXd::Zero(n, kDegrees);
  grams.fill(MatrixXd::Zero(n, n));
  const auto centered = [steps](double at) { return 2 * at / steps - 1; };
  for (int degree = 0; degree < kDegrees; ++degree) {
    for (Index i = 0; i < n; ++i) {
      const auto knot = static_cast<double>(i);
      polynomials(i, degree) =
          blossom(degree, centered(knot - 2), centered(knot - 1), centered(knot));
    }
  }
  for (int step = 0; step < steps; ++step) {
    for (const Node& node : gauss_nodes()) {
      const SplineWeights weights(step + node.at, steps);
      const std::array<std::array<double, 4>, 3> by_order = {
          weights.value, weights.slope, curvatures(node.at)};
      for (std::size_t i = 0; i < 4; ++i) {
        const Index row = step + static_cast<Index>(i);
        for (int degree = 0; degree < kDegrees; ++degree) {
          moments(row, degree) += node.weight / steps * weights.value[i] *
                                  scaled_legendre(degree, centered(step + node.at));
        }
        for (std::size_t j = 0; j < 4; ++j) {
          for (std::size_t order = 0; order < 3; ++order) {
            grams[order](row, step + static_cast<Index>(j)) +=
                node.weight * by_order[order][i] * by_order[order][j];
          }
        }
      }
    }
  }
}

std::vector<PolynomialMode> polynomial_modes() {
  std::vector<PolynomialMode> modes;
  for (int degree = 0; degree < kDegrees; ++degree) {
    for (int coordinate = 0; coordinate < 2; ++coordinate) {
      for (int y_degree = 0; y_degree <= degree; ++y_degree) {
        modes.push_back({coordinate, degree - y_degree, y_degree});
      }
    }
  }
  return modes;
}

TableBasis::TableBasis(const TableGrid& of) : grid(of) {
  const AxisBasis x(grid.nx);
  const AxisBasis y(grid.ny);
  const Index nx = grid.nx + 3;
  const Index n = grid.n_coefficients();
  const std::vector<PolynomialMode> all = polynomial_modes();
  modes = MatrixXd::Zero(2 * n, static_cast<Index>(all.size()));
  functionals = MatrixXd::Zero(static_cast<Index>(all.size()), 2 * n);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto column = static_cast<Index>(k);
    for (Index i = 0; i < n; ++i) {
      const Index at_x = i % nx;
      const Index at_y = i / nx;
      const Index row = 2 * i + all[k].coordinate;
      modes(row, column) =
          x.polynomials(at_x, all[k].x_degree) * y.polynomials(at_y, all[k].y_degree);
      functionals(column, row) =
          x.moments(at_x, all[k].x_degree) * y.moments(at_y, all[k].y_degree);
    }
  }
  // Lengths in units of the longer side.
  const Eigen::Vector2d step = grid.step_mm() / (grid.high_mm - grid.low_mm).maxCoeff();
  const auto gram = [](const AxisBasis& axis, double h, std::size_t order) -> MatrixXd {
    return axis.grams[order] * std::pow(h, 1 - 2 * static_cast<int>(order));
  };
  bending = MatrixXd::Zero(n, n);
  for (std::size_t order = 0; order < 3; ++order) {
    const MatrixXd gx = gram(x, step.x(), order);
    const MatrixXd gy = gram(y, step.y(), 2 - order);
    const double times = order == 1 ? 2 : 1;
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j)
        bending(i, j) += times * gx(i % nx, j % nx) * gy(i / nx, j / nx);
    }
  }
}

LocalWeights local_of(const TableGrid& grid, const Eigen::Vector2d& commanded_mm) {
  const Eigen::Vector2d steps = (commanded_mm - grid.low_mm).cwiseQuotient(grid.step_mm());
  const SplineWeights x(steps.x(), grid.nx);
  const SplineWeights y(steps.y(), grid.ny);
  LocalWeights local;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      local.index[4 * j + i] =
          (y.first + static_cast<Index>(j)) * (grid.nx + 3) + x.first + static_cast<Index>(i);
      local.weight[4 * j + i] = x.value[i] * y.value[j];
    }
  }
  return local;
}

}  // namespace panelcal::internal
