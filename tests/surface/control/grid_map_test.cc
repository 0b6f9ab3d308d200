// SPDX-License-Identifier: Apache-2.0
#include "surface/control/grid_map.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <numbers>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

namespace panelcal {
namespace {

using Eigen::Vector2d;
using Points = std::vector<GridPoint>;
using Surface = std::function<double(double x_mm, double y_mm)>;

constexpr double kPi = std::numbers::pi;
/// Rounding of heights of some mm.
constexpr double kRounding_mm = 1e-13;

GridPoint point(double x_mm, double y_mm, double height_mm = 1.6, double sigma_mm = 0.002) {
  return {{x_mm, y_mm}, {{mm(height_mm), mm(sigma_mm)}}};
}

Points lattice(const std::vector<double>& x_mm,
               const std::vector<double>& y_mm,
               const Surface& surface) {
  Points points;
  for (const double y : y_mm) {
    for (const double x : x_mm) points.push_back(point(x, y, surface(x, y)));
  }
  return points;
}

GridMap made(const Points& points) {
  auto map = GridMap::from_points(points);
  EXPECT_TRUE(map) << map.error().text;
  return *std::move(map);
}

/// The manual's example: columns X0 to X90, rows Y0 to Y110.
Points manual_grid(const Surface& surface) {
  std::vector<double> x_mm, y_mm;
  for (int i = 0; i < 10; ++i) x_mm.push_back(10.0 * i);
  for (int i = 0; i < 12; ++i) y_mm.push_back(10.0 * i);
  return lattice(x_mm, y_mm, surface);
}

double flat(double, double) {
  return 1.6;
}

double height_mm(const GridMap& map, double x_mm, double y_mm) {
  return map.height_at({x_mm, y_mm}).heights.at(0).height.in_mm();
}

/// `facts` are what the text names, in any order.
void expect_fails(const Points& points,
                  GridFailure failure,
                  std::initializer_list<const char*> facts) {
  const auto map = GridMap::from_points(points);
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().failure, failure);
  for (const char* fact : facts) EXPECT_THAT(map.error().text, testing::HasSubstr(fact));
}

// SIEB & MEYER CNC 8x.00, G78: 10 x 12 positions, 10 mm apart.
TEST(GridMap, ManualG78HasTenByTwelveNodes) {
  const auto bilinear = [](double x, double y) { return 1.6 + 1e-3 * x - 2e-3 * y + 1e-5 * x * y; };
  Points points = manual_grid(bilinear);
  ASSERT_EQ(points.size(), 120u);
  std::ranges::reverse(points);
  const GridMap map = made(points);
  ASSERT_EQ(map.columns_mm().size(), 10u);
  ASSERT_EQ(map.rows_mm().size(), 12u);
  EXPECT_EQ(map.columns_mm().back(), 90);
  EXPECT_EQ(map.rows_mm().back(), 110);
  for (const Vector2d& p :
       {Vector2d(0, 0), Vector2d(90, 110), Vector2d(37.5, 99), Vector2d(80, 5)}) {
    EXPECT_NEAR(height_mm(map, p.x(), p.y()), bilinear(p.x(), p.y()), kRounding_mm);
  }
}

// The same example: the reference position X10Y5 is between two rows, so its value is no grid
// value.
TEST(GridMap, ManualG78ReferenceIsNoNode) {
  Points points = manual_grid(flat);
  points.push_back(point(10, 5));
  expect_fails(points, GridFailure::Incomplete, {"(0, 5) mm", "10 x 13"});
}

TEST(GridMap, InterpolatesBetweenFourNodes) {
  const GridMap map = made({point(0, 0, 1), point(10, 0, 2), point(0, 20, 3), point(10, 20, 8)});
  EXPECT_DOUBLE_EQ(height_mm(map, 5, 0), 1.5);
  EXPECT_DOUBLE_EQ(height_mm(map, 0, 5), 1.5);
  EXPECT_DOUBLE_EQ(height_mm(map, 10, 5), 3.5);
  EXPECT_DOUBLE_EQ(height_mm(map, 5, 10), 3.5);  // the mean of all four
  EXPECT_DOUBLE_EQ(height_mm(map, 2, 5), 0.8 * 1.5 + 0.2 * 3.5);
}

TEST(GridMap, GivesBackTheNodesExactly) {
  Random random(7);
  const Points points =
      lattice({-3.3, 0.1, 0.7, 12}, {0, 1.1, 900}, [&](double, double) { return random.normal(); });
  const GridMap map = made(points);
  for (const GridPoint& p : points) {
    const GridHeight found = map.height_at(p.place_mm);
    EXPECT_EQ(found.heights[0].height, p.heights[0].height);
    EXPECT_EQ(found.heights[0].sigma, p.heights[0].sigma);
    EXPECT_TRUE(found.is_inside());
  }
}

TEST(GridMap, EveryZAxisHasItsOwnSurface) {
  Points points = lattice({0, 10}, {0, 10}, flat);
  for (GridPoint& p : points) {
    p.heights.push_back({mm(2 + 0.1 * p.place_mm.x()), um(1)});
  }
  const GridMap map = made(points);
  EXPECT_EQ(map.n_axes(), 2u);
  const GridHeight found = map.height_at({5, 5});
  ASSERT_EQ(found.heights.size(), 2u);
  EXPECT_DOUBLE_EQ(found.heights[0].height.in_mm(), 1.6);
  EXPECT_DOUBLE_EQ(found.heights[1].height.in_mm(), 2.5);
  EXPECT_DOUBLE_EQ(found.heights[1].sigma.in_um(), 0.5) << "four errors of 1 um, weight 1/4";
}

TEST(GridMap, EdgeValuesHoldOutside) {
  const GridMap map = made({point(0, 0, 1), point(10, 0, 2), point(0, 20, 3), point(10, 20, 8)});
  EXPECT_DOUBLE_EQ(height_mm(map, 5, -7), 1.5);
  EXPECT_DOUBLE_EQ(height_mm(map, -4, 5), 1.5);
  const GridHeight corner = map.height_at({13, 24});
  EXPECT_DOUBLE_EQ(corner.heights[0].height.in_mm(), 8);
  EXPECT_FALSE(corner.is_inside());
  EXPECT_DOUBLE_EQ(corner.outside.in_mm(), 5);
  EXPECT_TRUE(map.height_at({10, 20}).is_inside());
  EXPECT_TRUE(map.height_at({10.0009, 20}).is_inside()) << "less than a micrometre";
  EXPECT_FALSE(map.height_at({10.0011, 20}).is_inside());
}

TEST(GridMap, ForgivesAMicrometreInCoordinates) {
  const GridMap map = made({point(0, 0), point(10.0009, 0.0004), point(0.0008, 20), point(10, 20)});
  EXPECT_EQ(map.columns_mm().size(), 2u);
  EXPECT_EQ(map.rows_mm().size(), 2u);
  expect_fails({point(0, 0), point(10.0011, 0), point(0, 20), point(10, 20)},
               GridFailure::Incomplete,
               {"(10, 0) mm", "3 x 2"});
}

TEST(GridMap, RefusesARowOrAColumn) {
  expect_fails({}, GridFailure::TooFewPoints, {"0 columns", "0 rows"});
  expect_fails({point(0, 0), point(10, 0), point(20, 0), point(30, 0)},
               GridFailure::TooFewPoints,
               {"4 columns", "1 rows"});
  expect_fails(
      {point(5, 0), point(5, 1), point(5, 2)}, GridFailure::TooFewPoints, {"1 columns", "3 rows"});
}

TEST(GridMap, NamesTheFirstMissingNode) {
  Points points = manual_grid(flat);
  std::erase_if(points, [](const GridPoint& p) {
    return p.place_mm == Vector2d(40, 30) || p.place_mm == Vector2d(20, 110);
  });
  expect_fails(points, GridFailure::Incomplete, {"(40, 30) mm", "10 x 12"});
  points = manual_grid(flat);
  points.pop_back();
  expect_fails(points, GridFailure::Incomplete, {"(90, 110) mm", "10 x 12"});
  // A grid that is turned has as many columns as points.
  expect_fails({point(0, 0), point(10, 1), point(-1, 10), point(9, 11)},
               GridFailure::Incomplete,
               {"(-1, 0) mm", "4 x 4"});
}

TEST(GridMap, RefusesANodeThatIsMeasuredTwice) {
  Points points = manual_grid(flat);
  points.push_back(point(30, 70));
  expect_fails(points, GridFailure::Duplicate, {"(30, 70) mm"});
  EXPECT_EQ(GridMap::from_points(points).error().i_point, 120u);
}

TEST(GridMap, RefusesBadPoints) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const GridPoint& bad :
       {point(nan, 0), point(0, inf), point(0, 0, nan), point(0, 0, 1, -1), point(0, 0, 1, inf)}) {
    Points points = manual_grid(flat);
    points[17] = bad;
    const auto map = GridMap::from_points(points);
    ASSERT_FALSE(map);
    EXPECT_EQ(map.error().failure, GridFailure::BadPoint);
    EXPECT_EQ(map.error().i_point, 17u);
  }
  Points points = manual_grid(flat);
  points[3].heights.push_back({mm(1), um(1)});
  expect_fails(points, GridFailure::BadPoint, {"2 Z axes"});
  points[0].heights.clear();
  expect_fails(points, GridFailure::BadPoint, {"0 Z axes"});
}

/// Greatest error of a contour's height, straight between cuts, against the map; by dense sampling.
double worst_error_mm(const GridMap& map,
                      const std::function<Vector2d(double)>& place_mm,
                      const std::vector<double>& cuts) {
  constexpr int kSamples = 60;
  std::vector<double> t{0};
  t.insert(t.end(), cuts.begin(), cuts.end());
  t.push_back(1);
  double worst_mm = 0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    EXPECT_LT(t[i - 1], t[i]);
    const GridHeight begin = map.height_at(place_mm(t[i - 1]));
    const GridHeight end = map.height_at(place_mm(t[i]));
    for (int k = 1; k < kSamples; ++k) {
      const double share = static_cast<double>(k) / kSamples;
      const GridHeight there = map.height_at(place_mm(t[i - 1] + share * (t[i] - t[i - 1])));
      for (std::size_t axis = 0; axis < map.n_axes(); ++axis) {
        const Length chord =
            (1 - share) * begin.heights[axis].height + share * end.heights[axis].height;
        const double error_mm = (there.heights[axis].height - chord).in_mm();
        worst_mm = std::max(worst_mm, std::abs(error_mm));
      }
    }
  }
  return worst_mm;
}

double worst_on_line_mm(const GridMap& map,
                        const Vector2d& from_mm,
                        const Vector2d& to_mm,
                        const std::vector<double>& cuts) {
  const auto place_mm = [&](double t) -> Vector2d { return from_mm + t * (to_mm - from_mm); };
  return worst_error_mm(map, place_mm, cuts);
}

/// z = 1e-3 x y / mm over one cell of 10 mm: along the diagonal 0.1 mm t^2.
GridMap twisted() {
  return made(lattice({0, 10}, {0, 10}, [](double x, double y) { return 1e-3 * x * y; }));
}

TEST(GridMapSplit, CutsAParabolaIntoEvenStretches) {
  // |a| h^2 / 4 with a = 0.1 mm: one stretch is off by 25 um, five by 1 um each.
  const GridMap map = twisted();
  const auto cuts = map.split_line({0, 0}, {10, 10}, um(1));
  ASSERT_EQ(cuts.size(), 4u);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    EXPECT_NEAR(cuts[i], 0.2 * static_cast<double>(i + 1), 1e-8);
  }
  EXPECT_NEAR(worst_on_line_mm(map, {0, 0}, {10, 10}, cuts), 0.001, 1e-9);
  EXPECT_EQ(map.split_line({0, 0}, {10, 10}, um(25)).size(), 0u);
  EXPECT_EQ(map.split_line({0, 0}, {10, 10}, um(24.9)).size(), 1u);
  EXPECT_EQ(map.split_line({0, 5}, {10, 5}, um(0.01)).size(), 0u) << "straight along an axis";
}

TEST(GridMapSplit, DoesNotCutAPlane) {
  const GridMap map = made(manual_grid([](double x, double y) { return 1.6 + 1e-3 * x - y / 3; }));
  EXPECT_TRUE(map.split_line({3, 2}, {88, 107}, um(0.01)).empty());
  EXPECT_TRUE(map.split_line({0, 110}, {90, 0}, Length()).empty());
}

TEST(GridMapSplit, CutsAtAnEdgeOnlyWhereItMatters) {
  // A roof of 0.1 mm over x = 10, flat beyond.
  const GridMap roof = made(
      lattice({0, 10, 20}, {0, 10}, [](double x, double) { return 0.01 * std::min(x, 20 - x); }));
  const auto cuts = roof.split_line({0, 5}, {20, 5}, um(1));
  ASSERT_FALSE(cuts.empty());
  EXPECT_LE(cuts.size(), 2u);
  EXPECT_LE(worst_on_line_mm(roof, {0, 5}, {20, 5}, cuts), 0.001 + 1e-9);
  EXPECT_TRUE(roof.split_line({0, 5}, {20, 5}, um(100)).empty());
  EXPECT_TRUE(roof.split_line({0, 5}, {9, 5}, um(1)).empty());
  // From inside to outside: the bend at the edge of the grid.
  const auto out = roof.split_line({10, 5}, {60, 5}, um(1));
  EXPECT_LE(worst_on_line_mm(roof, {10, 5}, {60, 5}, out), 0.001 + 1e-9);
  EXPECT_FALSE(out.empty());
  EXPECT_TRUE(roof.split_line({30, -5}, {60, 50}, um(1)).empty()) << "all outside, level";
}

TEST(GridMapSplit, AnswersWhateverIsAsked) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const GridMap map = twisted();
  EXPECT_TRUE(map.split_line({5, 5}, {5, 5}, um(1)).empty());
  EXPECT_TRUE(map.split_line({nan, 5}, {5, 5}, um(1)).empty());
  EXPECT_TRUE(map.split_arc({5, 5}, 0, nan, 2, um(1)).empty());
  EXPECT_TRUE(map.split_arc({5, 5}, 0, 1, 0, um(1)).empty());
  EXPECT_TRUE(map.split_arc({5, 5}, 0, 0, 2, um(1)).empty());
  // 0.1 mm against 0.001 um is sqrt(25,000) = 158.1 stretches.
  EXPECT_EQ(map.split_line({0, 0}, {10, 10}, um(-1)).size(), 158u);
  EXPECT_EQ(map.split_line({0, 0}, {10, 10}, mm(nan)).size(), 158u);
  const GridMap wild =
      made(lattice({0, 10}, {0, 10}, [](double x, double y) { return 1e9 * x * y; }));
  EXPECT_LT(wild.split_line({0, 0}, {10, 10}, um(1)).size(), 4096u);
}

TEST(GridMapSplit, CutsAnArcOnASlope) {
  // Round a full circle of 10 mm on a slope of 1 in 100 the height is 0.1 mm sin(w); stretches of h
  // are off by 0.1 mm |sin(w)| h^2 / 8, so that no way to cut needs fewer pieces than
  //   int_0^2pi sqrt(0.1 |sin(w)| / (8 x 0.001)) dw = 3.54 x 4.79 = 16.9
  const GridMap map =
      made(lattice({-50, 50}, {-50, 50}, [](double, double y) { return 0.01 * y; }));
  const auto place_mm = [](double t) -> Vector2d {
    return 10 * Vector2d(std::cos(2 * kPi * t), std::sin(2 * kPi * t));
  };
  const auto cuts = map.split_arc({0, 0}, 0, 2 * kPi, 10, um(1));
  EXPECT_GE(cuts.size(), 16u);
  EXPECT_LE(cuts.size(), 18u);
  EXPECT_LE(worst_error_mm(map, place_mm, cuts), 0.001);
  EXPECT_GT(worst_error_mm(map, place_mm, cuts), 0.0009);
  const GridMap level = made(lattice({-5, 5}, {-5, 5}, flat));
  EXPECT_TRUE(level.split_arc({0, 0}, 0, 2 * kPi, 10, um(0.01)).empty());
}

/// A grid of uneven columns and rows with two Z axes, rough or smooth.
GridMap random_map(Random& random) {
  const auto coordinates = [&] {
    std::vector<double> values_mm{random.uniform(-50, 50)};
    const int n = 2 + static_cast<int>(random.uniform(0, 6));
    while (static_cast<int>(values_mm.size()) < n) {
      values_mm.push_back(values_mm.back() + random.uniform(0.5, 30));
    }
    return values_mm;
  };
  const double roughness_mm = std::pow(10, random.uniform(-4, 0));
  const double slope = random.uniform(-1e-2, 1e-2);
  Points points = lattice(coordinates(), coordinates(), [&](double x, double) {
    return 1.6 + slope * x + roughness_mm * random.normal();
  });
  for (GridPoint& p : points) {
    p.heights.push_back({mm(0.3 * roughness_mm * random.normal()), Length()});
  }
  return made(points);
}

Vector2d anywhere(Random& random) {
  return {random.uniform(-80, 150), random.uniform(-80, 150)};
}

/// Error that sampling and rounding add to a tolerance.
constexpr double kMeasured_mm = 1e-9;

TEST(GridMapProperty, SplitLinesStayWithinTolerance) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const GridMap map = random_map(random);
    const Vector2d from_mm = anywhere(random);
    Vector2d to_mm = anywhere(random);
    if (seed % 5 == 0) to_mm.x() = from_mm.x();
    if (seed % 7 == 0) to_mm.y() = map.rows_mm().back();
    const double tolerance_mm = std::pow(10, random.uniform(-4, -1));
    const auto cuts = map.split_line(from_mm, to_mm, mm(tolerance_mm));
    EXPECT_LE(worst_on_line_mm(map, from_mm, to_mm, cuts), tolerance_mm + kMeasured_mm);
  }
}

TEST(GridMapProperty, SplitArcsStayWithinTolerance) {
  for (std::uint64_t seed = 1000; seed < 1400; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const GridMap map = random_map(random);
    const Vector2d center_mm = anywhere(random);
    const double radius_mm = std::pow(10, random.uniform(-1, 2.5));
    const double start_rad = random.uniform(-7, 7);
    const double sweep_rad = seed % 4 == 0 ? -2 * kPi : random.uniform(-2 * kPi, 2 * kPi);
    const double tolerance_mm = std::pow(10, random.uniform(-3.5, -1));
    const auto cuts = map.split_arc(center_mm, start_rad, sweep_rad, radius_mm, mm(tolerance_mm));
    const auto place_mm = [&](double t) -> Vector2d {
      const double angle_rad = start_rad + t * sweep_rad;
      return center_mm + radius_mm * Vector2d(std::cos(angle_rad), std::sin(angle_rad));
    };
    EXPECT_LE(worst_error_mm(map, place_mm, cuts), tolerance_mm + kMeasured_mm);
  }
}

TEST(GridMapProperty, LinesInOneCellAreCutAsRarelyAsPossible) {
  for (std::uint64_t seed = 2000; seed < 2200; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double twist_per_mm = random.uniform(-1e-3, 1e-3);
    const GridMap map = made(lattice({-100, 100}, {-100, 100}, [&](double x, double y) {
      return twist_per_mm * x * y + 0.01 * x;
    }));
    const Vector2d from_mm(random.uniform(-90, 90), random.uniform(-90, 90));
    const Vector2d to_mm(random.uniform(-90, 90), random.uniform(-90, 90));
    const Vector2d along_mm = to_mm - from_mm;
    const double a_mm = std::abs(twist_per_mm * along_mm.x() * along_mm.y());
    const double n = std::ceil(std::sqrt(a_mm / (4 * 0.005)));
    EXPECT_EQ(map.split_line(from_mm, to_mm, um(5)).size(),
              static_cast<std::size_t>(std::max(n, 1.0)) - 1);
  }
}

}  // namespace
}  // namespace panelcal
