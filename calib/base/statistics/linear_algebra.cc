// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/linear_algebra.h"

#include <Eigen/Eigenvalues>

namespace panelcal::internal {

namespace {

// A symmetric matrix of 2 x 2 is tridiagonal as it stands. PlaneSolver::compute would first turn it
// into that form, by reflections that are all 1, and takes seconds to compile for it; what is done
// here is the rest of it, to the last bit.
using PlaneSolver = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>;

/// The largest element of the lower triangle, which the solver reads alone; 1 if all are 0.
double plane_scale(const Eigen::Matrix2d& symmetric) {
  const Eigen::Matrix2d lower = symmetric.triangularView<Eigen::Lower>();
  const double scale = lower.cwiseAbs().maxCoeff();
  return scale == 0 ? 1 : scale;
}

/// The element beside the diagonal.
PlaneSolver::SubDiagonalType plane_beside(const Eigen::Matrix2d& symmetric) {
  return PlaneSolver::SubDiagonalType(symmetric(1, 0));
}

}  // namespace

Eigensystem eigensystem(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

Eigensystem eigenvalues(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric, Eigen::EigenvaluesOnly);
  return {solver.eigenvalues(), {}, solver.info() == Eigen::Success};
}

PlaneEigensystem plane_eigensystem(const Eigen::Matrix2d& symmetric) {
  const double scale = plane_scale(symmetric);
  PlaneSolver solver;
  solver.computeFromTridiagonal(symmetric.diagonal() / scale, plane_beside(symmetric) / scale);
  return {solver.eigenvalues() * scale, solver.eigenvectors()};
}

Eigen::Vector2d plane_eigenvalues(const Eigen::Matrix2d& symmetric) {
  const double scale = plane_scale(symmetric);
  PlaneSolver solver;
  solver.computeFromTridiagonal(
      symmetric.diagonal() / scale, plane_beside(symmetric) / scale, Eigen::EigenvaluesOnly);
  return solver.eigenvalues() * scale;
}

Cholesky::Cholesky(const Eigen::MatrixXd& a) : llt_(a) {
}

bool Cholesky::is_definite() const {
  return llt_.info() == Eigen::Success;
}

double Cholesky::rcond() const {
  return llt_.rcond();
}

double Cholesky::log_determinant() const {
  return 2 * llt_.matrixLLT().diagonal().array().log().sum();
}

Eigen::VectorXd Cholesky::solve(const Eigen::VectorXd& b) const {
  return llt_.solve(b);
}

Eigen::MatrixXd Cholesky::solve(const Eigen::MatrixXd& b) const {
  return llt_.solve(b);
}

Eigen::MatrixXd Cholesky::inverse() const {
  return llt_.solve(Eigen::MatrixXd::Identity(llt_.rows(), llt_.cols()));
}

Eigen::VectorXd Cholesky::whiten(const Eigen::VectorXd& b) const {
  return llt_.matrixL().solve(b);
}

Eigen::MatrixXd Cholesky::whiten(const Eigen::MatrixXd& b) const {
  return llt_.matrixL().solve(b);
}

Eigen::MatrixXd propagated(const Eigen::MatrixXd& j, const Eigen::MatrixXd& cov) {
  return j * cov * j.transpose();
}

Eigen::MatrixXd propagated_diagonal(const Eigen::MatrixXd& j, const Eigen::VectorXd& variances) {
  return j * variances.asDiagonal() * j.transpose();
}

Eigen::Matrix2d plane_root(const Eigen::Matrix2d& cov) {
  return cov.llt().matrixL();
}

double squared_distance(const Eigen::Vector2d& v, const Eigen::Matrix2d& cov) {
  return v.dot(cov.llt().solve(v));
}

Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.ldlt().solve(b);
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.ldlt().solve(b);
}

Eigen::Vector2d solve_plane_symmetric(const Eigen::Matrix2d& a, const Eigen::Vector2d& b) {
  return a.ldlt().solve(b);
}

TridiagonalForm tridiagonal_form(const Eigen::MatrixXd& symmetric, const Eigen::VectorXd& v) {
  const Eigen::Tridiagonalization<Eigen::MatrixXd> form(symmetric);
  TridiagonalForm out{form.diagonal(), form.subDiagonal(), v};
  out.turned.applyOnTheLeft(form.matrixQ().adjoint());
  return out;
}

OrthogonalTriangular::OrthogonalTriangular(const Eigen::MatrixXd& a) : qr_(a) {
}

Eigen::MatrixXd OrthogonalTriangular::q() const {
  return qr_.householderQ() * Eigen::MatrixXd::Identity(qr_.rows(), qr_.rows());
}

Eigen::MatrixXd OrthogonalTriangular::r() const {
  return qr_.matrixQR().topRows(qr_.cols()).triangularView<Eigen::Upper>();
}

Eigen::MatrixXd OrthogonalTriangular::turned(Eigen::MatrixXd m) const {
  m.applyOnTheLeft(qr_.householderQ().adjoint());
  m.applyOnTheRight(qr_.householderQ());
  return m;
}

PseudoInverse pseudo_inverse(const Eigen::MatrixXd& a, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposed;
  decomposed.setThreshold(threshold);
  decomposed.compute(a);
  return {decomposed.pseudoInverse(), decomposed.rank()};
}

Eigen::MatrixXd solve_least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.colPivHouseholderQr().solve(b);
}

bool has_full_column_rank(const Eigen::MatrixXd& a, double threshold) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(a);
  qr.setThreshold(threshold);
  return qr.rank() == a.cols();
}

}  // namespace panelcal::internal
