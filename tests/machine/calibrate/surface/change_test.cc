// SPDX-License-Identifier: Apache-2.0
// Figures of a table's surface, and what changed from one map to the next.
#include "machine/calibrate/surface/change.h"

#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/statistics/random.h"
#include "machine/calibrate/surface/figures.h"
#include "machine/calibrate/surface/record.h"
#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::HasSubstr;

constexpr double kSigma_mm = 0.003;
const SurfaceArea kArea = {{200, 150}, {100, 75}};

using Truth = std::function<double(double u, double v)>;

double flat(double /*u*/, double /*v*/) {
  return 0.4;
}

/// A map of 7 x 6 probes over the area.
StoredMap map_of(const Truth& height_mm,
                 std::uint64_t seed,
                 SurfaceModel model = SurfaceModel::GaussianProcess) {
  Random random(seed);
  std::vector<ProbePoint> points;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 7; ++column) {
      const double u = column / 3.0 - 1, v = row / 2.5 - 1;
      const double read_mm = height_mm(u, v) + kSigma_mm * random.normal();
      points.push_back({position_mm<frame::Nominal>(200 + 100 * u, 150 + 75 * v),
                        {mm(read_mm), mm(kSigma_mm)},
                        fmt::format("column {} row {}", column, row),
                        {}});
    }
  }
  HeightMapOptions options;
  options.model = model;
  auto map = HeightMap::of_probes(points, options);
  EXPECT_TRUE(map) << map.error().text();
  return {std::move(points), *std::move(map), {}, "test"};
}

TEST(SurfaceFigures, AreThoseOfTheSurfaceAndTheirCovarianceIsHonest) {
  const Truth bent = [](double u, double v) {
    return 0.4 + 0.02 * u - 0.03 * v + 0.015 * u * u - 0.01 * v * v + 0.005 * u * v;
  };
  Eigen::VectorXd truth(6);
  truth << 0.4, 0.02, -0.03, 0.015, -0.01, 0.005;
  constexpr int kDraws = 100;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(6);
  double chi_square = 0;
  Eigen::MatrixXd cov;
  for (int i = 0; i < kDraws; ++i) {
    const auto figures = figures_of(map_of(bent, 100 + i).map, kArea);
    ASSERT_TRUE(figures) << figures.error().text();
    const Eigen::VectorXd error = figures->value_mm - truth;
    mean += error / kDraws;
    cov = figures->cov_mm2;
    chi_square += error.dot(cov.llt().solve(error));
  }
  for (int i = 0; i < 6; ++i) {
    EXPECT_LT(std::abs(mean[i]), 4 * std::sqrt(cov(i, i) / kDraws)) << i;
  }
  // Of 600 degrees of freedom, four standard deviations of the sum to either side; bending that
  // is not there but cannot be ruled out makes them rather too small.
  EXPECT_LT(chi_square, 600 + 4 * std::sqrt(2 * 600.0));
  EXPECT_GT(chi_square, 300);
}

TEST(SurfaceFigures, AreRefusedWhereTheMapDoesNotReach) {
  SurfaceArea wide = kArea;
  wide.half_mm.x() = 130;
  EXPECT_THAT(figures_of(map_of(flat, 1).map, wide), FailsWith(Code::GridInvalid));
  EXPECT_THAT(figures_of(map_of(flat, 1, SurfaceModel::Bilinear).map, kArea),
              FailsWith(Code::GridInvalid));
}

TEST(SurfaceChange, SaysHowMuchAndHowSurely) {
  const auto before = map_of(flat, 1);
  const auto after = map_of([](double u, double v) { return flat(u, v) + 0.012 + 0.03 * u; }, 2);
  const auto change = change_between(before, after);
  ASSERT_TRUE(change) << change.error().text();
  // Mean square of 12 um + 30 um u over u = -1, -2/3, ... 1.
  const double truth_mm = std::sqrt(0.012 * 0.012 + 0.03 * 0.03 * 4 / 9);
  EXPECT_NEAR(change->rms_mm.value, truth_mm, 4 * change->rms_mm.sigma);
  EXPECT_LT(change->rms_mm.sigma, kSigma_mm);
  EXPECT_GT(change->rms_mm.sigma, kSigma_mm / 20);
  EXPECT_NEAR(change->greatest_mm.value, 0.042, 4 * change->greatest_mm.sigma);
  EXPECT_NEAR(change->greatest_at_mm.x(), 300, 1);
  EXPECT_THAT(change->greatest_probe, testing::IsEmpty());
  EXPECT_LT(change->difference.tilt.chance, 1e-6);
}

TEST(SurfaceChange, IsKnownOfGridModelsToo) {
  for (const SurfaceModel model : {SurfaceModel::Bilinear, SurfaceModel::MonotoneBicubic}) {
    const auto raised = [](double u, double v) { return flat(u, v) + 0.02; };
    const auto change = change_between(map_of(flat, 1, model), map_of(raised, 2, model));
    ASSERT_TRUE(change) << change.error().text();
    EXPECT_NEAR(change->rms_mm.value, 0.02, 4 * change->rms_mm.sigma);
  }
}

TEST(SurfaceChange, AProbeThatIsLeftOutCountsUnlessItIsKnown) {
  const auto chipped = [](double depth_mm) {
    return [depth_mm](double u, double v) {
      const bool is_there = std::abs(u - 1.0 / 3) < 0.01 && std::abs(v + 0.2) < 0.01;
      return flat(u, v) - (is_there ? depth_mm : 0);
    };
  };
  const auto whole = map_of(flat, 1);
  const auto broken = map_of(chipped(0.2), 2);
  ASSERT_EQ(broken.map.outliers().size(), 1U);
  auto change = change_between(whole, broken);
  ASSERT_TRUE(change) << change.error().text();
  EXPECT_EQ(change->greatest_probe, "column 4 row 2");
  EXPECT_NEAR(change->greatest_mm.value, -0.2, 4 * change->greatest_mm.sigma);
  EXPECT_EQ(change->n_known, 0);
  // The same chip again.
  change = change_between(broken, map_of(chipped(0.2), 3));
  ASSERT_TRUE(change) << change.error().text();
  EXPECT_LT(std::abs(change->greatest_mm.value), 0.02);
  EXPECT_EQ(change->n_known, 1);
  // It grows.
  change = change_between(broken, map_of(chipped(0.3), 4));
  ASSERT_TRUE(change) << change.error().text();
  EXPECT_EQ(change->greatest_probe, "column 4 row 2");
  EXPECT_NEAR(change->greatest_mm.value, -0.1, 4 * change->greatest_mm.sigma);
}

TEST(SurfaceRecord, FiguresComeBackToTheBit) {
  const auto before = map_of(flat, 1);
  const auto after = map_of(flat, 2);
  const auto figures = figures_of(after.map, kArea);
  const auto change = change_between(before, after);
  ASSERT_TRUE(figures && change);
  MachineConfig config;
  config.name = "drill 1";
  const auto draft = surface_draft(config, after, *figures, *change, {});
  ASSERT_TRUE(draft) << draft.error().text();
  EXPECT_EQ(draft->result, map_file_text(after));
  LedgerEntry entry;
  entry.record = draft->record;
  const auto back = figures_of(entry);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->value_mm, figures->value_mm);
  EXPECT_EQ(back->cov_mm2, figures->cov_mm2);
  EXPECT_EQ(back->area, kArea);
  // An entry of another kind, or of another program.
  entry.record.parameters[0].name = "scale_x";
  EXPECT_FALSE(figures_of(entry));
  entry.record.covariance.reset();
  EXPECT_FALSE(figures_of(entry));
}

TEST(SurfaceFigures, TheReportSaysTiltAsASlopeToo) {
  SurfaceFigures figures;
  figures.area = {{0, 0}, {100, 50}};
  figures.value_mm << 0.2, 0.010, -0.004, 0, 0, 0;
  figures.cov_mm2 = 1e-6 * SurfaceFigures{}.cov_mm2.Identity();
  EXPECT_THAT(report(figures), HasSubstr("tilt x     +10.0 um +- 1.0 (+100.0 um/m)\n"));
  EXPECT_THAT(report(figures), HasSubstr("tilt y     -4.0 um +- 1.0 (-80.0 um/m)\n"));
}

}  // namespace
}  // namespace panelcal
