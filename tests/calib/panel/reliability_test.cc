// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/reliability.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/base/statistics/chi_square.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using CheckedPair = TargetPair<frame::Base, frame::Nominal>;
using CheckedFit = PanelFit<frame::Base, frame::Nominal>;

constexpr double kCheckedSigma_mm = 1e-3;

std::vector<CheckedPair> seen_at(const std::vector<Eigen::Vector2d>& places_mm) {
  std::vector<CheckedPair> pairs;
  for (const Eigen::Vector2d& p_mm : places_mm) {
    pairs.push_back({position_mm<frame::Nominal>(p_mm),
                     {position_mm<frame::Base>(p_mm),
                      kCheckedSigma_mm * kCheckedSigma_mm * Eigen::Matrix2d::Identity()}});
  }
  return pairs;
}

const std::vector<Eigen::Vector2d> kCorners = {{0, 0}, {100, 0}, {0, 100}, {100, 100}};

Reliability of(const std::vector<Eigen::Vector2d>& places_mm,
               PanelModel model,
               const GateLimits& limits) {
  const auto pairs = seen_at(places_mm);
  return reliability(fit_panel(std::span(pairs), model).fit.value(), limits);
}

/// Of one target.
double largest_mm(const Reliability& reliability, std::size_t i) {
  double out = 0;
  for (const UnseenError& error : reliability.unseen) {
    if (error.i_target == i) out = std::max(out, error.error_mm.norm());
  }
  return out;
}

TEST(Reliability, OfOneTargetIsNone) {
  const Reliability one = of({{10, 20}}, PanelModel::Offset, default_gate_limits());
  EXPECT_FALSE(one.can_be_stated());
  EXPECT_TRUE(std::isinf(one.noise_ratio2));
  ASSERT_FALSE(one.unseen.empty());
  EXPECT_TRUE(std::ranges::all_of(one.unseen, &UnseenError::is_unlimited));
  GateLimits limits = default_gate_limits();
  limits.offset = mm(1.5);
  EXPECT_NEAR(largest_mm(of({{10, 20}}, PanelModel::Offset, limits), 0), 1.5, 1e-9);
}

/// Across the line between them an error turns the panel, and only the gate on rotation sees it:
/// 100 mm times 3 degrees. Along the line half of it is each one's residual.
TEST(Reliability, OfTwoTargetsIsTheGateOnRotation) {
  const Reliability two = of({{0, 0}, {100, 0}}, PanelModel::Rigid, default_gate_limits());
  EXPECT_NEAR(largest_mm(two, 0), 100 * deg(3).in_rad(), 0.02);
  GateLimits narrow = default_gate_limits();
  narrow.rotation = rad(0.005);
  EXPECT_NEAR(largest_mm(of({{0, 0}, {100, 0}}, PanelModel::Rigid, narrow), 0), 0.5, 0.005);
}

/// Three targets at a corner: an error of the second along x is a stretch, 2,000 ppm of 100 mm.
TEST(Reliability, OfThreeTargetsIsTheGateOnStretch) {
  const Reliability three =
      of({{0, 0}, {100, 0}, {0, 100}}, PanelModel::Stretch, default_gate_limits());
  EXPECT_FALSE(three.can_be_stated());
  EXPECT_NEAR(largest_mm(three, 1), 0.2, 0.01);
}

/// Of four corners under an affine map a quarter of an error shows in chi square: u^2 / 4 =
/// lambda sigma^2 in every direction.
TEST(Reliability, OfFourCornersIsWhatChiSquareHides) {
  auto pairs = seen_at(kCorners);
  CheckedFit fit = fit_panel(std::span<const CheckedPair>(pairs), PanelModel::Affine).fit.value();
  ASSERT_EQ(fit.degrees_of_freedom, 2);
  fit.chi_square = 3;  // above 2
  const Reliability four = reliability(fit, default_gate_limits());
  const double expected_mm = 2 * kCheckedSigma_mm * std::sqrt(largest_noncentrality(3, 2, 0.01));
  for (const UnseenError& error : four.unseen) {
    EXPECT_NEAR(error.error_mm.norm(), expected_mm, 1e-3 * expected_mm);
    EXPECT_FALSE(error.is_unlimited);
  }
}

/// An error that is reported passes gates and chi square when it is put in; 2 % more does not.
TEST(Reliability, IsWhereTheGatesEnd) {
  GateLimits limits = default_gate_limits();
  limits.residual = um(20);
  const std::vector<Eigen::Vector2d> places_mm = {{0, 0}, {120, 5}, {-3, 90}};
  const double most = largest_noncentrality(1, 1, kUnseenChance);
  const auto passes = [&](const UnseenError& error, double factor) {
    auto pairs = seen_at(places_mm);
    auto& place = pairs[error.i_target].measured.position;
    place = position_mm<frame::Base>(place.in_mm() + factor * error.error_mm);
    const CheckedFit fit =
        fit_panel(std::span<const CheckedPair>(pairs), PanelModel::Stretch).fit.value();
    return all_accepted(check_gates(fit, limits)) && fit.chi_square <= most;
  };
  const Reliability three = of(places_mm, PanelModel::Stretch, limits);
  ASSERT_EQ(three.unseen.size(), 36U);
  for (const UnseenError& error : three.unseen) {
    EXPECT_TRUE(passes(error, 0.98) || passes(error, -0.98)) << error.error_mm;
    EXPECT_FALSE(passes(error, 1.02) || passes(error, -1.02)) << error.error_mm;
  }
}

TEST(Reliability, LimitsTheNoiseByWhatChiSquareHides) {
  auto pairs = seen_at({{0, 0}, {50, 0}, {100, 0}, {0, 100}, {50, 100}, {100, 100}});
  CheckedFit fit = fit_panel(std::span<const CheckedPair>(pairs), PanelModel::Stretch).fit.value();
  fit.chi_square = 7;
  const Reliability six = reliability(fit, default_gate_limits());
  EXPECT_TRUE(six.can_be_stated());
  // Chi square of 7 degrees is below 1.239 in 1 of 100 (Abramowitz and Stegun, table 26.8).
  EXPECT_NEAR(six.noise_ratio2, 7 / 1.239, 1e-2);
  fit.chi_square = 0.5;
  EXPECT_EQ(reliability(fit, default_gate_limits()).noise_ratio2, 1);
}

TEST(Reliability, OfASlotIsAlongWhatItShows) {
  auto pairs = seen_at({{0, 0}, {100, 0}, {0, 100}, {100, 100}, {50, 0}});
  pairs[4].axes = ObservedAxes::X;
  const CheckedFit fit =
      fit_panel(std::span<const CheckedPair>(pairs), PanelModel::Stretch).fit.value();
  for (const UnseenError& error : reliability(fit, default_gate_limits()).unseen) {
    if (error.i_target == 4) {
      EXPECT_EQ(error.error_mm.y(), 0);
    }
  }
}

}  // namespace
}  // namespace panelcal
