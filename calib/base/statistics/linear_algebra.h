// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>

// Not installed. Eigen's decompositions, compiled once: each takes seconds wherever its template is
// used. Numbers are Eigen's, to the last bit.
namespace panelcal::internal {

/// Eigenvalues in ascending order and unit eigenvectors, of a symmetric matrix.
struct Eigensystem {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
  bool has_converged = false;
};
Eigensystem eigensystem(const Eigen::MatrixXd& symmetric);

/// The same without eigenvectors, which are left empty.
Eigensystem eigenvalues(const Eigen::MatrixXd& symmetric);

/// The same of a 2 x 2 matrix.
struct PlaneEigensystem {
  Eigen::Vector2d values;
  Eigen::Matrix2d vectors;
};
PlaneEigensystem plane_eigensystem(const Eigen::Matrix2d& symmetric);
Eigen::Vector2d plane_eigenvalues(const Eigen::Matrix2d& symmetric);

/// A = L L^T.
class Cholesky {
 public:
  explicit Cholesky(const Eigen::MatrixXd& a);

  /// False if A is not positive definite; the rest is meaningless then.
  bool is_definite() const;
  /// 1 over the condition number, estimated.
  double rcond() const;
  double log_determinant() const;

  /// A^-1 b.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;
  /// A^-1.
  Eigen::MatrixXd inverse() const;
  /// L^-1 b: of errors of covariance A independent ones of variance 1.
  Eigen::VectorXd whiten(const Eigen::VectorXd& b) const;
  Eigen::MatrixXd whiten(const Eigen::MatrixXd& b) const;

 private:
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

/// J cov J^T.
Eigen::MatrixXd propagated(const Eigen::MatrixXd& j, const Eigen::MatrixXd& cov);
/// The same of independent errors of these variances.
Eigen::MatrixXd propagated_diagonal(const Eigen::MatrixXd& j, const Eigen::VectorXd& variances);

/// The lower triangular L of cov = L L^T.
Eigen::Matrix2d plane_root(const Eigen::Matrix2d& cov);

/// v^T cov^-1 v.
double squared_distance(const Eigen::Vector2d& v, const Eigen::Matrix2d& cov);

/// A^-1 b of a symmetric matrix that may be nearly singular (L D L^T with pivots).
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The same of a 2 x 2 matrix.
Eigen::Vector2d solve_plane_symmetric(const Eigen::Matrix2d& a, const Eigen::Vector2d& b);

/// A symmetric matrix turned until only its diagonal and the elements beside it are left,
/// A = Q T Q^T.
struct TridiagonalForm {
  Eigen::VectorXd diagonal;
  Eigen::VectorXd beside;
  Eigen::VectorXd turned;  ///< Q^T v
};
TridiagonalForm tridiagonal_form(const Eigen::MatrixXd& symmetric, const Eigen::VectorXd& v);

/// A = Q R of at least as many rows as columns, without pivots.
class OrthogonalTriangular {
 public:
  OrthogonalTriangular() = default;
  explicit OrthogonalTriangular(const Eigen::MatrixXd& a);

  /// Square: the columns of A span the first ones, the rest is their complement.
  Eigen::MatrixXd q() const;
  /// Upper triangular, as many rows as A has columns.
  Eigen::MatrixXd r() const;
  /// Q^T M Q by the reflections that Q is made of: O(n^2) for each column of A.
  Eigen::MatrixXd turned(Eigen::MatrixXd m) const;

 private:
  Eigen::HouseholderQR<Eigen::MatrixXd> qr_;
};

/// The pseudo-inverse of a matrix that may be short of rank (complete orthogonal decomposition):
/// pivots below `threshold` times the largest count as 0.
struct PseudoInverse {
  Eigen::MatrixXd matrix;
  Eigen::Index rank = 0;
};
PseudoInverse pseudo_inverse(const Eigen::MatrixXd& a, double threshold);

/// The x of least |A x - b|, column by column (QR with pivots).
Eigen::MatrixXd solve_least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// True if no pivot of A's QR decomposition is below `threshold` times the largest.
bool has_full_column_rank(const Eigen::MatrixXd& a, double threshold);

}  // namespace panelcal::internal
