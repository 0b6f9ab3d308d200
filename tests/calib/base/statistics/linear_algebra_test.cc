// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/linear_algebra.h"

#include <random>

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of numbers about 1, in at most a few hundred operations.
constexpr double kAlgebraRounding = 1e-12;

MatrixXd random_matrix(Index rows, Index columns) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  MatrixXd out(rows, columns);
  for (double& value : out.reshaped()) value = normal(random);
  return out;
}

TEST(LinearAlgebra, PutsOrthogonalAndTriangularTogetherAgain) {
  const MatrixXd a = random_matrix(7, 3);
  const OrthogonalTriangular qr(a);
  const MatrixXd q = qr.q();
  const MatrixXd r = qr.r();
  ASSERT_EQ(q.cols(), 7);
  ASSERT_EQ(r.rows(), 3);
  EXPECT_EQ(r(2, 0), 0);
  EXPECT_LT((q.transpose() * q - MatrixXd::Identity(7, 7)).norm(), kAlgebraRounding);
  EXPECT_LT((q.leftCols(3) * r - a).norm(), kAlgebraRounding);
  const MatrixXd m = random_matrix(7, 7);
  EXPECT_LT((qr.turned(m) - q.transpose() * m * q).norm(), kAlgebraRounding);
}

TEST(LinearAlgebra, KeepsEigenvaluesAndLengthInTheTridiagonalForm) {
  const MatrixXd root = random_matrix(6, 6);
  const MatrixXd a = root * root.transpose();
  const VectorXd v = random_matrix(6, 1);
  const TridiagonalForm form = tridiagonal_form(a, v);
  MatrixXd t = form.diagonal.asDiagonal();
  t.diagonal(1) = form.beside;
  t.diagonal(-1) = form.beside;
  EXPECT_LT((eigenvalues(t).values - eigenvalues(a).values).norm(), 10 * kAlgebraRounding);
  EXPECT_NEAR(form.turned.dot(t * form.turned), v.dot(a * v), 10 * kAlgebraRounding);
}

TEST(LinearAlgebra, InvertsWhatIsShortOfRank) {
  MatrixXd a = random_matrix(5, 3);
  a.col(2) = a.col(0) - a.col(1);
  const PseudoInverse inverse = pseudo_inverse(a, 1e-6);
  EXPECT_EQ(inverse.rank, 2);
  EXPECT_LT((a * inverse.matrix * a - a).norm(), kAlgebraRounding);
}

TEST(LinearAlgebra, PropagatesCovariances) {
  const MatrixXd j = random_matrix(2, 3);
  const VectorXd variances = VectorXd::LinSpaced(3, 1, 3);
  const MatrixXd cov = variances.asDiagonal();
  EXPECT_LT((propagated(j, cov) - propagated_diagonal(j, variances)).norm(), kAlgebraRounding);
  EXPECT_NEAR(propagated(j, cov)(0, 1),
              j(0, 0) * j(1, 0) + 2 * j(0, 1) * j(1, 1) + 3 * j(0, 2) * j(1, 2),
              kAlgebraRounding);
}

TEST(LinearAlgebra, SolvesInThePlane) {
  Eigen::Matrix2d a;
  a << 4, 1, 1, 3;
  const Eigen::Vector2d b(1, 2);
  EXPECT_LT((a * solve_plane_symmetric(a, b) - b).norm(), kAlgebraRounding);
  const Eigen::Matrix2d root = plane_root(a);
  EXPECT_EQ(root(0, 1), 0);
  EXPECT_LT((root * root.transpose() - a).norm(), kAlgebraRounding);
}

TEST(LinearAlgebra, TurnsThePlaneAsAnySpaceToTheLastBit) {
  const MatrixXd numbers = random_matrix(3, 100);
  for (Index i = 0; i < numbers.cols(); ++i) {
    Eigen::Matrix2d a;
    a << numbers(0, i), numbers(1, i), numbers(1, i), numbers(2, i);
    const Eigensystem expected = eigensystem(a);
    EXPECT_EQ(plane_eigensystem(a).values, expected.values) << i;
    EXPECT_EQ(plane_eigensystem(a).vectors, expected.vectors) << i;
    EXPECT_EQ(plane_eigenvalues(a), eigenvalues(a).values) << i;
  }
  EXPECT_EQ(plane_eigenvalues(Eigen::Matrix2d::Zero()), Eigen::Vector2d::Zero());
}

}  // namespace
}  // namespace panelcal::internal
