// SPDX-License-Identifier: Apache-2.0
// Does the table fit err as it says? Seeded draws around known truth.
#include <cmath>
#include <iostream>

#include "calib/correction/table_basis.h"
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gmock/gmock.h>

#include "tests/calib/table/simulated_table.h"

namespace panelcal {
namespace {

constexpr int kTrials = 40;
constexpr double kNoise_mm = 0.001;

/// A warp of random waves, 300 to 1000 mm long, with 30 um at its worst or so.
test::TableError random_warp(Random& random) {
  struct Wave {
    Eigen::Vector2d size_mm, per_mm;
    double phase_rad;
  };
  std::vector<Wave> waves;
  for (int i = 0; i < 6; ++i) {
    Wave wave;
    wave.size_mm.x() = 0.006 * random.normal();
    wave.size_mm.y() = 0.006 * random.normal();
    const double length_mm = random.uniform(300, 1000);
    const double toward_rad = random.uniform(0, 7);
    wave.per_mm = 6.283 / length_mm * Eigen::Vector2d(std::cos(toward_rad), std::sin(toward_rad));
    wave.phase_rad = random.uniform(0, 7);
    waves.push_back(wave);
  }
  return [waves](const Eigen::Vector2d& c) {
    Eigen::Vector2d sum(0, 0);
    for (const Wave& w : waves) sum += w.size_mm * std::sin(w.per_mm.dot(c) + w.phase_rad);
    return sum;
  };
}

/// An error by the map's convention: its covariance knows no shift, and a turn only so that the x
/// axis is straight. By the means over a square of 101 x 101 places.
test::TableError settled(const test::TableError& error, double low_mm, double high_mm) {
  constexpr int kSide = 101;
  Eigen::Vector2d mean(0, 0);
  double slope = 0;
  double squares = 0;
  const double middle_mm = (low_mm + high_mm) / 2;
  for (int i = 0; i < kSide * kSide; ++i) {
    // Middles of equal cells, so that the mean is the integral's.
    const Eigen::Vector2d c(low_mm + (high_mm - low_mm) * (i % kSide + 0.5) / kSide,
                            low_mm + (high_mm - low_mm) * (i / kSide + 0.5) / kSide);
    mean += error(c) / (kSide * kSide);
    slope += error(c).y() * (c.x() - middle_mm);
    squares += (c.x() - middle_mm) * (c.x() - middle_mm);
  }
  const double turn = slope / squares;
  return [=](const Eigen::Vector2d& c) {
    const Eigen::Vector2d off = c - Eigen::Vector2d(middle_mm, middle_mm);
    return Eigen::Vector2d(error(c) - mean - turn * Eigen::Vector2d(-off.y(), off.x()));
  };
}

struct Outcome {
  double chi_square = 0;  ///< of the map's error, per degree of freedom, mean over places
  double rms_mm = 0;      ///< of the vector, over all draws
  double worst_rms_mm = 0;
  double held_out_rms_mm = 0;
  double residual_chi_square = 0;  ///< per degree of freedom
  double marginal_chi_square = 0;  ///< per observation that is not a parameter
};

using WarpMaker = std::function<test::TableError(Random&)>;

/// A draw of the process that the fit takes warps for: bent with the energy of a thin plate, and an
/// affine error on top.
test::TableError plate_warp(Random& random) {
  TableGrid grid;
  grid.high_mm = {300, 300};
  grid.nx = grid.ny = 10;
  static const internal::TableBasis basis(grid);
  static const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(basis.bending);
  constexpr double kStrength_mm = 0.1;
  const Eigen::Index n = grid.n_coefficients();
  std::vector<Eigen::Vector2d> coefficients_mm(static_cast<std::size_t>(n));
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::VectorXd one = Eigen::VectorXd::Zero(n);
    for (Eigen::Index k = 3; k < n; ++k) {
      one += kStrength_mm * random.normal() / std::sqrt(modes.eigenvalues()[k]) *
             modes.eigenvectors().col(k);
    }
    for (Eigen::Index i = 0; i < n; ++i)
      coefficients_mm[static_cast<std::size_t>(i)][axis] = one[i];
  }
  const double scale = 1e-4 * random.normal();
  const double skew = 1e-4 * random.normal();
  const TableMap bent(grid, coefficients_mm);
  return [=](const Eigen::Vector2d& c) {
    return Eigen::Vector2d(bent.error_mm(position_mm<frame::Machine>(c)) +
                           Eigen::Vector2d(scale * c.x() + skew * c.y(), -scale * c.y()));
  };
}

Outcome run(double low_mm,
            double high_mm,
            const std::vector<PlatePose>& poses,
            bool is_certified,
            double pitch_mm,
            std::uint64_t seed,
            const WarpMaker& make_warp = random_warp) {
  Outcome out;
  int n = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Random random(seed + static_cast<std::uint64_t>(trial));
    const test::TableError warp = make_warp(random);
    const auto plate =
        test::simulated_plate(15, pitch_mm, is_certified, is_certified ? 0 : 0.005, random);
    TableData data;
    for (const PlatePose& pose : poses) test::look(plate, pose, warp, kNoise_mm, random, data);
    const auto fit = fit_table(data, {});
    if (!fit) {
      ADD_FAILURE() << fit.error().text();
      return out;
    }
    test::TableError truth = settled(warp, low_mm, high_mm);
    if (!is_certified) {
      const double scale = test::compare(TableMap(), truth, low_mm, high_mm).scale;
      truth = [=](const Eigen::Vector2d& c) {
        const double middle_mm = (low_mm + high_mm) / 2;
        const Eigen::Vector2d middle(middle_mm, middle_mm);
        return Eigen::Vector2d(settled(warp, low_mm, high_mm)(c) + scale * (c - middle));
      };
    }
    double squares_mm2 = 0;
    int places = 0;
    for (int i = 0; i < 12 * 12; ++i) {
      const Eigen::Vector2d c(low_mm + (high_mm - low_mm) * (i % 12 + 0.5) / 12,
                              low_mm + (high_mm - low_mm) * (i / 12 + 0.5) / 12);
      const auto at = position_mm<frame::Machine>(c);
      const Eigen::Vector2d off_mm = fit->map.error_mm(at) - truth(c);
      out.chi_square += off_mm.dot(fit->covariance_at(at).llt().solve(off_mm)) / 2;
      squares_mm2 += off_mm.squaredNorm();
      ++places;
      ++n;
    }
    out.worst_rms_mm = std::max(out.worst_rms_mm, std::sqrt(squares_mm2 / places));
    out.rms_mm += squares_mm2;
    out.held_out_rms_mm += *fit->held_out_rms_mm * *fit->held_out_rms_mm / kTrials;
    out.residual_chi_square += fit->chi_square / fit->degrees_of_freedom / kTrials;
    out.marginal_chi_square +=
        fit->chi_square / (2.0 * static_cast<double>(data.seen.size()) - fit->parameters) / kTrials;
  }
  out.chi_square /= n;
  out.rms_mm = std::sqrt(out.rms_mm / n);
  out.held_out_rms_mm = std::sqrt(out.held_out_rms_mm);
  std::cout << "map errs by " << 1e3 * out.rms_mm << " um rms, at worst " << 1e3 * out.worst_rms_mm
            << ", chi square " << out.chi_square << ", of residuals " << out.residual_chi_square
            << " or " << out.marginal_chi_square << ", held out " << 1e3 * out.held_out_rms_mm
            << " um\n";
  return out;
}

TEST(TableFitStatistics, AWarpOfTheAssumedKindIsMissedAsTheCovarianceSays) {
  const Outcome out = run(0, 300, {{0, {150, 150}}}, true, 300.0 / 14, 500, plate_warp);
  EXPECT_GT(out.chi_square, 0.9);
  EXPECT_LT(out.chi_square, 1.1);
  // The detail of a draw that is smoothed away is in the residuals, and their expectation is their
  // number less the trace of H.
  EXPECT_NEAR(out.marginal_chi_square, 1, 0.05);
}

// Waves are smoother than that process where they are short, so less is missed than it says: the
// covariance errs on the safe side, but not by more than the factor 2.

TEST(TableFitStatistics, OfASmoothWarpACertifiedPlateLeavesLittle) {
  const Outcome out = run(0, 300, {{0, {150, 150}}}, true, 300.0 / 14, 100);
  EXPECT_LE(out.worst_rms_mm, 0.0015);
  EXPECT_GT(out.chi_square, 0.5);
  EXPECT_LT(out.chi_square, 1.1);
  EXPECT_NEAR(out.residual_chi_square, 1, 0.05);
}

TEST(TableFitStatistics, OfASmoothWarpAnUnknownPlateLeavesLittle) {
  const Outcome out =
      run(10,
          310,
          {{0, {150, 150}}, {1.5707963267948966, {150, 150}}, {0, {170, 150}}, {0, {150, 170}}},
          false,
          20,
          300);
  EXPECT_LE(out.rms_mm, 0.0015);
  EXPECT_GT(out.chi_square, 0.5);
  EXPECT_LT(out.chi_square, 1.1);
  EXPECT_NEAR(out.residual_chi_square, 1, 0.05);
}

}  // namespace
}  // namespace panelcal
