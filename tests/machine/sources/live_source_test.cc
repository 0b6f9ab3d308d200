// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/live_source.h"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "machine/sim/sim_coupon.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/calibrate/spindle/coupon_job_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::machine_with_coupon;
using test::TemporaryFolder;

/// One virtual machine behind the owners that a source wants.
class SharedStage final : public Stage {
 public:
  SharedStage(SimCoupon& machine, double growth) : machine_(machine), growth_(growth) {}
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    // A table that grows about the coupon between drilling and looking.
    const double factor = machine_.holes().size() >= 9 ? growth_ : 1;
    const Eigen::Vector2d middle_mm(305, 105);
    const Eigen::Vector2d stands_mm = middle_mm + factor * (spindle.in_mm() - middle_mm);
    PANELCAL_CHECK(machine_.move_to(position_mm<frame::Machine>(stands_mm)));
    return spindle;
  }

 private:
  SimCoupon& machine_;
  double growth_;
};

/// A camera with a focus axis.
class SharedCamera final : public CameraDevice {
 public:
  SharedCamera(SimCoupon& machine, std::optional<double>& focus_mm)
      : machine_(machine), focus_mm_(focus_mm) {}
  bool can_set(CameraSetting setting) const override { return setting == CameraSetting::Focus; }
  Expected<void> set(CameraSetting setting, double value) override {
    focus_mm_ = value;
    return machine_.set(setting, value);
  }
  Expected<Image> take() override { return machine_.take(); }
  std::string name() const override { return "shared"; }

 private:
  SimCoupon& machine_;
  std::optional<double>& focus_mm_;
};

class SharedSpindle final : public Spindle {
 public:
  SharedSpindle(SimCoupon& machine, bool can) : machine_(machine), can_(can) {}
  bool can_drill() const override { return can_; }
  Expected<void> drill(int tool) override { return machine_.drill(tool); }

 private:
  SimCoupon& machine_;
  bool can_;
};

class LiveSourceTest : public ::testing::Test {
 protected:
  LiveSource source(Prompt prompt = {}, bool can_drill = true, double growth = 1) {
    auto views = std::make_unique<CameraViews>(config_.spindle_camera,
                                               std::make_unique<SharedCamera>(machine_, focus_mm_),
                                               std::make_unique<SharedStage>(machine_, growth),
                                               config_.settle,
                                               [](Time) {});
    views->set_stated(config_.vision);
    auto made = LiveSource::create(config_,
                                   std::move(views),
                                   std::make_unique<SharedSpindle>(machine_, can_drill),
                                   std::move(prompt));
    EXPECT_TRUE(made) << made.error().text();
    return std::move(made).value();
  }
  static CalibrationOrder order() {
    CalibrationOrder order;
    order.line = 7;
    order.command = "G39";
    order.first_hole = position_mm<frame::Machine>(300, 100);
    return order;
  }
  /// Looks at a hole that the spindle drilled where it was sent.
  static Measurement look(LiveSource& source) {
    MeasurementRequest request;
    request.settings.tools = {1};
    request.nominal = position_mm<frame::Nominal>(400, 200);
    request.expected = position_mm<frame::Actual>(400, 200);
    const auto seen = source.measure(request);
    EXPECT_TRUE(seen) << seen.error().text();
    EXPECT_EQ(seen->status, MeasurementStatus::Found) << seen->reason;
    return *seen;
  }

  TemporaryFolder folder_;
  MachineConfig config_ = machine_with_coupon(folder_);
  SimCoupon machine_ = *SimCoupon::create(config_, test::usual_scatter(3));
  std::optional<double> focus_mm_;  ///< to which the camera was told to go last
};

TEST_F(LiveSourceTest, LooksThroughTheNewOffset) {
  LiveSource source = this->source();
  ASSERT_TRUE(machine_.move_to(position_mm<frame::Machine>(400, 200)));
  ASSERT_TRUE(machine_.drill(1));
  const Eigen::Vector2d hole_mm = machine_.holes().at(0).in_mm();
  const auto off_mm = [&](const Measurement& m) -> Eigen::Vector2d {
    return m.measured.position.in_mm() - hole_mm;
  };
  // Besides the stage's own 1 um.
  constexpr double kLook_mm = 0.005;
  EXPECT_NEAR(off_mm(look(source)).x(), -0.03, kLook_mm);
  const auto answer = source.calibrate(order());
  ASSERT_TRUE(answer) << answer.error().text();
  ASSERT_TRUE(*answer);
  EXPECT_LT(off_mm(look(source)).norm(), kLook_mm);
  EXPECT_EQ(machine_.holes().size(), 10U);
}

TEST_F(LiveSourceTest, LooksAtTheCouponWithTheFocusThatTheProgramFound) {
  config_.sim->focus_z = mm(1.5);
  config_.vision.focus_range = FocusRange{mm(1), mm(2)};
  config_.vision.focus = mm(1.1);  // for a program that does not focus
  machine_ = *SimCoupon::create(config_, test::usual_scatter(3));
  ASSERT_TRUE(machine_.move_to(position_mm<frame::Machine>(400, 200)));
  ASSERT_TRUE(machine_.drill(1));
  LiveSource source = this->source();
  MeasurementRequest request;
  request.seq = -1;
  request.expected = position_mm<frame::Actual>(400, 200);
  const auto focus = source.focus(request);
  ASSERT_TRUE(focus) << focus.error().text();
  ASSERT_TRUE((*focus)->is_found) << (*focus)->reason;
  const auto answer = source.calibrate(order());
  ASSERT_TRUE(answer) << answer.error().text();
  EXPECT_EQ(focus_mm_, (*focus)->z.in_mm());
}

TEST_F(LiveSourceTest, AsksForTheEntryMaterial) {
  config_.coupon->has_entry_material = true;
  std::vector<std::string> asked;
  LiveSource source = this->source([&](std::string_view what) -> Expected<void> {
    asked.emplace_back(what);
    return {};
  });
  ASSERT_TRUE(source.calibrate(order()));
  EXPECT_THAT(asked,
              testing::ElementsAre("lay entry material on the coupon",
                                   "take the entry material off the coupon"));
}

TEST_F(LiveSourceTest, WithoutADrillNobodyCalibrates) {
  LiveSource source = this->source({}, false);
  const auto answer = source.calibrate(order());
  ASSERT_TRUE(answer);
  EXPECT_FALSE(*answer);
  EXPECT_TRUE(machine_.holes().empty());
}

TEST_F(LiveSourceTest, RefusesACouponThatMovedBetweenDrillingAndLooking) {
  LiveSource source = this->source({}, true, 1.003);
  const auto answer = source.calibrate(order());
  EXPECT_THAT(answer, FailsWith(Code::CalibrationRefused, "calibration 0 (G39, line 7)"));
}

}  // namespace
}  // namespace panelcal
