// SPDX-License-Identifier: Apache-2.0
#include "calib/table/fit.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>

#include "tests/calib/table/simulated_table.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::IsEmpty;

/// A plate of 15 x 15 dots over 300 mm, looked at once, from the middle of the table.
TableData one_look(const test::TableError& error, double noise_mm, std::uint64_t seed) {
  Random random(seed);
  const auto plate = test::simulated_plate(15, 300.0 / 14, true, 0, random);
  TableData data;
  test::look(plate, {0, {150, 150}}, error, noise_mm, random, data);
  return data;
}

/// The same plate as it is, turned by 90 degrees, and shifted by a dot.
TableData three_looks(const test::TableError& error, std::uint64_t seed) {
  constexpr double kPitch_mm = 270.0 / 14;
  Random random(seed);
  const auto plate = test::simulated_plate(15, kPitch_mm, true, 0, random);
  TableData data;
  for (const PlatePose& pose : {PlatePose{0, {140, 150}},
                                PlatePose{std::numbers::pi / 2, {140, 150}},
                                PlatePose{0, {140 + kPitch_mm, 150}}}) {
    test::look(plate, pose, error, 0.0005, random, data);
  }
  return data;
}

TEST(TableFit, FindsScaleAndSquareness) {
  const auto error = [](const Eigen::Vector2d& c) {
    return Eigen::Vector2d(80e-6 * c.x() + 120e-6 * c.y() + 1, -50e-6 * c.y() - 2);
  };
  const auto fit = fit_table(one_look(error, 0, 1), {});
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_NEAR(fit->geometry.value[TableGeometry::ScaleX], 80e-6, 1e-8);
  EXPECT_NEAR(fit->geometry.value[TableGeometry::ScaleY], -50e-6, 1e-8);
  EXPECT_NEAR(fit->geometry.value[TableGeometry::Squareness], 120e-6, 1e-8);
  for (int k = TableGeometry::LinearityX2; k < TableGeometry::kSize; ++k) {
    EXPECT_NEAR(fit->geometry.value[k], 0, 1e-6) << k;
  }
  EXPECT_THAT(fit->undetermined, IsEmpty());
  // The x axis is what the y axis is square to.
  const auto corner = fit->map.error_mm(position_mm<frame::Machine>(300, 150));
  EXPECT_NEAR(corner.y(), fit->map.error_mm(position_mm<frame::Machine>(0, 150)).y(), 1e-6);
}

TEST(TableFit, FindsStraightnessAndLinearity) {
  const auto error = [](const Eigen::Vector2d& c) {
    const double x = c.x() / 150 - 1;
    const double y = c.y() / 150 - 1;
    return Eigen::Vector2d(0.004 * (2.5 * x * x * x - 1.5 * x) + 0.007 * (1.5 * y * y - 0.5),
                           0.010 * (1.5 * x * x - 0.5) - 0.003 * (2.5 * y * y * y - 1.5 * y));
  };
  const auto fit = fit_table(one_look(error, 0, 2), {});
  ASSERT_TRUE(fit) << fit.error().text();
  constexpr double kTolerance_mm = 2e-5;
  EXPECT_NEAR(fit->geometry.value[TableGeometry::LinearityX3], 0.004, kTolerance_mm);
  EXPECT_NEAR(fit->geometry.value[TableGeometry::StraightnessY2], 0.007, kTolerance_mm);
  EXPECT_NEAR(fit->geometry.value[TableGeometry::StraightnessX2], 0.010, kTolerance_mm);
  EXPECT_NEAR(fit->geometry.value[TableGeometry::LinearityY3], -0.003, kTolerance_mm);
  EXPECT_NEAR(fit->geometry.value[TableGeometry::LinearityX2], 0, kTolerance_mm);
  EXPECT_NEAR(fit->geometry.value[TableGeometry::StraightnessY3], 0, kTolerance_mm);
}

TEST(TableFit, LeavesLittleOfASmoothWarp) {
  const auto fit = fit_table(one_look(test::smooth_warp_mm, 0.001, 3), {});
  ASSERT_TRUE(fit) << fit.error().text();
  const auto before = test::compare(TableMap(), test::smooth_warp_mm, 0, 300);
  const auto left = test::compare(fit->map, test::smooth_warp_mm, 0, 300);
  EXPECT_GT(before.largest_mm, 0.030);
  EXPECT_LE(left.rms_mm, 0.0015);
  ASSERT_TRUE(fit->held_out_rms_mm);
  EXPECT_GT(fit->n_held_out, 25U);
  EXPECT_LE(*fit->held_out_rms_mm, 0.0021);  // 0.0014 is the noise of two coordinates
}

TEST(TableFit, APlateOfHalfTheTravelServesInFourPoses) {
  Random random(4);
  const auto plate = test::simulated_plate(11, 15.0, true, 0, random);
  TableData data;
  for (const double x_mm : {75.0, 225.0}) {
    for (const double y_mm : {75.0, 225.0}) {
      test::look(plate, {0, {x_mm, y_mm}}, test::smooth_warp_mm, 0.001, random, data);
    }
  }
  const auto fit = fit_table(data, {});
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_THAT(fit->undetermined, IsEmpty());
  EXPECT_LE(test::compare(fit->map, test::smooth_warp_mm, 0, 300).rms_mm, 0.003);
}

TEST(TableFit, AMapOfNoiseStaysFlat) {
  const auto none = [](const Eigen::Vector2d&) { return Eigen::Vector2d(0, 0); };
  const auto fit = fit_table(one_look(none, 0.001, 5), {});
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_LE(test::compare(fit->map, none, 0, 300).rms_mm, 0.0003);
  EXPECT_LT(fit->parameters, 20);
}

/// One look at each place does not tell scatter from the shortest waves.
TEST(TableFit, IsSmootherThanAPlateOnlyWherePlacesAreSeenAgain) {
  const auto waves = [](const Eigen::Vector2d& c) {
    return Eigen::Vector2d(0.010 * std::sin(c.x() / 70 + 1), 0.008 * std::sin(c.y() / 80 + 2));
  };
  const auto again = fit_table(three_looks(waves, 8), {});
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->smoothness.process, TableProcess::Matern);
  const auto once = fit_table(one_look(waves, 0.0005, 8), {});
  ASSERT_TRUE(once) << once.error().text();
  EXPECT_EQ(once->smoothness.process, TableProcess::ThinPlate);
}

TEST(TableFit, RefusesWhatIsNoData) {
  const TableData good = one_look(test::smooth_warp_mm, 0.001, 6);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(fit_table({}, {}), FailsWith(Code::CalibrationData, "0 observations"));
  TableData data = good;
  data.seen[5].i_view = 1000;
  EXPECT_THAT(fit_table(data, {}), FailsWith(Code::CalibrationData, "observation 5"));
  data = good;
  data.seen[5].seen.cov(1, 1) = nan;
  EXPECT_THAT(fit_table(data, {}), FailsWith(Code::CalibrationData, "observation 5"));
  data = good;
  data.views[0].axis_at = position_mm<frame::Machine>(nan, 0);
  EXPECT_THAT(fit_table(data, {}), FailsWith(Code::CalibrationData, "finite"));
  data = good;
  for (PlateView& view : data.views) view.axis_at = position_mm<frame::Machine>(3, 4);
  EXPECT_THAT(fit_table(data, {}), FailsWith(Code::CalibrationData, "one line"));
  TableFitOptions options;
  options.steps = 0;
  EXPECT_THAT(fit_table(good, options), FailsWith(Code::CalibrationData, "steps"));
  options = {};
  options.open_sigma = mm(nan);
  EXPECT_THAT(fit_table(good, options), FailsWith(Code::CalibrationData, "open_sigma"));
  // One pose of a plate without a certificate tells its errors from the table's nowhere.
  data = good;
  for (PlateDot& dot : data.dots) dot.is_certified = false;
  EXPECT_THAT(fit_table(data, {}), FailsWith(Code::CalibrationData));
}

}  // namespace
}  // namespace panelcal
