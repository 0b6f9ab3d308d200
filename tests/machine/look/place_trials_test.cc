// SPDX-License-Identifier: Apache-2.0
#include "machine/look/place_trials.h"

#include <cmath>
#include <string>

#include "machine/sim/sim_plate.h"
#include <gmock/gmock.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

class PlaceTrialsTest : public ::testing::Test {
 protected:
  void make(const std::string& sim, SimPlateOptions options = {}) {
    const auto config =
        test::config_with_camera(folder_.path(), test::test_camera(160, 120), R"([machine]
travel_low_mm = [0, 0]
travel_high_mm = [600, 500]
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 0.4
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.0, -3.0]
[sim]
seed = 5
noise = 2
)" + sim);
    ASSERT_TRUE(config) << config.error().text();
    config_ = *config;
    options.marks = {kMark};
    auto made = SimPlate::create(config_, std::move(options));
    ASSERT_TRUE(made) << made.error().text();
    machine_.emplace(*std::move(made));
  }
  CalibrationDevices devices() {
    return CalibrationDevices{*machine_,
                              *machine_,
                              *machine_,
                              [this](Time time) { machine_->wait(time); },
                              {},
                              {},
                              [this] { return machine_->now(); }};
  }

  static inline const Position<frame::Machine> kMark = position_mm<frame::Machine>(300.02, 199.97);
  static inline const Position<frame::Machine> kPlace = position_mm<frame::Machine>(300, 200);
  test::TemporaryFolder folder_;
  MachineConfig config_;
  std::optional<SimPlate> machine_;
};

TEST_F(PlaceTrialsTest, FindsTheHeightOfBestFocus) {
  make("focus_z_mm = 0.137\nfocus_depth_mm = 0.2\n");
  const auto result = calibrate_focus(config_, devices(), kPlace, 1, {mm(-1), mm(1)});
  ASSERT_TRUE(result) << result.error().text();
  ASSERT_TRUE(result->is_found) << result->reason;
  EXPECT_NEAR(result->z.in_mm(), 0.137, 4 * result->sigma.in_mm());
  EXPECT_LT(result->sigma, mm(0.02));
  EXPECT_GE(result->curve.size(), 11u);
}

TEST_F(PlaceTrialsTest, SaysThatNothingCanFocus) {
  make("");
  EXPECT_THAT(calibrate_focus(config_, devices(), kPlace, 1, {mm(-1), mm(1)}),
              FailsWith(Code::ConfigValue, "focus"));
  EXPECT_THAT(calibrate_focus(config_, devices(), kPlace, 1, {mm(1), mm(1)}),
              FailsWith(Code::ConfigValue, "range"));
}

TEST_F(PlaceTrialsTest, FindsTheBrightestLampThatDoesNotClip) {
  // The disc has 0.7 of full scale at lamp 50, so it reaches the end at 71.4; with the lens' blur
  // and the noise of 2 levels nothing clips at 69, and its contrast is 0.4 x level / 50.
  make("lamp = 50\nbackground = 0.3\ntarget_level = 0.7\n");
  std::vector<double> levels;
  for (double level = 15; level <= 90; level += 6) levels.push_back(level);
  const auto run = calibrate_light(config_, devices(), kPlace, 1, levels);
  ASSERT_TRUE(run) << run.error().text();
  ASSERT_TRUE(run->best) << run->reason;
  EXPECT_EQ(run->best->level, 69);
  EXPECT_NEAR(run->best->contrast, 0.4 * 69 / 50, 0.01);
  EXPECT_FALSE(run->best->is_at_end);
  ASSERT_EQ(run->samples.size(), levels.size());
  EXPECT_EQ(run->samples[0].clipped_share, 0);
  EXPECT_GT(run->samples.back().clipped_share, 0.01);
}

TEST_F(PlaceTrialsTest, RefusesLampLevelsThatAreNone) {
  make("");
  EXPECT_THAT(calibrate_light(config_, devices(), kPlace, 1, {10, 20, 30}),
              FailsWith(Code::ConfigValue, "lamp"));
  make("lamp = 50\n");
  EXPECT_THAT(calibrate_light(config_, devices(), kPlace, 1, {10, 20}),
              FailsWith(Code::ConfigValue, "3 to"));
  EXPECT_THAT(calibrate_light(config_, devices(), kPlace, 1, {10, 30, 20}),
              FailsWith(Code::ConfigValue, "ascending"));
  EXPECT_THAT(calibrate_light(config_, devices(), kPlace, 7, {10, 20, 30}),
              FailsWith(Code::VisionToolUndefined, "7"));
}

TEST_F(PlaceTrialsTest, FindsHowLongTheStageSwings) {
  SimPlateOptions options;
  options.swing = um(40);
  options.swing_decay = seconds(0.06);
  options.swing_hz = 11;
  make("", options);
  SettleTrial trial;
  trial.longest = seconds(0.6);
  trial.n_delays = 24;
  const auto run = calibrate_settle(config_, devices(), kPlace, trial);
  ASSERT_TRUE(run) << run.error().text();
  EXPECT_EQ(run->n_missed, 0);
  ASSERT_TRUE(run->settle) << run->reason;
  EXPECT_EQ(run->settle->motion, SettleMotion::Vibrating);
  // 40 um exp(-t / 0.06 s) = 1 um at t = 0.06 ln 40.
  EXPECT_NEAR(run->settle->wait.in_s(), 0.06 * std::log(40), 4 * run->settle->sigma.in_s());
  EXPECT_NEAR(run->settle->frequency_hz, 11, 0.5);
  EXPECT_LT(run->settle->sigma, seconds(0.03));
}

TEST_F(PlaceTrialsTest, SaysWhatKeepsItFromTryingSettleTimes) {
  make("");
  CalibrationDevices no_wait{*machine_, *machine_, *machine_, {}, {}};
  EXPECT_THAT(calibrate_settle(config_, no_wait, kPlace, {}),
              FailsWith(Code::ConfigValue, "settling time"));
  SettleTrial trial;
  trial.n_delays = 2;
  EXPECT_THAT(calibrate_settle(config_, devices(), kPlace, trial),
              FailsWith(Code::ConfigValue, "delays"));
  // Here the camera can stand, and where the trial begins it cannot.
  EXPECT_THAT(calibrate_settle(config_, devices(), position_mm<frame::Machine>(50, 200), {}),
              FailsWith(Code::TravelExceeded, "(-5.000"));
}

}  // namespace
}  // namespace panelcal
