// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

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

/// v^T cov^-1 v.
double squared_distance(const Eigen::Vector2d& v, const Eigen::Matrix2d& cov);

/// A^-1 b of a symmetric matrix that may be nearly singular (L D L^T with pivots).
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The x of least |A x - b|, column by column (QR with pivots).
Eigen::MatrixXd solve_least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Whether no pivot of A's QR decomposition is below `threshold` times the largest.
bool has_full_column_rank(const Eigen::MatrixXd& a, double threshold);

}  // namespace panelcal::internal
