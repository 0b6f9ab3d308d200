// SPDX-License-Identifier: Apache-2.0
#include "vision/texture/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace panelcal::internal {
namespace {

constexpr int kMaxTextureLag = 20;
/// The most that lags lose to what is taken out, of the shortest lag's autocovariance.
constexpr double kMaxLoss = 0.2;
/// Lattice spacing in ranges, and its limits: finer costs time, coarser loses detail.
constexpr double kSpacingOfRange = 1.2;
constexpr double kMinSpacing_px = 3;
constexpr double kMaxSpacing_px = 8;

double matern(double distance, double range) {
  const double t = distance / range;
  return t < 1e-9 ? 1 : 0.5 * t * t * std::cyl_bessel_k(2.0, t);
}

double lagged_mean(const FlatResiduals& r, int lag) {
  const auto n = static_cast<std::ptrdiff_t>(r.values.size());
  const std::ptrdiff_t down = static_cast<std::ptrdiff_t>(lag) * r.width;
  const auto sum = [&](std::ptrdiff_t offset) {
    if (offset >= n) return 0.0;
    const Eigen::Map<const Eigen::ArrayXf> a(r.values.data(), n - offset);
    const Eigen::Map<const Eigen::ArrayXf> b(r.values.data() + offset, n - offset);
    return static_cast<double>((a * b).sum());
  };
  return lag == 0 ? sum(0) / r.n : (sum(lag) + sum(down)) / (2 * r.n);
}

}  // namespace

std::optional<Texture> texture_of(const FlatResiduals& residuals) {
  if (residuals.n < 100) return std::nullopt;
  std::array<double, kMaxTextureLag + 1> seen{};
  for (int lag = 0; lag <= kMaxTextureLag; ++lag) {
    seen[static_cast<std::size_t>(lag)] = lagged_mean(residuals, lag);
  }
  Texture best;
  double least = INFINITY;
  for (double range = 1; range <= 12; range *= 1.15) {
    // seen = variance matern - loss: taking out the light's slope and waves takes a constant off
    // all lags.
    Eigen::Matrix2d h = Eigen::Matrix2d::Zero();
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    for (int lag = 1; lag <= kMaxTextureLag; ++lag) {
      const Eigen::Vector2d row(matern(lag, range), -1);
      h += row * row.transpose();
      g += seen[static_cast<std::size_t>(lag)] * row;
    }
    const double det = h(0, 0) * h(1, 1) - h(0, 1) * h(1, 0);
    double loss = (h(0, 0) * g[1] - h(1, 0) * g[0]) / det;
    loss = std::clamp(loss, 0.0, kMaxLoss * std::max(0.0, seen[1]));
    const double variance = std::clamp((g[0] - h(0, 1) * loss) / h(0, 0), 0.0, seen[0] + loss);
    double misfit = 0;
    for (int lag = 1; lag <= kMaxTextureLag; ++lag) {
      const double d = seen[static_cast<std::size_t>(lag)] + loss - variance * matern(lag, range);
      misfit += d * d;
    }
    if (misfit >= least) continue;
    least = misfit;
    const double white = std::max(seen[0] + loss - variance, 0.02 * seen[0]);
    best = {std::sqrt(variance), range, std::sqrt(white)};
  }
  if (!(best.sigma > 0.05 * best.white_sigma)) return std::nullopt;
  return best;
}

namespace {

using Vector4 = Eigen::Vector4d;
using Matrix4 = Eigen::Matrix4d;
using Matrix16 = Eigen::Matrix<double, 16, 16>;

/// The four cubic B-splines that are not 0 on a lattice cell, at t in 0 .. 1.
Eigen::Vector4f spline_weights(float t) {
  const float s = 1 - t;
  const float t2 = t * t;
  const float s2 = s * s;
  return {s2 * s / 6, (4 - 6 * t2 + 3 * t2 * t) / 6, (4 - 6 * s2 + 3 * s2 * s) / 6, t2 * t / 6};
}

/// Integrals over a cell of products of the splines' derivatives, by order of the derivative.
struct CellGram {
  std::array<Matrix4, 4> m;

  CellGram() {
    // Splines by powers of t, times 6.
    Matrix4 c;
    c << 1, -3, 3, -1,  //
        4, 0, -6, 3,    //
        1, 3, 3, -3,    //
        0, 0, 0, 1;
    c /= 6;
    for (int order = 0; order < 4; ++order) {
      Matrix4 powers = Matrix4::Zero();
      for (int i = order; i < 4; ++i) {
        for (int j = order; j < 4; ++j) {
          powers(i, j) = falling(i, order) * falling(j, order) / (i + j - 2 * order + 1);
        }
      }
      m[static_cast<std::size_t>(order)] = c * powers * c.transpose();
    }
  }
  static double falling(int n, int k) {
    double product = 1;
    for (int i = 0; i < k; ++i) product *= n - i;
    return product;
  }
};

Matrix16 kronecker(const Matrix4& y, const Matrix4& x) {
  Matrix16 product;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) product.block<4, 4>(4 * i, 4 * j) = y(i, j) * x;
  }
  return product;
}

/// The prior's precision for one cell: the integral of
/// k^6 t^2 + 3 k^4 |grad t|^2 + 3 k^2 |D^2 t|^2 + |D^3 t|^2, k = 1 / range.
Matrix16 cell_precision(const Texture& texture, double spacing) {
  const CellGram gram;
  const auto& [m0, m1, m2, m3] = gram.m;
  const double k2 = 1 / (texture.range_px * texture.range_px);
  const double h2 = spacing * spacing;
  // Derivatives by place are those by cell over the spacing, the cell's area is its square.
  const Matrix16 d0 = h2 * kronecker(m0, m0);
  const Matrix16 d1 = kronecker(m0, m1) + kronecker(m1, m0);
  const Matrix16 d2 = (kronecker(m0, m2) + 2 * kronecker(m1, m1) + kronecker(m2, m0)) / h2;
  const Matrix16 d3 =
      (kronecker(m0, m3) + 3 * kronecker(m1, m2) + 3 * kronecker(m2, m1) + kronecker(m3, m0)) /
      (h2 * h2);
  const double amplitude = 1 / (8 * std::numbers::pi * k2 * k2 * texture.sigma * texture.sigma);
  return amplitude * (k2 * k2 * k2 * d0 + 3 * k2 * k2 * d1 + 3 * k2 * d2 + d3);
}

/// Pixels in the order of their lattice cells.
struct Lattice {
  float x0 = 0;
  float y0 = 0;
  float spacing = 1;
  int n_columns = 0;  ///< of cells
  int n_rows = 0;
  std::vector<std::uint32_t> order;  ///< of the pixels
  std::vector<std::uint32_t> first;  ///< per cell, into order; one more at the end
  std::vector<int> node;             ///< compact number of each spline, -1: not used
  int n_nodes = 0;

  int node_index(int column, int row) const {
    return node[static_cast<std::size_t>(row * (n_columns + 3) + column)];
  }
};

Lattice make_lattice(std::span<const TexturedPixel> pixels, double spacing) {
  Lattice lattice;
  lattice.spacing = static_cast<float>(spacing);
  float x1 = pixels.front().x;
  float y1 = pixels.front().y;
  lattice.x0 = x1;
  lattice.y0 = y1;
  for (const TexturedPixel& p : pixels) {
    lattice.x0 = std::min(lattice.x0, p.x);
    lattice.y0 = std::min(lattice.y0, p.y);
    x1 = std::max(x1, p.x);
    y1 = std::max(y1, p.y);
  }
  lattice.n_columns = 1 + static_cast<int>((x1 - lattice.x0) / lattice.spacing);
  lattice.n_rows = 1 + static_cast<int>((y1 - lattice.y0) / lattice.spacing);
  const auto cell_of = [&](const TexturedPixel& p) {
    const int column = static_cast<int>((p.x - lattice.x0) / lattice.spacing);
    const int row = static_cast<int>((p.y - lattice.y0) / lattice.spacing);
    return static_cast<std::size_t>(row * lattice.n_columns + column);
  };
  lattice.first.assign(static_cast<std::size_t>(lattice.n_columns * lattice.n_rows) + 1, 0);
  for (const TexturedPixel& p : pixels) ++lattice.first[cell_of(p) + 1];
  for (std::size_t i = 1; i < lattice.first.size(); ++i) lattice.first[i] += lattice.first[i - 1];
  std::vector<std::uint32_t> next(lattice.first.begin(), lattice.first.end() - 1);
  lattice.order.resize(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    lattice.order[next[cell_of(pixels[i])]++] = static_cast<std::uint32_t>(i);
  }
  lattice.node.assign(static_cast<std::size_t>((lattice.n_columns + 3) * (lattice.n_rows + 3)), -1);
  for (int row = 0; row < lattice.n_rows; ++row) {
    for (int column = 0; column < lattice.n_columns; ++column) {
      const auto cell = static_cast<std::size_t>(row * lattice.n_columns + column);
      if (lattice.first[cell] == lattice.first[cell + 1]) continue;
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
          lattice.node[static_cast<std::size_t>((row + i) * (lattice.n_columns + 3) + column + j)] =
              0;
        }
      }
    }
  }
  for (int& node : lattice.node) {
    if (node == 0) node = lattice.n_nodes++;
  }
  return lattice;
}

/// The texture's equations and how they hang together with the parameters' and the residual.
struct TextureEquations {
  Eigen::SparseMatrix<double> precision;  ///< lower part
  Eigen::MatrixXd coupling;               ///< splines by parameters, then the residual
};

TextureEquations assemble(std::span<const TexturedPixel> pixels,
                          const Eigen::MatrixXf& jacobian,
                          const Texture& texture,
                          const Lattice& lattice) {
  const Matrix16 prior = cell_precision(texture, static_cast<double>(lattice.spacing));
  const auto weight = static_cast<float>(1 / (texture.white_sigma * texture.white_sigma));
  const Eigen::Index n_columns = jacobian.cols() + 1;
  TextureEquations equations;
  equations.coupling.setZero(lattice.n_nodes, n_columns);
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(136 * lattice.first.size());
  Eigen::Matrix<float, Eigen::Dynamic, 16> basis;
  Eigen::MatrixXf columns;
  for (int row = 0; row < lattice.n_rows; ++row) {
    for (int column = 0; column < lattice.n_columns; ++column) {
      const auto cell = static_cast<std::size_t>(row * lattice.n_columns + column);
      const std::uint32_t from = lattice.first[cell];
      const auto n = static_cast<Eigen::Index>(lattice.first[cell + 1] - from);
      if (n == 0) continue;
      basis.resize(n, 16);
      columns.resize(n, n_columns);
      for (Eigen::Index k = 0; k < n; ++k) {
        const std::uint32_t i = lattice.order[from + static_cast<std::uint32_t>(k)];
        const TexturedPixel& p = pixels[i];
        const float u = (p.x - lattice.x0) / lattice.spacing - static_cast<float>(column);
        const float v = (p.y - lattice.y0) / lattice.spacing - static_cast<float>(row);
        const Eigen::Vector4f bx = p.background * spline_weights(u);
        const Eigen::Vector4f by = spline_weights(v);
        for (int a = 0; a < 4; ++a) basis.block<1, 4>(k, 4 * a) = by[a] * bx.transpose();
        columns.row(k).head(n_columns - 1) = jacobian.row(i);
        columns(k, n_columns - 1) = p.residual;
      }
      const Eigen::Matrix<float, 16, 16> gram = weight * (basis.transpose() * basis);
      const Eigen::MatrixXf coupled = weight * (basis.transpose() * columns);
      std::array<int, 16> nodes{};
      for (int a = 0; a < 16; ++a) {
        nodes[static_cast<std::size_t>(a)] = lattice.node_index(column + a % 4, row + a / 4);
        equations.coupling.row(nodes[static_cast<std::size_t>(a)]) += coupled.row(a).cast<double>();
      }
      // Compact numbers rise with the splines', so that b <= a is the lower part.
      for (int a = 0; a < 16; ++a) {
        for (int b = 0; b <= a; ++b) {
          entries.emplace_back(nodes[static_cast<std::size_t>(a)],
                               nodes[static_cast<std::size_t>(b)],
                               static_cast<double>(gram(a, b)) + prior(a, b));
        }
      }
    }
  }
  equations.precision.resize(lattice.n_nodes, lattice.n_nodes);
  equations.precision.setFromTriplets(entries.begin(), entries.end());
  return equations;
}

}  // namespace

std::optional<GeneralizedStep> generalized_step(std::span<const TexturedPixel> pixels,
                                                const Eigen::MatrixXf& jacobian,
                                                const Texture& texture,
                                                const Eigen::MatrixXd& information,
                                                const Eigen::VectorXd& gradient) {
  if (pixels.empty()) return std::nullopt;
  const double spacing =
      std::clamp(kSpacingOfRange * texture.range_px, kMinSpacing_px, kMaxSpacing_px);
  const Lattice lattice = make_lattice(pixels, spacing);
  const TextureEquations texture_part = assemble(pixels, jacobian, texture, lattice);
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor(
      texture_part.precision);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Eigen::MatrixXd solved = factor.solve(texture_part.coupling);
  const Eigen::Index n = jacobian.cols();
  const double weight = 1 / (texture.white_sigma * texture.white_sigma);
  Eigen::VectorXf residual(static_cast<Eigen::Index>(pixels.size()));
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    residual[static_cast<Eigen::Index>(i)] = pixels[i].residual;
  }
  const Eigen::MatrixXd explained = texture_part.coupling.transpose() * solved;
  Eigen::MatrixXd h = weight * (jacobian.transpose() * jacobian).cast<double>() + information;
  h -= explained.topLeftCorner(n, n);
  Eigen::VectorXd g = weight * (jacobian.transpose() * residual).cast<double>() + gradient;
  g -= explained.col(n).head(n);
  const Eigen::LDLT<Eigen::MatrixXd> normal(h);
  // Of a zero pivot LDLT makes a zero step: a parameter that nothing depends on.
  if (normal.info() != Eigen::Success || !(normal.vectorD().minCoeff() > 0)) return std::nullopt;
  GeneralizedStep result;
  result.step = normal.solve(g);
  result.covariance = normal.solve(Eigen::MatrixXd::Identity(n, n));
  // Of the listed pixels alone: before the step, and what the step takes away.
  const double before = weight * static_cast<double>(residual.squaredNorm()) - explained(n, n);
  const double taken =
      2 * result.step.dot(g - gradient) - result.step.dot((h - information) * result.step);
  result.chi_square = (before - taken) / static_cast<double>(pixels.size());
  if (!result.step.allFinite() || !result.covariance.allFinite()) return std::nullopt;
  return result;
}

}  // namespace panelcal::internal
