// SPDX-License-Identifier: Apache-2.0
#include "calib/table/modes.h"

#include <cmath>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/table/geometry.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A named mode is open if this much of its square lies among the open combinations.
constexpr double kWhole = 0.99;
/// Part of a combination that is left once the named modes are taken out of it; less is rounding.
constexpr double kLeft = 0.05;

Index index_of(int coordinate, int x_degree, int y_degree) {
  const std::vector<PolynomialMode> all = polynomial_modes();
  for (std::size_t k = 0; k < all.size(); ++k) {
    const PolynomialMode& mode = all[k];
    if (mode.coordinate == coordinate && mode.x_degree == x_degree && mode.y_degree == y_degree) {
      return static_cast<Index>(k);
    }
  }
  return 0;
}

/// Half the sides of the grid over sqrt 3: what turns a slope into the size of a Legendre mode.
Eigen::Vector2d reach_mm(const TableBasis& basis) {
  return (basis.grid.high_mm - basis.grid.low_mm) / (2 * std::sqrt(3.0));
}

/// A combination of modes that is linear in the place: E = linear c.
VectorXd linear_mode(const TableBasis& basis, const Eigen::Matrix2d& linear) {
  const Eigen::Vector2d reach = reach_mm(basis);
  VectorXd mode = VectorXd::Zero(basis.modes.cols());
  for (int coordinate = 0; coordinate < 2; ++coordinate) {
    mode[index_of(coordinate, 1, 0)] = linear(coordinate, 0) * reach.x();
    mode[index_of(coordinate, 0, 1)] = linear(coordinate, 1) * reach.y();
  }
  return mode;
}

struct Named {
  std::string name;
  VectorXd mode;
  bool is_convention = false;
};

/// Both shifts and the turn, orthonormal.
MatrixXd conventional_modes(const TableBasis& basis) {
  Eigen::Matrix2d turn;
  turn << 0, -1, 1, 0;
  MatrixXd out(basis.modes.cols(), kOpenTurn + 1);
  out << VectorXd::Unit(basis.modes.cols(), index_of(0, 0, 0)),
      VectorXd::Unit(basis.modes.cols(), index_of(1, 0, 0)), linear_mode(basis, turn).normalized();
  return out;
}

std::string monomial(int x_degree, int y_degree) {
  std::string text;
  const auto append = [&](char letter, int degree) {
    if (degree == 0) return;
    if (!text.empty()) text += ' ';
    text += letter;
    if (degree > 1) text += fmt::format("^{}", degree);
  };
  append('x', x_degree);
  append('y', y_degree);
  return text;
}

std::vector<Named> named_modes(const TableBasis& basis) {
  const auto matrix = [](double xx, double xy, double yx, double yy) {
    Eigen::Matrix2d m;
    m << xx, xy, yx, yy;
    return m;
  };
  std::vector<Named> named;
  for (int coordinate = 0; coordinate < 2; ++coordinate) {
    named.push_back(
        {"shift", VectorXd::Unit(basis.modes.cols(), index_of(coordinate, 0, 0)), true});
  }
  named.push_back({"turn", linear_mode(basis, matrix(0, -1, 1, 0)), true});
  named.push_back({"scale", linear_mode(basis, matrix(1, 0, 0, 1))});
  named.push_back({"scale of x against y", linear_mode(basis, matrix(1, 0, 0, -1))});
  named.push_back({"squareness", linear_mode(basis, matrix(0, 1, 1, 0))});
  const std::vector<PolynomialMode> all = polynomial_modes();
  for (std::size_t k = 0; k < all.size(); ++k) {
    const PolynomialMode& mode = all[k];
    if (mode.x_degree + mode.y_degree < 2) continue;
    const std::string name = fmt::format(
        "{} error by {}", mode.coordinate == 0 ? 'x' : 'y', monomial(mode.x_degree, mode.y_degree));
    named.push_back({name, VectorXd::Unit(basis.modes.cols(), static_cast<Index>(k))});
  }
  return named;
}

}  // namespace

OpenModes find_open_modes(const TableBasis& basis, const MatrixXd& normal, double open_sigma_mm) {
  const MatrixXd of_modes = basis.modes.transpose() * normal * basis.modes;
  const MatrixXd convention = conventional_modes(basis);
  const Index n = of_modes.rows();
  // Eigenvectors of 1 span what convention leaves.
  const Eigensystem split =
      eigensystem(MatrixXd::Identity(n, n) - convention * convention.transpose());
  const MatrixXd others = split.vectors.rightCols(n - convention.cols());
  const Eigensystem information = eigensystem(others.transpose() * of_modes * others);
  Index n_open = 0;
  for (const double value : information.values) {
    n_open += !(value > 1 / (open_sigma_mm * open_sigma_mm));
  }
  OpenModes open;
  open.combinations.resize(n, convention.cols() + n_open);
  open.combinations << convention, others * information.vectors.leftCols(n_open);
  const MatrixXd seen = others * information.vectors.rightCols(others.cols() - n_open);
  const VectorXd turn = convention.col(kOpenTurn);
  const VectorXd weight = information.values.tail(seen.cols()).cwiseInverse();
  open.turn = turn - seen * weight.cwiseProduct(seen.transpose() * (of_modes * turn));
  MatrixXd left = open.combinations;  // what the named ones have not yet explained
  for (Named& candidate : named_modes(basis)) {
    VectorXd mode = candidate.mode.normalized();
    const double share = (left.transpose() * mode).squaredNorm();
    if (share < kWhole) continue;
    if (!candidate.is_convention) open.names.push_back(candidate.name);
    mode = left * (left.transpose() * mode);
    mode.normalize();
    // Combinations that are orthogonal to it, in the same space.
    left -= mode * (mode.transpose() * left);
    const Eigensystem rest = eigensystem(left * left.transpose());
    left = rest.vectors.rightCols(left.cols() - 1);
  }
  const std::vector<Named> named = named_modes(basis);
  for (Index k = 0; k < left.cols(); ++k) {
    std::string text = "a mixture of";
    for (const Named& part : named) {
      if (part.is_convention) continue;
      const double share = part.mode.normalized().dot(left.col(k));
      if (share * share > kLeft) {
        text += fmt::format("{}{}", text.ends_with("of") ? " " : ", ", part.name);
      }
    }
    open.names.push_back(text);
  }
  return open;
}

Eigen::RowVectorXd turn_functional(const TableBasis& basis) {
  return basis.functionals.row(index_of(1, 1, 0)) / reach_mm(basis).x();
}

Eigen::Matrix2d linear_functional(const TableBasis& basis, const VectorXd& coefficients) {
  const Eigen::Vector2d reach = reach_mm(basis);
  Eigen::Matrix2d linear;
  for (int coordinate = 0; coordinate < 2; ++coordinate) {
    linear(coordinate, 0) =
        basis.functionals.row(index_of(coordinate, 1, 0)).dot(coefficients) / reach.x();
    linear(coordinate, 1) =
        basis.functionals.row(index_of(coordinate, 0, 1)).dot(coefficients) / reach.y();
  }
  return linear;
}

Eigen::MatrixXd geometry_functionals(const TableBasis& basis) {
  const Eigen::Vector2d reach = reach_mm(basis);
  MatrixXd rows(TableGeometry::kSize, basis.size());
  const auto of = [&](int coordinate, int x_degree, int y_degree) {
    return basis.functionals.row(index_of(coordinate, x_degree, y_degree));
  };
  rows.row(TableGeometry::ScaleX) = of(0, 1, 0) / reach.x();
  rows.row(TableGeometry::ScaleY) = of(1, 0, 1) / reach.y();
  rows.row(TableGeometry::Squareness) = of(0, 0, 1) / reach.y() + of(1, 1, 0) / reach.x();
  for (int degree = 2; degree <= 3; ++degree) {
    // Legendre's polynomials are 1 at the end where their mean square is 1 / (2 degree + 1).
    const double end = std::sqrt(2.0 * degree + 1);
    const int further = degree - 2;
    rows.row(TableGeometry::LinearityX2 + further) = end * of(0, degree, 0);
    rows.row(TableGeometry::LinearityY2 + further) = end * of(1, 0, degree);
    rows.row(TableGeometry::StraightnessX2 + further) = end * of(1, degree, 0);
    rows.row(TableGeometry::StraightnessY2 + further) = end * of(0, 0, degree);
  }
  return rows;
}

}  // namespace panelcal::internal
