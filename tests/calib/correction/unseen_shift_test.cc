// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/unseen_shift.h"

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

constexpr double kUnseenSigma_mm = 1e-3;

template <class To, class From>
PanelFit<To, From> fit_of(const std::vector<Eigen::Vector2d>& places_mm,
                          const Eigen::Vector2d& error_of_first_mm = Eigen::Vector2d::Zero()) {
  std::vector<TargetPair<To, From>> pairs;
  for (const Eigen::Vector2d& p_mm : places_mm) {
    const Eigen::Vector2d seen_mm = pairs.empty() ? p_mm + error_of_first_mm : p_mm;
    pairs.push_back({position_mm<From>(p_mm),
                     {position_mm<To>(seen_mm),
                      kUnseenSigma_mm * kUnseenSigma_mm * Eigen::Matrix2d::Identity()}});
  }
  return fit_panel(std::span<const TargetPair<To, From>>(pairs), PanelModel::Stretch).fit.value();
}

const std::vector<Eigen::Vector2d> kPanel = {{0, 0}, {200, 0}, {0, 150}, {200, 150}};
const std::vector<Eigen::Vector2d> kBoard = {{90, 60}, {110, 60}, {90, 80}, {110, 80}};

double largest_um(const std::vector<UnseenShift>& shifts, bool is_nested, double x, double y) {
  double out = 0;
  for (const UnseenShift& shift : shifts) {
    if (shift.is_nested != is_nested) continue;
    out = std::max(out, shift_at(shift, position_mm<frame::Nominal>(x, y)).in_um());
  }
  return out;
}

/// A hole moves by the reported shift when the error is put in.
TEST(UnseenShift, IsWhatTheErrorDoesToAHole) {
  const GateLimits limits = default_gate_limits();
  const auto fit = std::make_shared<const BaseFit>(fit_of<frame::Base, frame::Nominal>(kPanel));
  const Reliability checked = reliability(*fit, limits);
  CorrectionStack stack;
  stack.set_base(fit);
  const auto hole = position_mm<frame::Nominal>(30., 20.);
  int n_first = 0;
  for (const UnseenShift& shift : unseen_shifts(stack, &checked, nullptr)) {
    if (shift.error->i_target != 0) continue;
    ++n_first;
    const auto moved = fit_of<frame::Base, frame::Nominal>(kPanel, shift.error->error_mm);
    const double moved_um = (moved.map.map(hole) - fit->map.map(hole)).in_mm().norm() * 1e3;
    EXPECT_NEAR(shift_at(shift, hole).in_um(), moved_um, 1e-3 * moved_um + 1e-6);
  }
  EXPECT_EQ(n_first, 12);
}

/// Far from the targets an error of one is worse than at it.
TEST(UnseenShift, GrowsAwayFromTheTargets) {
  const auto fit = std::make_shared<const BaseFit>(fit_of<frame::Base, frame::Nominal>(kPanel));
  const Reliability checked = reliability(*fit, default_gate_limits());
  CorrectionStack stack;
  stack.set_base(fit);
  const auto shifts = unseen_shifts(stack, &checked, nullptr);
  EXPECT_GT(largest_um(shifts, false, 0, 0), largest_um(shifts, false, 100, 75));
  EXPECT_GT(largest_um(shifts, false, -200, -150), 2 * largest_um(shifts, false, 0, 0));
  const auto at = position_mm<frame::Nominal>(0., 0.);
  ASSERT_NE(furthest(shifts, at), nullptr);
  EXPECT_NEAR(shift_at(*furthest(shifts, at), at).in_um(), largest_um(shifts, false, 0, 0), 1e-9);
}

/// A nested fit takes back what the base fit has wrong; what its own targets have wrong stays.
TEST(UnseenShift, OfTheBaseIsTakenBackByTheNestedFit) {
  const auto base = std::make_shared<const BaseFit>(fit_of<frame::Base, frame::Nominal>(kPanel));
  const auto nested = std::make_shared<const NestedFit>(fit_of<frame::Actual, frame::Base>(kBoard));
  const Reliability of_base = reliability(*base, default_gate_limits());
  const Reliability of_nested = reliability(*nested, default_gate_limits());
  CorrectionStack stack;
  stack.set_base(base);
  const double alone_um = largest_um(unseen_shifts(stack, &of_base, nullptr), false, 100, 70);
  stack.set_nested(nested);
  const auto shifts = unseen_shifts(stack, &of_base, &of_nested);
  EXPECT_LT(largest_um(shifts, false, 100, 70), 0.1 * alone_um);
  EXPECT_GT(largest_um(shifts, true, 90, 60), 1);
}

TEST(UnseenShift, NoiseThatChiSquareHidesWidensTheFit) {
  BaseFit fit = fit_of<frame::Base, frame::Nominal>(kPanel);
  const auto shared = std::make_shared<const BaseFit>(fit);
  Reliability checked = reliability(fit, default_gate_limits());
  checked.noise_ratio2 = 5;
  CorrectionStack stack;
  stack.set_base(shared);
  EXPECT_TRUE(unseen_noise_cov(stack, &checked, nullptr).isApprox(4 * fit.map.cov, 1e-6));
}

TEST(UnseenShift, OfNoCorrectionIsNone) {
  EXPECT_TRUE(unseen_shifts(CorrectionStack(), nullptr, nullptr).empty());
  EXPECT_EQ(furthest({}, position_mm<frame::Nominal>(0., 0.)), nullptr);
}

}  // namespace
}  // namespace panelcal
