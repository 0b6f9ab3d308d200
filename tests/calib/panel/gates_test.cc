// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/gates.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include <gmock/gmock.h>

#include "tests/calib/panel/synthetic_panel.h"

namespace panelcal {
namespace {

using internal::check_gates_raw;
using testing::ElementsAre;
using testing::Field;

using Pair = TargetPair<frame::Actual, frame::Nominal>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

GateLimits all_limits() {
  return {.residual = um(25), .rotation = rad(0.005), .stretch_ppm = 300.0, .offset = mm(2)};
}

Eigen::Matrix2d stretched(double theta_rad, double sx, double sy) {
  return test::rotation(theta_rad) * Eigen::Vector2d(sx, sy).asDiagonal();
}

TEST(Gates, HoldEveryNumberAgainstItsLimit) {
  const std::vector<double> residuals_mm = {0.010, 0.0613, 0.020};
  const std::vector<GateVerdict> verdicts =
      check_gates_raw(stretched(-0.004, 1.0001, 0.9996), {1.2, -1.6}, residuals_mm, all_limits());
  ASSERT_THAT(verdicts,
              ElementsAre(Field(&GateVerdict::gate, "residual"),
                          Field(&GateVerdict::gate, "rotation"),
                          Field(&GateVerdict::gate, "stretch"),
                          Field(&GateVerdict::gate, "offset")));
  EXPECT_THAT(verdicts,
              ElementsAre(Field(&GateVerdict::accepted, false),
                          Field(&GateVerdict::accepted, true),
                          Field(&GateVerdict::accepted, false),
                          Field(&GateVerdict::accepted, true)));
  EXPECT_EQ(verdicts[0].i_target, 1U);
  EXPECT_EQ(verdicts[0].text(), "residual of target 2 is 61.3 um, limit 25.0 um");
  EXPECT_EQ(verdicts[1].text(), "rotation is 4.000 mrad, limit 5.000 mrad");
  EXPECT_EQ(verdicts[2].text(), "stretch is 400.0 ppm, limit 300.0 ppm");
  EXPECT_EQ(verdicts[3].text(), "offset is 2.000 mm, limit 2.000 mm");
  EXPECT_FALSE(all_accepted(verdicts));
}

TEST(Gates, CheckOnlyWhatHasALimit) {
  EXPECT_THAT(check_gates_raw(stretched(1, 2, 3), {100, 100}, {}, {}), testing::IsEmpty());
  EXPECT_TRUE(all_accepted({}));
  const auto verdicts = check_gates_raw(stretched(1, 2, 3), {0, 0}, {}, {.rotation = rad(2)});
  EXPECT_THAT(verdicts, ElementsAre(Field(&GateVerdict::gate, "rotation")));
  EXPECT_TRUE(all_accepted(verdicts));
}

TEST(Gates, AcceptTheLimitItself) {
  const std::vector<double> residuals_mm = {0.025};
  const auto verdicts =
      check_gates_raw(Eigen::Matrix2d::Identity(), {0, 0}, residuals_mm, {.residual = um(25)});
  EXPECT_TRUE(verdicts[0].accepted);
}

TEST(Gates, ShowWhatARefusedValueExceedsItsLimitBy) {
  const std::vector<double> residuals_mm = {0.0250004};
  const auto verdicts =
      check_gates_raw(Eigen::Matrix2d::Identity(), {0, 0}, residuals_mm, {.residual = um(25)});
  EXPECT_EQ(verdicts[0].text(), "residual of target 1 is 25.0004 um, limit 25.0000 um");
}

TEST(Gates, ShareTheRateOfAJobAmongItsSeries) {
  GateLimits limits;
  limits.rotation = rad(0.01);
  EXPECT_FALSE(share_false_alarm(limits, 10).false_alarm);
  limits.false_alarm = 1e-3;
  EXPECT_EQ(share_false_alarm(limits, 0).false_alarm, 1e-3);
  EXPECT_EQ(share_false_alarm(limits, 1).false_alarm, 1e-3);
  const GateLimits shared = share_false_alarm(limits, 10);
  EXPECT_DOUBLE_EQ(shared.false_alarm.value(), 1e-4);
  EXPECT_EQ(shared.rotation, limits.rotation);
}

TEST(Gates, CountShearAsStretch) {
  Eigen::Matrix2d sheared;
  sheared << 1, -0.001, 0, 1;
  const auto verdicts = check_gates_raw(sheared, {0, 0}, {}, {.stretch_ppm = 999.0});
  EXPECT_NEAR(verdicts[0].value, 1000, 1e-9);
  EXPECT_FALSE(verdicts[0].accepted);
}

TEST(Gates, RefuseAMirroredPanel) {
  const auto verdicts = check_gates_raw(stretched(0, 1, -1), {0, 0}, {}, {.stretch_ppm = 1000.0});
  EXPECT_FALSE(verdicts[0].accepted);
  EXPECT_NEAR(verdicts[0].value, 2e6, 1e-6);
}

TEST(Gates, HaveDefaultsThatHoldAPanelTwoPercentLarger) {
  const GateLimits limits = default_gate_limits();
  EXPECT_EQ(limits.residual, um(100));
  EXPECT_EQ(limits.rotation, deg(3));
  EXPECT_EQ(limits.stretch_ppm, 2000);
  EXPECT_EQ(limits.false_alarm, 1e-3);
  EXPECT_TRUE(limits.refuses_mirror);
  EXPECT_FALSE(limits.offset);
  EXPECT_FALSE(all_accepted(check_gates_raw(stretched(0, 1.02, 1), {0, 0}, {}, limits)));
}

TEST(Gates, NameThoseThatAreOff) {
  GateLimits limits = default_gate_limits();
  EXPECT_THAT(gates_off(limits), testing::IsEmpty());
  EXPECT_EQ(gates_text(limits),
            "residual 100 um, rotation 52.3599 mrad, stretch 2000 ppm, false alarm 0.001, no "
            "mirror");
  limits.residual.reset();
  limits.refuses_mirror = false;
  limits.offset = mm(1.5);
  limits.turned_deg = 180;
  EXPECT_THAT(gates_off(limits), ElementsAre("residual", "mirror"));
  EXPECT_EQ(gates_text(limits),
            "rotation 52.3599 mrad from 180 degrees, stretch 2000 ppm, offset 1.5 mm, false alarm "
            "0.001; off: residual, mirror");
  limits = {.refuses_mirror = false};
  EXPECT_EQ(gates_text(limits), "off: residual, rotation, stretch, false alarm, mirror");
}

TEST(Gates, TakeAPanelThatIsMeantToLieTurned) {
  constexpr double kRight_rad = std::numbers::pi / 2;
  for (const int turned_deg : {0, 90, 180, 270}) {
    const double meant_rad = kRight_rad * turned_deg / 90;
    GateLimits limits = default_gate_limits();
    for (const int lies_deg : {0, 90, 180, 270}) {
      limits.turned_deg = lies_deg;
      const auto verdicts =
          check_gates_raw(stretched(meant_rad + 0.04, 1.0001, 0.9996), {0, 0}, {}, limits);
      EXPECT_EQ(all_accepted(verdicts), lies_deg == turned_deg) << turned_deg << lies_deg;
    }
    const Eigen::Vector2d place_mm(3, 1);
    EXPECT_LT((turned_by(place_mm, turned_deg) - test::rotation(meant_rad) * place_mm).norm(),
              1e-12);
  }
}

TEST(Gates, TakeTheOffsetFromWhereThePanelIsMeantToLie) {
  std::vector<Pair> pairs;
  for (const Eigen::Vector2d& p_mm :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(100, 0), Eigen::Vector2d(0, 80)}) {
    pairs.push_back({position_mm<frame::Nominal>(p_mm),
                     {position_mm<frame::Actual>(turned_by(p_mm, 90) + Eigen::Vector2d(0.3, 0.4)),
                      1e-6 * Eigen::Matrix2d::Identity()}});
  }
  const auto result = fit_panel(std::span<const Pair>(pairs), PanelModel::Rigid);
  ASSERT_TRUE(result.fit.has_value());
  const auto verdicts = check_gates(*result.fit, {.offset = mm(1), .turned_deg = 90});
  ASSERT_EQ(verdicts.size(), 1U);
  EXPECT_NEAR(verdicts[0].value, 0.5, 1e-9);
}

TEST(Gates, TakeAPanelThatIsMeantToLieTurnedOver) {
  GateLimits limits = default_gate_limits();
  limits.refuses_mirror = false;
  for (const Eigen::Vector2d& scale : {Eigen::Vector2d(1.0001, -1), Eigen::Vector2d(-1.0001, 1)}) {
    const Eigen::Matrix2d over = test::rotation(0.04) * scale.asDiagonal();
    EXPECT_TRUE(all_accepted(check_gates_raw(over, {0, 0}, {}, limits)));
  }
  limits.residual.reset();
  const auto verdicts = check_gates_raw(stretched(0.06, 1, -1.003), {0, 0}, {}, limits);
  ASSERT_EQ(verdicts.size(), 2U);
  EXPECT_NEAR(verdicts[0].value, 60, 1e-9);
  EXPECT_NEAR(verdicts[1].value, 3000, 1e-6);
  EXPECT_FALSE(verdicts[0].accepted || verdicts[1].accepted);
}

TEST(Gates, RefuseWhatIsNotANumber) {
  Eigen::Matrix2d broken = Eigen::Matrix2d::Identity();
  broken(1, 1) = kNan;
  const std::vector<double> residuals_mm = {0.01, kNan, 0.02};
  GateLimits limits = all_limits();
  limits.rotation.reset();
  for (const GateVerdict& v : check_gates_raw(broken, {0, kNan}, residuals_mm, limits)) {
    EXPECT_FALSE(v.accepted) << v.text();
  }
}

TEST(Gates, TakeTheOffsetAtTheTargetsNotAtWorkZero) {
  // A turn about a far corner moves work zero a lot and the targets hardly.
  std::vector<Pair> pairs;
  const Eigen::Vector2d pivot_mm(1000, 1000);
  for (const Eigen::Vector2d& d_mm :
       {Eigen::Vector2d(-50, -50), Eigen::Vector2d(50, -50), Eigen::Vector2d(0, 100)}) {
    const Eigen::Vector2d seen_mm = pivot_mm + test::rotation(0.01) * d_mm;
    pairs.push_back({position_mm<frame::Nominal>(pivot_mm + d_mm),
                     {position_mm<frame::Actual>(seen_mm), 1e-6 * Eigen::Matrix2d::Identity()}});
  }
  const auto result = fit_panel(std::span<const Pair>(pairs), PanelModel::Rigid);
  ASSERT_TRUE(result.fit.has_value());
  const auto verdicts = check_gates(*result.fit, all_limits());
  ASSERT_EQ(verdicts.size(), 4U);
  EXPECT_TRUE(verdicts[0].accepted);
  EXPECT_NEAR(verdicts[1].value, 10, 1e-9);
  EXPECT_FALSE(verdicts[1].accepted);
  EXPECT_TRUE(verdicts[3].accepted) << verdicts[3].text();
}

Pair slot(ObservedAxes axes, const Eigen::Vector2d& nominal_mm, const Eigen::Vector2d& seen_mm) {
  const Eigen::Vector2d shown_mm(observes_x(axes) ? seen_mm.x() : kNan,
                                 observes_y(axes) ? seen_mm.y() : kNan);
  return {position_mm<frame::Nominal>(nominal_mm),
          {position_mm<frame::Actual>(shown_mm), 1e-6 * Eigen::Matrix2d::Identity()},
          axes};
}

TEST(Gates, TakeTheResidualOfASlotInTheCoordinateItShows) {
  // Three slots show x; one is 90 um off, of which the mean takes up a third.
  const std::vector<Pair> pairs = {slot(ObservedAxes::X, {0, 0}, {0, 0}),
                                   slot(ObservedAxes::Y, {100, 0}, {100, 0.020}),
                                   slot(ObservedAxes::X, {0, 100}, {0.090, 100}),
                                   slot(ObservedAxes::X, {50, 100}, {50, 100})};
  const auto result = fit_panel(std::span<const Pair>(pairs), PanelModel::Offset);
  ASSERT_TRUE(result.fit.has_value());
  const auto verdicts = check_gates(*result.fit, {.residual = um(59)});
  ASSERT_EQ(verdicts.size(), 1U);
  EXPECT_EQ(verdicts[0].i_target, 2U);
  EXPECT_NEAR(verdicts[0].value, 60, 1e-9);
  EXPECT_FALSE(verdicts[0].accepted);
}

TEST(Gates, TakeTheOffsetOfSlotsWhereTheyAllLie) {
  // Slots for x along the top, slots for y along the right, turned about the panel's middle: each
  // kind moves by 4 mrad of its lever, 0.76 mm and 0.92 mm, yet the middle of all by less.
  constexpr double kTheta_rad = 0.004;
  const Eigen::Vector2d pivot_mm(250, 200);
  const auto turned = [&](const Eigen::Vector2d& p_mm) {
    return Eigen::Vector2d(pivot_mm + test::rotation(kTheta_rad) * (p_mm - pivot_mm));
  };
  std::vector<Pair> pairs;
  Eigen::Vector2d centroid_mm = Eigen::Vector2d::Zero();
  const auto add = [&](ObservedAxes axes, const Eigen::Vector2d& p_mm) {
    pairs.push_back(slot(axes, p_mm, turned(p_mm)));
    centroid_mm += p_mm / 4;
  };
  add(ObservedAxes::X, {200, 390});
  add(ObservedAxes::X, {300, 390});
  add(ObservedAxes::Y, {480, 150});
  add(ObservedAxes::Y, {480, 250});
  // So far both kinds are degenerate; a target at the middle of all determines the rotation.
  const Eigen::Vector2d middle_mm = centroid_mm;
  pairs.push_back(slot(ObservedAxes::Both, middle_mm, turned(middle_mm)));
  const auto result = fit_panel(std::span<const Pair>(pairs), PanelModel::Rigid);
  ASSERT_TRUE(result.fit.has_value());
  const auto verdicts = check_gates(*result.fit, {.offset = mm(0.7)});
  ASSERT_EQ(verdicts.size(), 1U);
  const double expected_mm = 2 * std::sin(kTheta_rad / 2) * (middle_mm - pivot_mm).norm();
  EXPECT_NEAR(verdicts[0].value, expected_mm, 1e-9);
  EXPECT_TRUE(verdicts[0].accepted) << verdicts[0].text();
}

}  // namespace
}  // namespace panelcal
