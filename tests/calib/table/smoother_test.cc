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
        processes(internal::all_waves(basis)),
        about(internal::table_start(data, basis)),
        used(all_of(data)),
        system(data, used, basis, about),
        open(internal::find_open_modes(basis, system.normal(), 0.01)) {}

  Smoother smoother(const TableWaves& waves) const {
    return {waves, basis, system, open, about.table_mm};
  }
  const TableWaves& most_likely() const {
    return *internal::most_likely(processes, basis, system, open, about.table_mm).value().waves;
  }

  static std::vector<std::size_t> all_of(const TableData& data) {
    std::vector<std::size_t> all(data.seen.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
  }

  TableBasis basis;
  std::vector<TableWaves> processes;
  internal::TableState about;
  std::vector<std::size_t> used;
  TableSystem system;
  OpenModes open;
};

Eigen::Vector2d flat(const Eigen::Vector2d&) {
  return {0, 0};
}
Eigen::Vector2d slow_waves(const Eigen::Vector2d& c) {
  return {0.010 * std::sin(c.x() / 70 + 1), 0.008 * std::sin(c.y() / 80 + 2)};
}
/// As short as steps of 37.5 mm can follow.
Eigen::Vector2d short_waves(const Eigen::Vector2d& c) {
  return {0.010 * std::sin(c.x() * 2 * std::numbers::pi / 90) * std::cos(c.y() / 20),
          0.008 * std::sin(c.y() * 2 * std::numbers::pi / 90) * std::cos(c.x() / 20)};
}

/// A table that may not bend is the same table in every process, so no likelihood may tell them
/// apart: with open modes that bend, that do not, and mixtures.
TEST(TableSmoother, ProcessesAreAsLikelyWhereNothingMayBend) {
  const std::vector<Looks> cases = {{true, {kAsItIs}},
                                    {false, {kAsItIs, kTurned, kShifted}},
                                    {false, {kAsItIs, kTurned}},
                                    {false, {kAsItIs, kShifted}}};
  Eigen::Index most_open = 0;
  for (const Looks& looks : cases) {
    const Equations equations(seen(looks, slow_waves, 3));
    SCOPED_TRACE(testing::Message() << equations.open.combinations.cols() << " open modes");
    most_open = std::max(most_open, equations.open.combinations.cols());
    const auto stiff = [&](const TableWaves& waves) {
      const double information = equations.system.normal().diagonal().mean();
      const double longest = waves.energies[TableWaves::kUnbent];
      return equations.smoother(waves).badness(1e9 * information / longest);
    };
    const double of_plate = stiff(equations.processes.front());
    ASSERT_TRUE(std::isfinite(of_plate));
    for (const TableWaves& waves : equations.processes) {
      EXPECT_NEAR(stiff(waves), of_plate, 0.01) << waves.length;
    }
  }
  EXPECT_GT(most_open, 4);
}

/// Each wave in each coordinate at the places that are looked at, a column each.
Eigen::MatrixXd seen_waves(const Equations& equations,
                           const TableData& data,
                           const TableWaves& waves) {
  const auto n = 2 * static_cast<Eigen::Index>(data.seen.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(n, waves.size());
  for (std::size_t i = 0; i < data.seen.size(); ++i) {
    const auto& view = data.views[data.seen[i].i_view];
    const auto local = internal::local_of(equations.basis.grid, view.axis_at.in_mm());
    for (Eigen::Index wave = 0; wave < waves.shapes.cols(); ++wave) {
      double value = 0;
      for (std::size_t k = 0; k < 16; ++k) {
        value += local.weight[k] * waves.shapes(local.index[k], wave);
      }
      const auto at = 2 * static_cast<Eigen::Index>(i);
      out(at, 2 * wave) = out(at + 1, 2 * wave + 1) = value;
    }
  }
  return out;
}

/// The observations' own covariance, restricted to what is orthogonal to all that is free (shift
/// and turn of the pose among it), gives the same ratios of likelihoods.
TEST(TableSmoother, LikelihoodIsThatOfTheObservations) {
  const TableData data = seen({true, {kAsItIs}}, slow_waves, 4);
  const Equations equations(data);
  const auto n = 2 * static_cast<Eigen::Index>(data.seen.size());
  const Eigen::Index n_unbent = 2 * TableWaves::kUnbent;
  Eigen::VectorXd y(n);
  for (std::size_t i = 0; i < data.seen.size(); ++i) {
    y.segment<2>(2 * static_cast<Eigen::Index>(i)) =
        internal::table_residual_mm(data, equations.basis, equations.about, data.seen[i]);
  }
  const double noise_mm2 = data.seen.front().seen.cov(0, 0);
  const auto difference = [&](const TableWaves& waves, double weight) {
    const Eigen::MatrixXd columns = seen_waves(equations, data, waves);
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns.leftCols(n_unbent));
    const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(n, n);
    const Eigen::MatrixXd contrasts = q.rightCols(n - n_unbent);
    const Eigen::MatrixXd bent =
        contrasts.transpose() * columns.rightCols(columns.cols() - n_unbent);
    Eigen::VectorXd variances(bent.cols());
    for (Eigen::Index k = 0; k < variances.size(); ++k) {
      variances[k] = 1 / (weight * waves.energies[TableWaves::kUnbent + k / 2]);
    }
    Eigen::MatrixXd cov = bent * variances.asDiagonal() * bent.transpose();
    cov.diagonal().array() += noise_mm2;
    const Eigen::VectorXd left = contrasts.transpose() * y;
    const Eigen::LLT<Eigen::MatrixXd> llt(cov);
    const double log_determinant =
        2 * Eigen::MatrixXd(llt.matrixL()).diagonal().array().log().sum();
    return log_determinant + left.dot(llt.solve(left)) - equations.smoother(waves).badness(weight);
  };
  const TableWaves& plate = equations.processes.front();
  const double of_plate = difference(plate, 1e3);
  EXPECT_NEAR(difference(plate, 1e5), of_plate, 0.05);
  EXPECT_NEAR(difference(internal::matern_waves(equations.basis, 0.8), 1e3), of_plate, 0.05);
  EXPECT_NEAR(difference(internal::matern_waves(equations.basis, 0.2), 1e4), of_plate, 0.05);
}

TEST(TableSmoother, ProcessIsAsSmoothAsTheTable) {
  const Looks three{true, {kAsItIs, kTurned, kShifted}};
  const Equations of_waves(seen(three, slow_waves, 8));
  EXPECT_EQ(of_waves.most_likely().process, TableProcess::Matern);
  EXPECT_GE(of_waves.most_likely().length, 0.4);
  const Equations of_noise(seen(three, short_waves, 7));
  EXPECT_LE(of_noise.most_likely().length, 0.2);
}

TEST(TableSmoother, AFlatTableStaysFlatInEveryProcess) {
  const Looks three{true, {kAsItIs, kTurned, kShifted}};
  for (std::uint64_t seed = 10; seed < 15; ++seed) {
    const Equations equations(seen(three, flat, seed));
    const auto best = internal::most_likely(equations.processes,
                                            equations.basis,
                                            equations.system,
                                            equations.open,
                                            equations.about.table_mm);
    ASSERT_TRUE(best);
    const auto solution = equations.smoother(*best->waves).solve(best->weight);
    ASSERT_TRUE(solution);
    EXPECT_LT(solution->parameters, 25) << seed;
    EXPECT_LT(solution->table_mm.cwiseAbs().maxCoeff(), 0.001) << seed;
  }
}

}  // namespace
}  // namespace panelcal
