// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/fit.h"

#include <cmath>
#include <limits>

#include "surface/control/reference_plane.h"
#include "surface/fit/even_part.h"
#include <Eigen/LU>
#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/surface/fit/simulated_warp.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FailsWith;
using test::probed_lattice;
using test::SimulatedWarp;
using Points = std::vector<ProbePoint>;

constexpr SurfaceModel kModels[] = {
    SurfaceModel::Plane, SurfaceModel::ThinPlate, SurfaceModel::GaussianProcess};

Position<frame::Nominal> at(double x_mm, double y_mm) {
  return position_mm<frame::Nominal>(x_mm, y_mm);
}

SurfaceFit fitted(const Points& points, SurfaceModel model = SurfaceModel::GaussianProcess) {
  auto fit = fit_surface(points, model);
  EXPECT_TRUE(fit) << fit.error().text();
  return *std::move(fit);
}

double tilted_mm(const Vector2d& p_mm) {
  return 1.6 + 1e-3 * p_mm.x() - 2e-3 * p_mm.y();
}

double bowed_mm(const Vector2d& p_mm) {
  return tilted_mm(p_mm) + 2e-6 * p_mm.squaredNorm() - 1e-6 * p_mm.x() * p_mm.y();
}

Points warped(std::uint64_t seed, int kind = 3) {
  Random random(seed);
  const SimulatedWarp warp(random, kind);
  return probed_lattice(random, warp, 7, 6);
}

TEST(SurfaceFit, IsTheReferencePlaneForAPlane) {
  Random random(11);
  const Points points = probed_lattice(random, tilted_mm, 4, 3);
  std::vector<ProbedHeight> probes;
  for (const ProbePoint& point : points) {
    probes.push_back({position_mm<frame::Machine>(point.place.in_mm()), point.measured});
  }
  const ReferencePlane plane = *fit_reference_plane(probes).plane;
  const SurfaceFit fit = fitted(points, SurfaceModel::Plane);
  for (const Vector2d& p_mm : {Vector2d(0, 0), Vector2d(-150, 40), Vector2d(300, 300)}) {
    const HeightEstimate expected = plane.height_at(position_mm<frame::Machine>(p_mm));
    const HeightEstimate found = fit.at(position_mm<frame::Nominal>(p_mm));
    EXPECT_NEAR(found.height.in_mm(), expected.height.in_mm(), 1e-12);
    EXPECT_NEAR(found.sigma.in_mm(), fit.noise_factor() * expected.sigma.in_mm(), 1e-12);
  }
}

TEST(SurfaceFit, TakesBowAndTwistForTrend) {
  Random random(12);
  const SurfaceFit fit = fitted(probed_lattice(random, bowed_mm, 8, 8, 1e-6));
  EXPECT_EQ(fit.n_trend(), 6);
  for (const Vector2d& p_mm : {Vector2d(0, 0), Vector2d(-150, 40), Vector2d(170, 170)}) {
    EXPECT_NEAR(fit.at(position_mm<frame::Nominal>(p_mm)).height.in_mm(), bowed_mm(p_mm), 1e-5);
  }
  // Two rows cannot tell a bow across them.
  EXPECT_EQ(fitted(probed_lattice(random, bowed_mm, 12, 2)).n_trend(), 3);
  EXPECT_EQ(fitted(probed_lattice(random, bowed_mm, 3, 3)).n_trend(), 3);
}

TEST(SurfaceFit, TakesNoBowFromHowLittleTwoRowsAreOff) {
  for (const double jitter_mm : {0.001, 0.1, 1.0}) {
    Random random(20);
    Points points = probed_lattice(random, tilted_mm, 12, 2);
    for (ProbePoint& point : points) {
      const Vector2d p_mm = point.place.in_mm();
      point.place = at(p_mm.x(), p_mm.y() + jitter_mm * random.normal());
    }
    const SurfaceFit fit = fitted(points);
    EXPECT_EQ(fit.n_trend(), 3);
    EXPECT_NEAR(fit.at(at(20, 0)).height.in_mm(), tilted_mm({20, 0}), 0.01);
    EXPECT_LT(fit.at(at(20, 0)).sigma, mm(0.01));
  }
  // A row between them does tell one, and so do probes that scatter unlike each other.
  Random random(20);
  Points points = probed_lattice(random, bowed_mm, 12, 3);
  EXPECT_EQ(fitted(points).n_trend(), 6);
  points[5].measured.sigma = 0.01 * points[5].measured.sigma;
  EXPECT_EQ(fitted(points).n_trend(), 6);
}

TEST(SurfaceFit, ForetellsNothingOfAProbeThatAloneTellsATrend) {
  Random random(27);
  const Points three = {probed_lattice(random, tilted_mm, 2, 2)};
  const SurfaceFit plane = fitted(Points(three.begin(), three.begin() + 3), SurfaceModel::Plane);
  for (const LeftOutProbe& probe : plane.left_out()) EXPECT_FALSE(probe.deviation);
  EXPECT_FALSE(plane.left_out_rms());
  EXPECT_TRUE(fitted(three, SurfaceModel::Plane).left_out_rms());
  // The bow across two rows hangs on a single probe between them.
  Points points = probed_lattice(random, bowed_mm, 7, 2);
  points.push_back(points.back());
  points.back().place = at(0, 0);
  const SurfaceFit bent = fitted(points);
  ASSERT_EQ(bent.n_trend(), 6);
  EXPECT_FALSE(bent.left_out().back().deviation);
  EXPECT_TRUE(bent.left_out().front().deviation);
  EXPECT_TRUE(bent.left_out_rms());
}

TEST(SurfaceFit, KnowsNothingOfPlacesThatAreNone) {
  const Points points = warped(28);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const SurfaceModel model : kModels) {
    const SurfaceFit fit = fitted(points, model);
    EXPECT_FALSE(fit.at(at(nan, 0)).sigma <= mm(1e9));
    for (const double far_mm : {1e5, 1e8, 1e20, 1e160, 1e300}) {
      EXPECT_FALSE(fit.at(at(10, far_mm)).sigma <= fit.at(at(10, 300)).sigma)
          << fit.summary() << " at " << far_mm << " mm";
    }
  }
}

TEST(SurfaceFit, ForetellsAProbeAsIfItHadBeenLeftOut) {
  // A noise factor that is learned is not the same without the probe, so sigmas are compared in
  // units of it. The strength and the length are not, either: of a plane there are none, and
  // exactness shows.
  Points points = warped(13);
  for (ProbePoint& point : points) point.is_sigma_assumed = true;
  const SurfaceFit fit = fitted(points, SurfaceModel::Plane);
  for (const std::size_t i : {std::size_t{0}, std::size_t{17}}) {
    Points others = points;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const SurfaceFit rest = fitted(others, SurfaceModel::Plane);
    const HeightEstimate predicted = rest.at(points[i].place);
    ASSERT_TRUE(fit.left_out()[i].deviation);
    EXPECT_NEAR(fit.left_out()[i].deviation->in_mm(),
                (points[i].measured.height - predicted.height).in_mm(),
                1e-12);
    EXPECT_NEAR(
        fit.left_out()[i].sigma.in_mm() / fit.noise_factor(),
        std::hypot(predicted.sigma.in_mm() / rest.noise_factor(), points[i].measured.sigma.in_mm()),
        1e-12);
  }
}

TEST(SurfaceFit, ForetellsNearlyAsIfTheStrengthHadBeenFittedWithoutTheProbe) {
  const Points points = warped(14);
  for (const SurfaceModel model : {SurfaceModel::ThinPlate, SurfaceModel::GaussianProcess}) {
    const SurfaceFit fit = fitted(points, model);
    for (const std::size_t i : {std::size_t{8}, std::size_t{20}}) {
      Points others = points;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
      const HeightEstimate predicted = fitted(others, model).at(points[i].place);
      const LeftOutProbe& left_out = fit.left_out()[i];
      const Length deviation = points[i].measured.height - predicted.height;
      ASSERT_TRUE(left_out.deviation);
      EXPECT_NEAR(*left_out.deviation / left_out.sigma, deviation / left_out.sigma, 0.5);
    }
  }
}

TEST(SurfaceFit, SaysHowMuchTheProbesScatter) {
  Random random(15);
  const SimulatedWarp warp(random, 1);
  Points points = probed_lattice(random, warp, 10, 12);
  for (ProbePoint& point : points) point.is_sigma_assumed = true;
  const double told = fitted(points).noise_factor();
  EXPECT_NEAR(told, 1, 0.25);
  for (ProbePoint& point : points) point.measured.sigma = 0.1 * point.measured.sigma;
  const SurfaceFit fit = fitted(points);
  EXPECT_NEAR(fit.noise_factor(), 10 * told, 1);
  EXPECT_THAT(fit.summary(), ::testing::HasSubstr("times the sigma of the probes"));
}

TEST(SurfaceFit, TakesAMisfitOfStatedScatterForBending) {
  Random random(31);
  // 3 x 3 probes of 3 um on waves of 40 um.
  const auto wavy = [](const Vector2d& p_mm) {
    return 0.04 * std::cos(p_mm.x() / 48) * std::cos(p_mm.y() / 48);
  };
  const Points points = probed_lattice(random, wavy, 3, 3);
  for (const SurfaceModel model : {SurfaceModel::ThinPlate, SurfaceModel::GaussianProcess}) {
    const SurfaceFit fit = fitted(points, model);
    EXPECT_EQ(fit.noise_factor(), 1) << fit.summary();
    EXPECT_THAT(fit.summary(), ::testing::HasSubstr("the probes scatter as stated"));
  }
  const SurfaceFit process = fitted(points);
  EXPECT_GT(process.at(at(75, 75)).sigma, um(15)) << process.summary();
  // A plane has no room for it but every sigma.
  const SurfaceFit plane = fitted(points, SurfaceModel::Plane);
  EXPECT_GT(plane.shape().unresolved, um(15));
  EXPECT_GT(plane.at(at(0, 0)).sigma, plane.shape().unresolved);
  EXPECT_THAT(plane.summary(), ::testing::HasSubstr("bending that it does not follow"));
  // Probes that scatter as they say leave nothing over.
  EXPECT_EQ(fitted(probed_lattice(random, tilted_mm, 4, 4), SurfaceModel::Plane).shape().unresolved,
            mm(0));
}

TEST(SurfaceFit, HasInSigmaWhatItsShapesDisagreeIn) {
  const Points points = warped(32);
  const SurfaceFit mixed = fitted(points);
  ASSERT_GT(mixed.shapes().size(), 1U);
  const auto place = at(21, -47);
  double height_mm = 0, second_mm2 = 0;
  for (const auto& [shape, weight] : mixed.shapes()) {
    const auto one = fit_surface(points, SurfaceModel::GaussianProcess, shape);
    ASSERT_TRUE(one) << one.error().text();
    const HeightEstimate found = one->at(place);
    height_mm += weight * found.height.in_mm();
    second_mm2 += weight * (found.height.in_mm() * found.height.in_mm() +
                            found.sigma.in_mm() * found.sigma.in_mm());
  }
  EXPECT_NEAR(mixed.at(place).height.in_mm(), height_mm, 1e-9);
  EXPECT_NEAR(mixed.at(place).sigma.in_mm(), std::sqrt(second_mm2 - height_mm * height_mm), 1e-8);
  EXPECT_NEAR(mixed.heights_mm(std::vector{place})[0], height_mm, 1e-9);
}

TEST(SurfaceFit, RefusesSharesThatMakeNoAverage) {
  const Points points = warped(33);
  const SurfaceFit fit = fitted(points);
  const std::vector<ShapeShare> good(fit.shapes().begin(), fit.shapes().end());
  const auto with = [&](const std::vector<ShapeShare>& shapes) {
    return fit_surface(points, SurfaceModel::GaussianProcess, shapes);
  };
  ASSERT_GT(good.size(), 1U);
  EXPECT_TRUE(with(good));
  EXPECT_THAT(with({}), FailsWith(Code::ConfigValue, "0 shapes"));
  std::vector<ShapeShare> bad = good;
  bad[1].weight = -bad[1].weight;
  EXPECT_THAT(with(bad), FailsWith(Code::ConfigValue, "weight"));
  bad = good;
  bad.pop_back();
  EXPECT_THAT(with(bad), FailsWith(Code::ConfigValue, "add up"));
  bad = good;
  bad[1].shape.unresolved = um(3);
  EXPECT_THAT(with(bad), FailsWith(Code::ConfigValue, "unresolved"));
}

TEST(SurfaceFit, MovesAndTurnsWithThePanel) {
  const Points points = warped(16);
  Points moved = points;
  for (ProbePoint& point : moved) {
    const Vector2d p_mm = point.place.in_mm();
    point.place = at(4000 - p_mm.y(), 3000 + p_mm.x());
    point.measured.height = point.measured.height + mm(50);
  }
  for (const SurfaceModel model : kModels) {
    const HeightEstimate here = fitted(points, model).at(at(33, -71));
    const HeightEstimate there = fitted(moved, model).at(at(4071, 3033));
    EXPECT_NEAR(there.height.in_mm() - 50, here.height.in_mm(), 1e-6);
    EXPECT_NEAR(there.sigma.in_mm(), here.sigma.in_mm(), 1e-6);
  }
}

TEST(SurfaceFit, KnowsLessFarAway) {
  const Points points = warped(17);
  for (const SurfaceModel model : kModels) {
    const SurfaceFit fit = fitted(points, model);
    EXPECT_LT(fit.at(at(10, 10)).sigma, fit.at(at(170, 170)).sigma);
    EXPECT_LT(fit.at(at(170, 170)).sigma, fit.at(at(250, 250)).sigma);
  }
}

TEST(SurfaceFit, IsTheSameForOneAndForManyPlaces) {
  const SurfaceFit fit = fitted(warped(18));
  std::vector<Position<frame::Nominal>> places;
  for (int i = 0; i < 600; ++i) places.push_back(at(0.5 * i - 150, 100 - 0.3 * i));
  const std::vector<HeightEstimate> many = fit.at(places);
  ASSERT_EQ(many.size(), places.size());
  for (const std::size_t i :
       {std::size_t{0}, std::size_t{255}, std::size_t{256}, std::size_t{599}}) {
    EXPECT_NEAR(many[i].height.in_mm(), fit.at(places[i]).height.in_mm(), 1e-11);
    EXPECT_NEAR(many[i].sigma.in_mm(), fit.at(places[i]).sigma.in_mm(), 1e-9);
  }
}

TEST(SurfaceFit, IsTheSameToTheBitWhenItsShapeIsGiven) {
  const Points points = warped(20);
  for (const SurfaceModel model : kModels) {
    const SurfaceFit once = fitted(points, model);
    const auto again = fit_surface(points, model, once.shapes());
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(again->summary(), once.summary());
    for (double x_mm = -160; x_mm <= 160; x_mm += 23) {
      EXPECT_EQ(again->at(at(x_mm, 31)).height, once.at(at(x_mm, 31)).height);
      EXPECT_EQ(again->at(at(x_mm, 31)).sigma, once.at(at(x_mm, 31)).sigma);
    }
  }
}

TEST(SurfaceFit, KnowsHowItsErrorsHangTogether) {
  const std::vector<Position<frame::Nominal>> places = {
      at(0, 0), at(8, -3), at(-140, 120), at(150, 150)};
  for (const SurfaceModel model : kModels) {
    // Bending that a plane does not follow is in the diagonal alone.
    Random random(21);
    const bool is_plane = model == SurfaceModel::Plane;
    const SurfaceFit fit =
        fitted(is_plane ? probed_lattice(random, tilted_mm, 7, 6) : warped(21), model);
    const Eigen::MatrixXd cov_mm2 = fit.covariance_mm2(places);
    for (Eigen::Index i = 0; i < cov_mm2.rows(); ++i) {
      const double sigma_mm = fit.at(places[static_cast<std::size_t>(i)]).sigma.in_mm();
      EXPECT_NEAR(cov_mm2(i, i), sigma_mm * sigma_mm, 1e-9 * sigma_mm * sigma_mm);
      for (Eigen::Index j = 0; j < i; ++j) EXPECT_EQ(cov_mm2(i, j), cov_mm2(j, i));
    }
    // Neighbours err alike, the corners of a panel do not.
    const Eigen::VectorXd sigma_mm = cov_mm2.diagonal().cwiseSqrt();
    EXPECT_GT(cov_mm2(0, 1) / (sigma_mm[0] * sigma_mm[1]), 0.8);
    EXPECT_LT(cov_mm2(2, 3) / (sigma_mm[2] * sigma_mm[3]), 0.5);
  }
}

TEST(SurfaceFit, CovarianceOfAPlaneIsThatOfLeastSquares) {
  Points points = warped(22);
  SurfaceShape shape;
  shape.noise_factor = 2;
  const auto fit = fit_surface(points, SurfaceModel::Plane, shape);
  ASSERT_TRUE(fit) << fit.error().text();
  Eigen::MatrixXd a(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector2d p_mm = points[i].place.in_mm();
    a.row(static_cast<Eigen::Index>(i)) << 1, p_mm.x(), p_mm.y();
  }
  const double sigma_mm = 2 * points[0].measured.sigma.in_mm();
  const Eigen::Matrix3d cov = sigma_mm * sigma_mm * (a.transpose() * a).inverse();
  const Eigen::Vector3d one(1, 20, -70), other(1, -130, 44);
  const std::vector<Position<frame::Nominal>> places = {at(20, -70), at(-130, 44)};
  EXPECT_NEAR(fit->covariance_mm2(places)(0, 1), one.dot(cov * other), 1e-14);
  EXPECT_NEAR(fit->at(places[0]).sigma.in_mm(), std::sqrt(one.dot(cov * one)), 1e-12);
}

TEST(SurfaceFit, RefusesShapesThatMakeNoSurface) {
  const Points points = warped(23);
  const auto with = [&](SurfaceModel model, const SurfaceShape& shape) {
    return fit_surface(points, model, shape);
  };
  const SurfaceShape good = fitted(points, SurfaceModel::GaussianProcess).shape();
  EXPECT_THAT(with(SurfaceModel::Plane, good), FailsWith(Code::ConfigValue, "kernel"));
  SurfaceShape bad = good;
  bad.length = mm(0);
  EXPECT_THAT(with(SurfaceModel::GaussianProcess, bad), FailsWith(Code::ConfigValue, "length"));
  bad = good;
  bad.strength_mm2 = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(with(SurfaceModel::GaussianProcess, bad), FailsWith(Code::ConfigValue, "strength"));
  bad = good;
  bad.n_trend = 4;
  EXPECT_THAT(with(SurfaceModel::GaussianProcess, bad), FailsWith(Code::ConfigValue, "trend"));
}

/// A part tells the shape, all of them the surface: sigma falls as it would if all told both.
TEST(SurfaceFit, OfManyProbesKnowsMoreThanOfThePartThatTellsItsShape) {
  Random random(20);
  const SimulatedWarp warp(random, 1);
  Points points = probed_lattice(random, warp, 25, 25);
  for (ProbePoint& point : points) point.is_sigma_assumed = true;
  ASSERT_GT(points.size(), kMostProbes);
  const auto all = fit_surface(points, SurfaceModel::ThinPlate);
  ASSERT_TRUE(all) << all.error().text();
  const auto part = fit_surface(internal::even_part(points, kMostProbes), SurfaceModel::ThinPlate);
  ASSERT_TRUE(part) << part.error().text();
  EXPECT_EQ(all->shape().strength_mm2, part->shape().strength_mm2);
  EXPECT_NE(all->noise_factor(), part->noise_factor());
  EXPECT_NEAR(all->noise_factor(), part->noise_factor(), 0.1);
  ASSERT_EQ(all->left_out().size(), points.size());
  int n_within_95 = 0;
  constexpr int kPlaces = 500;
  for (int i = 0; i < kPlaces; ++i) {
    const auto place =
        position_mm<frame::Nominal>(random.uniform(-140, 140), random.uniform(-140, 140));
    const HeightEstimate found = all->at(place);
    EXPECT_LT(found.sigma / all->noise_factor(), part->at(place).sigma / part->noise_factor());
    const double error = (found.height.in_mm() - warp(place.in_mm())) / found.sigma.in_mm();
    n_within_95 += std::abs(error) < 1.96 ? 1 : 0;
  }
  // Errors of one panel hang together: coverage itself is the slow test's.
  EXPECT_GT(n_within_95, 0.85 * kPlaces);
  // Solved again, of the shape that was found.
  const auto again = fit_surface(points, SurfaceModel::ThinPlate, all->shape());
  ASSERT_TRUE(again) << again.error().text();
  const auto place = position_mm<frame::Nominal>(12.5, -34.5);
  EXPECT_EQ(again->at(place).height, all->at(place).height);
  EXPECT_EQ(again->at(place).sigma, all->at(place).sigma);
}

/// Squares of what is finite may not be: the crash of a height of -1e308 mm.
TEST(SurfaceFit, RefusesNumbersThatNoBoardHas) {
  const Points good = warped(13);
  const auto refuses = [&](auto change) {
    for (const SurfaceModel model : kModels) {
      Points points = good;
      change(points[8]);
      EXPECT_THAT(fit_surface(points, model), FailsWith(Code::GridInvalid, points[8].name));
    }
  };
  for (const double height_mm : {-1e308, 1.1e6, std::numeric_limits<double>::quiet_NaN()}) {
    refuses([&](ProbePoint& point) { point.measured.height = mm(height_mm); });
    refuses([&](ProbePoint& point) { point.place = at(3, height_mm); });
    refuses([&](ProbePoint& point) { point.measured.sigma = mm(height_mm); });
  }
  for (const double sigma_mm : {0.0, 1e-160, 9e-10}) {
    refuses([&](ProbePoint& point) { point.measured.sigma = mm(sigma_mm); });
  }
}

/// The edges of what is accepted give numbers, or say that nothing fits.
TEST(SurfaceFit, IsFiniteForHeightsAKilometerApart) {
  for (const double sigma_mm : {1e-9, 1e6}) {
    Points points = warped(14);
    points[8].measured.height = mm(1e6);
    for (ProbePoint& point : points) point.measured.sigma = mm(sigma_mm);
    for (const SurfaceModel model : kModels) {
      const auto fit = fit_surface(points, model);
      if (!fit) {
        EXPECT_EQ(fit.error().code, Code::GridInvalid);
        continue;
      }
      const HeightEstimate there = fit->at(at(31, 17));
      EXPECT_TRUE(std::isfinite(there.height.in_mm())) << name_of(model);
      EXPECT_GT(there.sigma.in_mm(), 0) << name_of(model);
    }
  }
}

TEST(SurfaceFit, RefusesWhatMakesNoSurface) {
  Points points = warped(19);
  EXPECT_THAT(fit_surface({}, SurfaceModel::Plane), FailsWith(Code::GridInvalid, "0 probes"));
  EXPECT_THAT(fit_surface(Points(points.begin(), points.begin() + 7), SurfaceModel::ThinPlate),
              FailsWith(Code::GridInvalid, "7 probes"));
  EXPECT_THAT(fit_surface(Points(4, points[0]), SurfaceModel::GaussianProcess),
              FailsWith(Code::GridInvalid));
  EXPECT_THAT(fit_surface(Points(kMostBentProbes + 1, points[0]), SurfaceModel::Plane),
              FailsWith(Code::GridInvalid, "3001 probes"));
  EXPECT_THAT(fit_surface(Points(kMostGridProbes + 1, points[0]), SurfaceModel::Bilinear),
              FailsWith(Code::GridInvalid, "50001 probes"));
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    Points broken = points;
    broken[3].measured.sigma = mm(bad);
    EXPECT_THAT(fit_surface(broken, SurfaceModel::Plane),
                FailsWith(Code::GridInvalid, "column 3 row 0"));
  }
  points[9].measured.height = mm(std::numeric_limits<double>::infinity());
  EXPECT_THAT(fit_surface(points, SurfaceModel::Plane),
              FailsWith(Code::GridInvalid, "probes.jsonl:10"));
}

}  // namespace
}  // namespace panelcal
