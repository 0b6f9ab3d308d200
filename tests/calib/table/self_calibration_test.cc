// SPDX-License-Identifier: Apache-2.0
// A table from a plate that was not measured before.
#include <cmath>
#include <numbers>

#include "calib/table/fit.h"
#include <gmock/gmock.h>

#include "tests/calib/table/simulated_table.h"

namespace panelcal {
namespace {

using testing::Contains;
using testing::ElementsAre;

constexpr double kQuarter_rad = std::numbers::pi / 2;
constexpr double kPitch_mm = 20;

/// A plate of 15 x 15 dots that are off by 5 um; poses as given, 1 um of noise.
TableData looks(const std::vector<PlatePose>& poses, std::uint64_t seed, double beside_mm = 0) {
  Random random(seed);
  const auto plate = test::simulated_plate(15, kPitch_mm, false, 0.005, random);
  TableData data;
  for (const PlatePose& pose : poses) {
    test::look(plate, pose, test::smooth_warp_mm, 0.001, random, data, beside_mm);
  }
  return data;
}

/// Rms of what a map is off by, free of the scale that self-calibration leaves open.
double rms_without_scale_mm(const TableMap& map) {
  const auto before = test::compare(TableMap(), test::smooth_warp_mm, 10, 310);
  const auto error = [&](const Eigen::Vector2d& c) {
    return Eigen::Vector2d(test::smooth_warp_mm(c) +
                           before.scale * (c - Eigen::Vector2d(160, 160)));
  };
  return test::compare(map, error, 10, 310).rms_mm;
}

TEST(TableSelfCalibration, ATurnAndAShiftLeaveOnlyTheScaleOpen) {
  const auto fit = fit_table(looks({{0, {150, 150}},
                                    {kQuarter_rad, {150, 150}},
                                    {0, {150 + kPitch_mm, 150}},
                                    {0, {150, 150 + kPitch_mm}}},
                                   1),
                             {});
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_THAT(fit->undetermined, ElementsAre("scale"));
  // Free of its scale the map is as good as with a certificate.
  EXPECT_GT(test::compare(TableMap(), test::smooth_warp_mm, 10, 310).rms_mm, 0.010);
  EXPECT_LE(rms_without_scale_mm(fit->map), 0.0015);
}

TEST(TableSelfCalibration, StopsBesideTheDotsNeitherTurnNorShiftTheTable) {
  // From 0.05 mm beside, 675 looks see turn and scale of the table to some 0.05 mm, since the
  // camera turns and grows with neither. The turn is convention all the same, and the scale open.
  // From 3 mm beside both are seen well.
  for (const auto& [beside_mm, is_scale_open] : {std::pair(0.05, true), std::pair(3.0, false)}) {
    for (std::uint64_t seed = 1; seed < 4; ++seed) {
      const auto fit = fit_table(looks({{0, {150, 150}},
                                        {kQuarter_rad, {150, 150}},
                                        {0, {150 + kPitch_mm, 150}},
                                        {0, {150, 150 + kPitch_mm}}},
                                       seed,
                                       beside_mm),
                                 {});
      ASSERT_TRUE(fit) << fit.error().text();
      EXPECT_EQ(fit->undetermined, std::vector<std::string>(is_scale_open ? 1 : 0, "scale"));
      EXPECT_NEAR(fit->chi_square / fit->degrees_of_freedom, 1, 0.15) << beside_mm;
      EXPECT_TRUE(fit->geometry.cov.isApprox(fit->geometry.cov.transpose(), 1e-9));
      if (is_scale_open) {
        EXPECT_LE(rms_without_scale_mm(fit->map), 0.0015);
      } else {
        EXPECT_LE(test::compare(fit->map, test::smooth_warp_mm, 10, 310).rms_mm, 0.004);
      }
    }
  }
}

TEST(TableSelfCalibration, OnePoseOfACertifiedPlateWithStopsWithinAPitch) {
  Random random(7);
  const auto plate = test::simulated_plate(15, kPitch_mm, true, 0, random);
  TableData data;
  test::look(plate, {0, {150, 150}}, test::smooth_warp_mm, 0.001, random, data, kPitch_mm / 2);
  const auto fit = fit_table(data, {});
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_NEAR(fit->chi_square / fit->degrees_of_freedom, 1, 0.2);
  EXPECT_LE(test::compare(fit->map, test::smooth_warp_mm, 10, 290).rms_mm, 0.0015);
}

TEST(TableSelfCalibration, WithoutATurnSquarenessAndScalesAreOpen) {
  const auto fit = fit_table(
      looks({{0, {150, 150}}, {0, {150 + kPitch_mm, 150}}, {0, {150, 150 + kPitch_mm}}}, 2), {});
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_THAT(fit->undetermined, ElementsAre("scale", "scale of x against y", "squareness"));
}

TEST(TableSelfCalibration, AQuarterTurnAloneLeavesWhatHasItsSymmetryOpen) {
  // With z = x + i y, errors that turn along with z -> i z: of the first degree z (scale) and i z
  // (the turn itself), of the third z |z|^2, conj(z)^3 and i times each; of the second none.
  const auto fit = fit_table(looks({{0, {150, 150}}, {kQuarter_rad, {150, 150}}}, 3), {});
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_THAT(fit->undetermined, Contains("scale"));
  EXPECT_THAT(fit->undetermined, testing::Not(Contains("squareness")));
  EXPECT_THAT(fit->undetermined, Contains(testing::StartsWith("a mixture of")));
  EXPECT_EQ(fit->undetermined.size(), 5U);
}

TEST(TableSelfCalibration, AHalfTurnLeavesOddErrorsOpen) {
  // Turned by 180 degrees the plate shows again whatever is odd about the middle: all linear and
  // all cubic errors, 4 - 1 and 8; even ones change sign and are told apart.
  const auto fit = fit_table(looks({{0, {150, 150}}, {2 * kQuarter_rad, {150, 150}}}, 4), {});
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_THAT(fit->undetermined, Contains("squareness"));
  EXPECT_THAT(fit->undetermined, Contains("x error by x^3"));
  EXPECT_THAT(fit->undetermined, testing::Not(Contains("y error by x^2")));
  EXPECT_EQ(fit->undetermined.size(), 11U);
}

}  // namespace
}  // namespace panelcal
