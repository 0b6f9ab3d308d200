// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/spindle/calibration.h"

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/calib/spindle/simulated_coupon.h"
#include "tests/machine/calibrate/spindle/coupon_job.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::ElementsAre;

class SpindleCalibrationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto config = test::coupon_machine(folder_.path());
    ASSERT_TRUE(config) << config.error().text();
    config_ = *config;
  }
  SimCoupon machine(const SimCouponOptions& options) {
    auto made = SimCoupon::create(config_, options);
    EXPECT_TRUE(made) << made.error().text();
    return *std::move(made);
  }

  test::TemporaryFolder folder_;
  MachineConfig config_;
};

TEST_F(SpindleCalibrationTest, FindsTheTrueOffsetFromPicturesOfDrilledHoles) {
  SimCouponOptions options = test::usual_scatter(3);
  options.backlash = displacement_mm<frame::Machine>(0.006, 0.004);
  SimCoupon machine = this->machine(options);
  const auto sights = test::run_coupon(config_, test::three_by_three(), machine);
  ASSERT_TRUE(sights) << sights.error().text();
  EXPECT_TRUE(sights->missed.empty());
  ASSERT_EQ(sights->holes.size(), 9u);
  const auto result = fit_spindle_camera(sights->holes, fit_options(config_));
  ASSERT_TRUE(result.fit) << text(result.failure);
  const Eigen::Vector2d truth_mm = machine.true_offset().offset.in_mm();
  EXPECT_EQ(truth_mm, Eigen::Vector2d(45.03, -2.98));
  // 1 in 1000 of a chi-square of two degrees of freedom.
  EXPECT_LT(test::squared_error(result.fit->offset, truth_mm), 13.8);
  EXPECT_LT(result.fit->offset.cov_mm2.diagonal().maxCoeff(), 1.5e-3 * 1.5e-3);
  EXPECT_NEAR(result.fit->backlash[0].value.in_um(), 6, 4 * result.fit->backlash[0].sigma.in_um());
  EXPECT_NEAR(result.fit->backlash[1].value.in_um(), 4, 4 * result.fit->backlash[1].sigma.in_um());
  // Residuals are where the drill went astray.
  for (std::size_t i = 0; i < 9; ++i) {
    const Eigen::Vector2d astray_mm =
        (machine.holes()[i] - sights->holes[i].drilled).in_mm() + Eigen::Vector2d(0.003, 0.002);
    EXPECT_NEAR(result.fit->holes[i].residual.in_mm().x(), astray_mm.x(), 5e-3);
    EXPECT_NEAR(result.fit->holes[i].residual.in_mm().y(), astray_mm.y(), 5e-3);
  }
}

TEST_F(SpindleCalibrationTest, AMissedHoleIsReportedAndNotMadeUp) {
  SimCoupon machine = this->machine(test::usual_scatter(3));
  const Coupon coupon = test::three_by_three();
  auto places = places_of_row(coupon, 0);
  // The drill broke after the eighth hole.
  ASSERT_TRUE(drill_coupon(config_, coupon, std::span(places).first(8), machine, machine, {}));
  const auto sights = look_at_coupon(config_, coupon, places, {machine, machine, {}});
  ASSERT_TRUE(sights) << sights.error().text();
  EXPECT_THAT(sights->i_place, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  ASSERT_EQ(sights->missed.size(), 4u);
  EXPECT_EQ(sights->missed.front().i_place, 8u);
  EXPECT_FALSE(sights->missed.front().reason.empty());
}

/// Writes down what the machine is told.
class Recorder final : public Stage, public Spindle {
 public:
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    const Eigen::Vector2d& p_mm = spindle.in_mm();
    log += fmt::format("{},{} ", p_mm.x(), p_mm.y());
    return spindle;
  }
  Expected<void> drill(int tool) override {
    log += fmt::format("T{} ", tool);
    return {};
  }
  std::string log;
};

TEST_F(SpindleCalibrationTest, DrillsFromTheStatedSideBetweenThePrompts) {
  Coupon coupon = test::three_by_three();
  coupon.drill_tool = 4;
  coupon.drilling = {1, -1};
  coupon.has_entry_material = true;
  Recorder machine;
  const Prompt prompt = [&](std::string_view what) -> Expected<void> {
    machine.log += "[" + std::string(what) + "] ";
    return {};
  };
  const std::vector<Position<frame::Machine>> places = {position_mm<frame::Machine>(10, 20)};
  ASSERT_TRUE(drill_coupon(config_, coupon, places, machine, machine, prompt));
  EXPECT_EQ(machine.log,
            "[lay entry material on the coupon] 9,21 10,20 T4 [take the entry material off the "
            "coupon] ");
}

TEST_F(SpindleCalibrationTest, NothingIsDrilledWhereNobodyLaysEntryMaterial) {
  Coupon coupon = test::three_by_three();
  coupon.has_entry_material = true;
  Recorder machine;
  const Prompt nobody = [](std::string_view what) -> Expected<void> {
    return failure(
        {Code::DeviceStage, {"coupon", 0, 0}, "no person at the terminal", std::string(what)});
  };
  const auto places = places_of_row(coupon, 0);
  EXPECT_THAT(drill_coupon(config_, coupon, places, machine, machine, nobody),
              FailsWith(Code::DeviceStage));
  EXPECT_THAT(drill_coupon(config_, coupon, places, machine, machine, {}),
              FailsWith(Code::DeviceStage));
  EXPECT_EQ(machine.log, "");
}

TEST_F(SpindleCalibrationTest, NothingMovesIfAPlaceIsOutsideTheTravel) {
  Coupon coupon = test::three_by_three();
  // The holes are inside; the start of the approach to the last one is not.
  coupon.drilling = {-1, 1};
  coupon.origin = position_mm<frame::Machine>(589.5, 100);
  Recorder recorder;
  const auto places = places_of_row(coupon, 0);
  EXPECT_THAT(drill_coupon(config_, coupon, places, recorder, recorder, {}),
              FailsWith(Code::TravelExceeded, "(600.500"));
  EXPECT_EQ(recorder.log, "");
  coupon = test::three_by_three();
  coupon.origin = position_mm<frame::Machine>(30, 100);  // the camera would need x = -15
  SimCoupon machine = this->machine(test::usual_scatter(3));
  EXPECT_THAT(look_at_coupon(config_, coupon, places_of_row(coupon, 0), {recorder, machine, {}}),
              FailsWith(Code::TravelExceeded, "(-1"));
  EXPECT_EQ(recorder.log, "");
}

TEST_F(SpindleCalibrationTest, WaitsForTheMachineBeforeEveryPicture) {
  Coupon coupon = test::three_by_three();
  coupon.looking = {{1, 1}, {-1, -1}};
  SimCoupon machine = this->machine(test::usual_scatter(3));
  int n_waits = 0;
  const auto places = places_of_row(coupon, 0);
  ASSERT_TRUE(drill_coupon(config_, coupon, places, machine, machine, {}));
  const auto wait = [&](Time time) {
    EXPECT_EQ(time, seconds(0.25));
    ++n_waits;
  };
  ASSERT_TRUE(look_at_coupon(config_, coupon, places, {machine, machine, wait}));
  EXPECT_EQ(n_waits, 18);
}

TEST_F(SpindleCalibrationTest, RefusesAnUnknownVisionTool) {
  Coupon coupon = test::three_by_three();
  coupon.vision_tool = 7;
  SimCoupon machine = this->machine(test::usual_scatter(3));
  EXPECT_THAT(look_at_coupon(config_, coupon, places_of_row(coupon, 0), {machine, machine, {}}),
              FailsWith(Code::VisionToolUndefined, "7"));
  SimCouponOptions options;
  options.vision_tool = 7;
  EXPECT_THAT(SimCoupon::create(config_, options), FailsWith(Code::VisionToolUndefined, "7"));
}

TEST_F(SpindleCalibrationTest, ExpectsTheScatterThatTheMachineFileStates) {
  EXPECT_FALSE(fit_options(config_).expected_wander);
  const auto config = test::coupon_machine(
      folder_.path(), "[uncertainty]\ndrill_wander_um = 3\nstage_repeatability_um = 4\n");
  ASSERT_TRUE(config) << config.error().text();
  // Every hole was drilled at one stop of the stage.
  EXPECT_NEAR(fit_options(*config).expected_wander->in_um(), 5, 1e-9);
  EXPECT_EQ(fit_options(*config).expected_repeatability, um(4));
}

}  // namespace
}  // namespace panelcal
