// SPDX-License-Identifier: Apache-2.0
#include "calib/table/smoother.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include <gmock/gmock.h>

#include "tests/calib/table/simulated_table.h"

namespace panelcal {
namespace {

using internal::OpenModes;
using internal::Smoother;
using internal::TableBasis;
using internal::TableSystem;
using internal::TableWaves;

constexpr double kPitch_mm = 270.0 / 14;
const PlatePose kAsItIs{0, {140, 150}};
const PlatePose kTurned{std::numbers::pi / 2, {140, 150}};
const PlatePose kShifted{0, {140 + kPitch_mm, 150}};

struct Looks {
  bool is_certified = true;
  std::vector<PlatePose> poses;
};

TableData seen(const Looks& looks, const test::TableError& error, std::uint64_t seed) {
  Random random(seed);
  const auto plate = test::simulated_plate(15, kPitch_mm, looks.is_certified, 0, random);
  TableData data;
  for (const PlatePose& pose : looks.poses) test::look(plate, pose, error, 0.0005, random, data);
  return data;
}

/// The equations of a table's looks, about the poses that they begin with.
struct Equations {
  explicit Equations(const TableData& data)
      : basis({{0, 0}, {300, 300}, 8, 8}),
        waves(basis),
        about(internal::table_start(data, basis)),
        used(all_of(data)),
        system(data, used, basis, about),
        open(internal::find_open_modes(basis, system.normal(), 0.01)),
        smoother(waves, basis, system, open, about.table_mm) {}

  static std::vector<std::size_t> all_of(const TableData& data) {
    std::vector<std::size_t> all(data.seen.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
  }

  TableBasis basis;
  TableWaves waves;
  internal::TableState about;
  std::vector<std::size_t> used;
  TableSystem system;
  OpenModes open;
  Smoother smoother;
};

Eigen::Vector2d flat(const Eigen::Vector2d&) {
  return {0, 0};
}
Eigen::Vector2d slow_waves(const Eigen::Vector2d& c) {
  return {0.010 * std::sin(c.x() / 70 + 1), 0.008 * std::sin(c.y() / 80 + 2)};
}
/// A kink of a rail has waves of every length.
Eigen::Vector2d kinked(const Eigen::Vector2d& c) {
  return {0.010 * std::abs(c.x() - 131) / 150, 0.006 * std::abs(c.y() - 77) / 150};
}

/// A table that may not bend is the same table in every order, so no likelihood may tell them
/// apart: with open modes that bend, that do not, and mixtures.
TEST(TableSmoother, OrdersAreAsLikelyWhereNothingMayBend) {
  const std::vector<Looks> cases = {{true, {kAsItIs}},
                                    {false, {kAsItIs, kTurned, kShifted}},
                                    {false, {kAsItIs, kTurned}},
                                    {false, {kAsItIs, kShifted}}};
  Eigen::Index most_open = 0;
  for (const Looks& looks : cases) {
    const Equations equations(seen(looks, slow_waves, 3));
    SCOPED_TRACE(testing::Message() << equations.open.combinations.cols() << " open modes");
    most_open = std::max(most_open, equations.open.combinations.cols());
    const auto stiff = [&](double order) {
      const double lowest = equations.waves.energies[TableWaves::kUnbent];
      const double information =
          equations.system.normal().trace() / static_cast<double>(equations.basis.size());
      return equations.smoother.badness({order, 1e9 * information / std::pow(lowest, order)});
    };
    const double of_plate = stiff(1);
    ASSERT_TRUE(std::isfinite(of_plate));
    for (const double order : {1.5, 2.0, 3.0}) EXPECT_NEAR(stiff(order), of_plate, 0.01) << order;
  }
  EXPECT_GT(most_open, 4);
}

/// Looks that have nothing to do with the weight do not change what they say of two weights: the
/// likelihood ratio is that of the observations, computed from their own covariance.
TEST(TableSmoother, LikelihoodIsThatOfTheObservations) {
  const TableData data = seen({true, {kAsItIs}}, slow_waves, 4);
  const Equations equations(data);
  const Eigen::Index n = 2 * static_cast<Eigen::Index>(data.seen.size());
  const Eigen::Index n_unbent = 2 * TableWaves::kUnbent;
  // By hand: y = N a + B b + noise, a and the pose free, b of the prior; restricted to what is
  // orthogonal to N (shift and turn of the pose are among its columns).
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(n, equations.basis.size());
  Eigen::VectorXd y(n);
  for (std::size_t i = 0; i < data.seen.size(); ++i) {
    const auto at = 2 * static_cast<Eigen::Index>(i);
    const auto& view = data.views[data.seen[i].i_view];
    const auto local = internal::local_of(equations.basis.grid, view.axis_at.in_mm());
    for (std::size_t k = 0; k < 16; ++k) {
      design(at, 2 * local.index[k]) = local.weight[k];
      design(at + 1, 2 * local.index[k] + 1) = local.weight[k];
    }
    y.segment<2>(at) =
        internal::table_residual_mm(data, equations.basis, equations.about, data.seen[i]);
  }
  Eigen::MatrixXd in_waves(n, equations.basis.size());
  for (Eigen::Index k = 0; k < equations.waves.shapes.cols(); ++k) {
    for (Eigen::Index c = 0; c < 2; ++c) {
      Eigen::VectorXd wave = Eigen::VectorXd::Zero(equations.basis.size());
      wave(Eigen::seqN(c, equations.waves.shapes.rows(), Eigen::fix<2>)) =
          equations.waves.shapes.col(k);
      in_waves.col(2 * k + c) = design * wave;
    }
  }
  const Eigen::MatrixXd q =
      Eigen::HouseholderQR<Eigen::MatrixXd>(in_waves.leftCols(n_unbent)).householderQ() *
      Eigen::MatrixXd::Identity(n, n);
  const Eigen::MatrixXd contrasts = q.rightCols(n - n_unbent);
  const Eigen::MatrixXd bent =
      contrasts.transpose() * in_waves.rightCols(in_waves.cols() - n_unbent);
  const Eigen::VectorXd left = contrasts.transpose() * y;
  const double noise_mm2 = data.seen.front().seen.cov(0, 0);
  const auto minus_two_log_likelihood = [&](const TableSmoothness& s) {
    Eigen::VectorXd variances(bent.cols());
    for (Eigen::Index k = 0; k < variances.size(); ++k) {
      const double energy = equations.waves.energies[TableWaves::kUnbent + k / 2];
      variances[k] = 1 / (s.weight * std::pow(energy, s.order));
    }
    Eigen::MatrixXd cov = bent * variances.asDiagonal() * bent.transpose();
    cov.diagonal().array() += noise_mm2;
    const Eigen::LLT<Eigen::MatrixXd> llt(cov);
    const double log_determinant =
        2 * Eigen::MatrixXd(llt.matrixL()).diagonal().array().log().sum();
    return log_determinant + left.dot(llt.solve(left));
  };
  const TableSmoothness first{1, 1e3};
  const double of_first = minus_two_log_likelihood(first) - equations.smoother.badness(first);
  for (const TableSmoothness& other :
       {TableSmoothness{1, 1e5}, TableSmoothness{1.5, 1e3}, TableSmoothness{3, 1e4}}) {
    EXPECT_NEAR(minus_two_log_likelihood(other) - equations.smoother.badness(other), of_first, 0.05)
        << other.order << ", " << other.weight;
  }
}

TEST(TableSmoother, OrderIsAsHighAsTheTableIsSmooth) {
  const auto order_of = [](const test::TableError& error, std::uint64_t seed) {
    const Equations equations(seen({true, {kAsItIs, kTurned, kShifted}}, error, seed));
    const auto best = equations.smoother.best(true);
    return best ? best->order : 0;
  };
  EXPECT_LE(order_of(kinked, 7), 1.5);
  EXPECT_GE(order_of(slow_waves, 8), 2);
  // A flat table has no spectrum whose slope could be told.
  for (std::uint64_t seed = 10; seed < 20; ++seed) EXPECT_EQ(order_of(flat, seed), 1) << seed;
}

}  // namespace
}  // namespace panelcal
