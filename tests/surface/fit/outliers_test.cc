// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/outliers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/surface/fit/simulated_warp.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::probed_lattice;
using test::SimulatedWarp;
using ::testing::HasSubstr;
using Points = std::vector<ProbePoint>;

Points warped(Random& random, int n_columns, int n_rows) {
  const SimulatedWarp warp(random, 1);
  return probed_lattice(random, warp, n_columns, n_rows);
}

std::set<std::size_t> called_outliers(const SoundSurface& surface) {
  std::set<std::size_t> out;
  for (const SurfaceOutlier& outlier : surface.outliers) out.insert(outlier.i_point);
  return out;
}

TEST(SurfaceOutliers, NamesAWildProbe) {
  Random random(21);
  Points points = warped(random, 8, 7);
  points[8 * 4 + 3].measured.height = points[8 * 4 + 3].measured.height + mm(0.05);
  const auto found = fit_without_outliers(points, SurfaceModel::GaussianProcess);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(called_outliers(*found), std::set<std::size_t>{8 * 4 + 3});
  EXPECT_THAT(found->outliers[0].text(), HasSubstr("column 3 row 4"));
  EXPECT_THAT(found->outliers[0].text(), HasSubstr("mm above"));
  EXPECT_EQ(found->kept.size(), points.size() - 1);
  EXPECT_TRUE(std::ranges::is_sorted(found->kept));
}

TEST(SurfaceOutliers, FindsManyOfAllSizesAndNoOther) {
  Random random(22);
  Points points = warped(random, 10, 12);
  std::set<std::size_t> wild;
  while (wild.size() < 18) wild.insert(static_cast<std::size_t>(random.uniform(0, 120)));
  for (const std::size_t i : wild) {
    const double sign = random.uniform() < 0.5 ? -1 : 1;
    points[i].measured.height = points[i].measured.height + sign * mm(random.uniform(0.1, 2));
  }
  const auto found = fit_without_outliers(points, SurfaceModel::GaussianProcess);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(called_outliers(*found), wild);
  EXPECT_LT(found->fit.noise_factor(), 1.5);
}

TEST(SurfaceOutliers, FindsAFewAmongManyProbes) {
  Random random(24);
  Points points = warped(random, 27, 25);
  ASSERT_GT(points.size(), kMostProbes);
  std::set<std::size_t> wild;
  while (wild.size() < 6) wild.insert(static_cast<std::size_t>(random.uniform(0, 675)));
  for (const std::size_t i : wild) {
    points[i].measured.height = points[i].measured.height + mm(random.uniform(0.03, 1));
  }
  const auto found = fit_without_outliers(points, SurfaceModel::ThinPlate);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(called_outliers(*found), wild);
  EXPECT_EQ(found->kept.size(), points.size() - wild.size());
  // A number that is not finite among them does no harm.
  points[300].place = position_mm<frame::Nominal>(std::numeric_limits<double>::quiet_NaN(), 0);
  EXPECT_THAT(fit_without_outliers(points, SurfaceModel::ThinPlate),
              FailsWith(Code::GridInvalid, "column 3 row 11"));
}

TEST(SurfaceOutliers, NamesAWildNodeOfALargeGrid) {
  Random random(27);
  Points points = warped(random, 60, 70);
  const auto good = fit_without_outliers(points, SurfaceModel::Bilinear);
  ASSERT_TRUE(good) << good.error().text();
  EXPECT_EQ(good->kept.size(), points.size());
  points[60 * 41 + 17].measured.height = points[60 * 41 + 17].measured.height - mm(0.05);
  for (const SurfaceModel model : {SurfaceModel::Bilinear, SurfaceModel::MonotoneBicubic}) {
    EXPECT_THAT(fit_without_outliers(points, model),
                FailsWith(Code::GridInvalid, "column 17 row 41"));
  }
}

TEST(SurfaceOutliers, JudgesAPlaneOfFewProbes) {
  Random random(23);
  const auto tilted = [](const Eigen::Vector2d& p_mm) { return 1.6 + 1e-3 * p_mm.x(); };
  Points points = probed_lattice(random, tilted, 3, 3);
  points[5].measured.height = points[5].measured.height - mm(0.3);
  points[5].name.clear();
  const auto found = fit_without_outliers(points, SurfaceModel::Plane);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(called_outliers(*found), std::set<std::size_t>{5});
  EXPECT_THAT(found->outliers[0].text(), HasSubstr("(150.000, 0.000)"));
}

TEST(SurfaceOutliers, RefusesProbesThatScatterFarMoreThanTheySay) {
  Random random(26);
  const auto flat = [](const Eigen::Vector2d&) { return 1.6; };
  Points points = probed_lattice(random, flat, 5, 5, 0.1);
  for (ProbePoint& point : points) point.measured.sigma = mm(0.001);
  EXPECT_THAT(fit_without_outliers(points, SurfaceModel::Plane),
              FailsWith(Code::SurfaceOutOfTolerance));
}

TEST(SurfaceOutliers, SetsNoneOfTooFewAside) {
  const auto tilted = [](const Eigen::Vector2d& p_mm) { return 1.6 + 1e-3 * p_mm.x(); };
  for (const std::size_t n : {3U, 4U, 5U, 6U}) {
    Random random(29);
    Points points = probed_lattice(random, tilted, 3, 2);
    // Three in one line are no surface.
    std::swap(points[2], points[4]);
    points.resize(n);
    for (const SurfaceModel model : {SurfaceModel::Plane, SurfaceModel::GaussianProcess}) {
      const auto good = fit_without_outliers(points, model);
      ASSERT_TRUE(good) << good.error().text();
      EXPECT_EQ(good->kept.size(), n);
    }
    points[1].measured.height = points[1].measured.height + mm(2);
    const auto found = fit_without_outliers(points, SurfaceModel::Plane);
    if (n == 3) {
      // Any three make a plane.
      EXPECT_TRUE(found);
    } else if (n < 6) {
      EXPECT_THAT(found, FailsWith(Code::SurfaceOutOfTolerance, fmt::format("1 of {} probes", n)));
      EXPECT_THAT(found.error().text(), HasSubstr(" 0"));
    } else {
      ASSERT_TRUE(found) << found.error().text();
      EXPECT_EQ(called_outliers(*found), std::set<std::size_t>{1});
    }
  }
}

double bowed_mm(const Eigen::Vector2d& p_mm) {
  return 1.6 + 2e-6 * p_mm.squaredNorm() - 1e-6 * p_mm.x() * p_mm.y();
}

TEST(SurfaceOutliers, NamesAGrossProbeOfFewByTheOthers) {
  Random random(31);
  Points points = probed_lattice(random, bowed_mm, 4, 3);
  const auto good = fit_without_outliers(points, SurfaceModel::GaussianProcess);
  ASSERT_TRUE(good) << good.error().text();
  EXPECT_TRUE(good->outliers.empty());
  EXPECT_EQ(good->doubt, "");
  points[5].measured.height = points[5].measured.height + mm(1.5);
  const auto found = fit_without_outliers(points, SurfaceModel::GaussianProcess);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(called_outliers(*found), std::set<std::size_t>{5});
  EXPECT_NEAR(found->outliers[0].deviation.in_mm(), 1.5, 0.1);
  EXPECT_THAT(found->doubt, HasSubstr("column 1 row 1, left out"));
}

/// Nine probes of 3 um, 100 mm apart; the height of the middle about the flat others.
Points dome_of_nine(double height_mm) {
  Random random(33);
  const auto flat = [](const Eigen::Vector2d&) { return 1.6; };
  Points points = probed_lattice(random, flat, 3, 3, 0.003);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].name = fmt::format("probe {}", i);
    points[i].place =
        position_mm<frame::Nominal>(100 * static_cast<double>(i % 3), 100 * std::floor(i / 3));
  }
  points[4].measured.height = points[4].measured.height + mm(height_mm);
  return points;
}

TEST(SurfaceOutliers, SigmaHoldsForADomeAndForAWildProbeAlike) {
  // Clamped along its edges, a board bends as sin(pi x / 200 mm) sin(pi y / 200 mm).
  for (const double height_mm : {0.02, 0.05, 0.06, 0.08, 0.1, 0.2, 0.3, 1.0, -0.1}) {
    const auto found = fit_without_outliers(dome_of_nine(height_mm), SurfaceModel::GaussianProcess);
    ASSERT_TRUE(found) << found.error().text();
    for (const double x_mm : {50.0, 100.0, 130.0}) {
      for (const double y_mm : {40.0, 100.0}) {
        const auto place = position_mm<frame::Nominal>(x_mm, y_mm);
        const HeightEstimate at = found->fit.at(place);
        const double bent_mm = 1.6 + height_mm * std::sin(std::numbers::pi * x_mm / 200) *
                                         std::sin(std::numbers::pi * y_mm / 200);
        const auto off = [&](double truth_mm) {
          return std::abs(at.height.in_mm() - truth_mm) / at.sigma.in_mm();
        };
        EXPECT_LT(off(bent_mm), 3) << height_mm << " mm, at " << x_mm << ", " << y_mm;
        // A smaller one is no more than a bend that is believed.
        if (std::abs(height_mm) >= 0.1) {
          EXPECT_LT(off(1.6), 3) << height_mm << " mm";
        }
      }
    }
    if (std::abs(height_mm) >= 0.1) {
      EXPECT_THAT(found->doubt, HasSubstr("probe 4"));
    }
  }
}

TEST(SurfaceOutliers, AnErrorOfAPossibleBendIsOneOverTheWholeOfIt) {
  const auto found = fit_without_outliers(dome_of_nine(0.3), SurfaceModel::GaussianProcess);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(called_outliers(*found), std::set<std::size_t>{4});
  ASSERT_EQ(found->fit.possible_bends().size(), 1U);
  const PossibleBend& bend = found->fit.possible_bends().front();
  // The four beside it are 100 mm away, and exp(-1 / 2) is 0.6065.
  EXPECT_NEAR(bend.height.in_mm(), 0.3, 0.01);
  EXPECT_NEAR(bend.reach.in_mm(), 100, 1e-9);
  const std::vector places = {position_mm<frame::Nominal>(100, 100),
                              position_mm<frame::Nominal>(200, 100)};
  const Eigen::MatrixXd with = found->fit.covariance_mm2(places);
  const Eigen::MatrixXd without = found->fit.with({}).covariance_mm2(places);
  const double variance_mm2 = bend.height.in_mm() * bend.height.in_mm();
  EXPECT_NEAR(with(0, 0) - without(0, 0), variance_mm2, 1e-9);
  EXPECT_NEAR(with(0, 1) - without(0, 1), 0.6065 * variance_mm2, 1e-5);
  const double sigma_mm = found->fit.at(places[1]).sigma.in_mm();
  EXPECT_NEAR(sigma_mm * sigma_mm, with(1, 1), 1e-9);
}

TEST(SurfaceOutliers, APlaneOfFewProbesHasTheBendThatItLeavesOut) {
  const auto found = fit_without_outliers(dome_of_nine(0.1), SurfaceModel::Plane);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(called_outliers(*found), std::set<std::size_t>{4});
  EXPECT_GT(found->fit.at(position_mm<frame::Nominal>(100, 100)).sigma, um(90));
}

TEST(SurfaceOutliers, SaysWhereFewCannotTellAWildProbeFromABend) {
  // The middle of nine probes: the top of a dome, or a chip below the tip.
  Random random(32);
  Points points = probed_lattice(random, bowed_mm, 3, 3);
  points[4].measured.height = points[4].measured.height + mm(0.8);
  const auto found = fit_without_outliers(points, SurfaceModel::GaussianProcess);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_TRUE(found->outliers.empty());
  EXPECT_THAT(found->doubt, HasSubstr("9 probes cannot tell a wild one"));
  EXPECT_THAT(found->doubt, HasSubstr("column 1 row 1"));
  // Either may be right, and sigma says so.
  EXPECT_GT(found->fit.at(position_mm<frame::Nominal>(60, 60)).sigma, um(20));
}

/// Three corners of a square of 100 mm by turns, 2 um of scatter; heights of a plane and
/// of a scatter of known size.
Points three_places(std::size_t n_probes) {
  constexpr double kScatter_mm[] = {0.001, -0.001, 0.0, 0.002};
  Points points;
  for (std::size_t i = 0; i < n_probes; ++i) {
    ProbePoint point;
    point.place = position_mm<frame::Nominal>(i % 3 == 1 ? 100 : 0, i % 3 == 2 ? 100 : 0);
    const Eigen::Vector2d p_mm = point.place.in_mm();
    point.measured = {mm(1.6 + 1e-4 * p_mm.x() + 2e-4 * p_mm.y() + kScatter_mm[i / 3 % 4]), um(2)};
    point.name = fmt::format("probe {}", i);
    points.push_back(point);
  }
  return points;
}

TEST(SurfaceOutliers, RepeatedProbesOfThreePlacesAreTheirPlane) {
  for (const SurfaceModel model :
       {SurfaceModel::Plane, SurfaceModel::ThinPlate, SurfaceModel::GaussianProcess}) {
    for (const std::size_t n : {6U, 12U, 24U}) {
      const auto found = fit_without_outliers(three_places(n), model);
      ASSERT_TRUE(found) << found.error().text();
      EXPECT_TRUE(found->outliers.empty());
      const auto corner = found->fit.at(position_mm<frame::Nominal>(0, 0));
      // The mean of n / 3 readings of 2 um, of scatters whose mean is 0.5 um of each four.
      const auto n_each = static_cast<double>(n) / 3;
      EXPECT_NEAR(corner.height.in_mm(), 1.6 + (n == 6 ? 0 : 0.0005), 1e-9) << n;
      EXPECT_NEAR(corner.sigma.in_mm(), 0.002 / std::sqrt(n_each), 1e-9) << n;
      if (model != SurfaceModel::Plane) {
        EXPECT_THAT(found->doubt, HasSubstr(fmt::format("{} probes at three places", n)));
        EXPECT_THAT(found->fit.shape().strength_mm2, 0);
      }
    }
  }
}

TEST(SurfaceOutliers, RepeatedProbesOfThreePlacesThatContradictEachOtherWidenSigma) {
  Points points = three_places(12);
  for (ProbePoint& point : points) point.measured.sigma = um(0.3);
  const auto found = fit_without_outliers(points, SurfaceModel::GaussianProcess);
  ASSERT_TRUE(found) << found.error().text();
  // They scatter by 1.3 um about their means; no bending explains it.
  EXPECT_GT(found->fit.at(position_mm<frame::Nominal>(0, 0)).sigma, um(0.5));
  EXPECT_LT(found->fit.at(position_mm<frame::Nominal>(50, 50)).sigma, um(3));
}

TEST(SurfaceOutliers, AProbeBesideAWildOneTellsTheHeightThere) {
  Points points = dome_of_nine(0.3);
  const auto wide = fit_without_outliers(points, SurfaceModel::GaussianProcess);
  ASSERT_TRUE(wide) << wide.error().text();
  EXPECT_GT(wide->fit.at(points[4].place).sigma, um(200));
  // Two good ones at the same place, once as the scales of the stage have it.
  points.push_back(points[4]);
  points.back().measured.height = mm(1.601);
  points.push_back(points.back());
  points.back().place = position_mm<frame::Nominal>(100.002, 100);
  points.back().measured.height = mm(1.599);
  const auto found = fit_without_outliers(points, SurfaceModel::GaussianProcess);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(called_outliers(*found), std::set<std::size_t>{4});
  EXPECT_TRUE(found->fit.possible_bends().empty());
  EXPECT_EQ(found->doubt, "");
  const HeightEstimate at = found->fit.at(points[4].place);
  EXPECT_NEAR(at.height.in_mm(), 1.6, 0.006);
  // Two readings of 3 um.
  EXPECT_LT(at.sigma, um(3));
}

TEST(SurfaceOutliers, RepeatedNeighborsOfAWildProbeDoNotShortenTheBendThatItMayShow) {
  Points points = dome_of_nine(0.3);
  points[1].place = position_mm<frame::Nominal>(100, 30);
  for (int i = 0; i < 4; ++i) points.push_back(points[1]);
  const auto found = fit_without_outliers(points, SurfaceModel::GaussianProcess);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(called_outliers(*found), std::set<std::size_t>{4});
  ASSERT_EQ(found->fit.possible_bends().size(), 1U);
  // One place is 70 mm away, however often it was probed, three are 100 mm away.
  EXPECT_NEAR(found->fit.possible_bends().front().reach.in_mm(), 100, 1e-9);
}

TEST(SurfaceOutliers, RefusesOptionsThatMakeNoSense) {
  Random random(30);
  const Points points = warped(random, 4, 4);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const OutlierOptions& options, const char* text) {
    EXPECT_THAT(fit_without_outliers(points, SurfaceModel::Plane, options),
                FailsWith(Code::ConfigValue, text));
  };
  for (const double bad : {nan, -0.1, 0.6, 1e300}) refused({.most = bad}, "outliers");
  for (const double bad : {nan, 0.0, 1.0}) refused({.false_alarm = bad}, "false_alarm");
  for (const double bad : {nan, 0.0}) refused({.most_noise = bad}, "noise");
}

TEST(SurfaceOutliers, SeldomCallsAGoodProbeWild) {
  constexpr int kPanels = 60;
  constexpr double kFalseAlarm = 0.05;
  int n_alarms = 0;
  for (int i = 0; i < kPanels; ++i) {
    Random random = Random(25).fork(static_cast<std::uint64_t>(i));
    const Points points = warped(random, 5, 5);
    const auto found =
        fit_without_outliers(points, SurfaceModel::ThinPlate, {.false_alarm = kFalseAlarm});
    ASSERT_TRUE(found) << found.error().text();
    n_alarms += found->outliers.empty() ? 0 : 1;
  }
  // 3 are to be expected; 9 or more come up once in 500 times.
  EXPECT_LE(n_alarms, 8);
}

}  // namespace
}  // namespace panelcal
