// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/v4l2_controls.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <limits>
#include <map>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include "tests/support/matchers.h"

namespace panelcal::internal {
namespace {

using test::FailsWith;
using test::Reports;
using ::testing::IsEmpty;
using ::testing::SizeIs;

struct FakeControl {
  std::int32_t low = 0;
  std::int32_t high = 1;
  std::int32_t value = 0;
  std::int32_t step = 1;
  std::uint32_t flags = 0;
  int refuses = 0;      ///< errno of each order
  bool obeys = true;    ///< false: takes an order and stays as it is
  std::int32_t by = 0;  ///< added to what is ordered
};

/// The ioctls of one camera, as the media documentation describes them.
class FakeDevice {
 public:
  Ioctl ioctl() {
    return [this](unsigned long request, void* argument) { return answer(request, argument); };
  }
  FakeControl& operator[](std::uint32_t id) { return controls_[id]; }

  std::vector<std::uint32_t> ordered;  ///< ids, in order
  bool is_gone = false;
  int gone_after = std::numeric_limits<int>::max();  ///< calls until the cable is pulled

 private:
  int answer(unsigned long request, void* argument) {
    if (is_gone || gone_after-- <= 0) return ENODEV;
    if (request == VIDIOC_QUERYCTRL) return query(*static_cast<v4l2_queryctrl*>(argument));
    auto& control = *static_cast<v4l2_control*>(argument);
    const auto found = controls_.find(control.id);
    if (found == controls_.end()) return EINVAL;
    FakeControl& held = found->second;
    if (request == VIDIOC_G_CTRL) {
      control.value = held.value;
      return 0;
    }
    EXPECT_EQ(request, VIDIOC_S_CTRL);
    ordered.push_back(control.id);
    if (held.refuses != 0) return held.refuses;
    if (held.obeys) held.value = control.value + held.by;
    return 0;
  }

  int query(v4l2_queryctrl& query) const {
    const auto found = controls_.find(query.id);
    if (found == controls_.end()) return EINVAL;
    query.minimum = found->second.low;
    query.maximum = found->second.high;
    query.step = found->second.step;
    query.flags = found->second.flags;
    return 0;
  }

  std::map<std::uint32_t, FakeControl> controls_;
};

class V4l2Held : public ::testing::Test {
 protected:
  /// The controls of a usual USB camera, as it is plugged in: everything automatic.
  V4l2Held() {
    device_[V4L2_CID_FOCUS_AUTO] = {.value = 1};
    device_[V4L2_CID_FOCUS_ABSOLUTE] = {.high = 250, .value = 0, .step = 5};
    device_[V4L2_CID_EXPOSURE_AUTO] = {.high = 3, .value = V4L2_EXPOSURE_APERTURE_PRIORITY};
    device_[V4L2_CID_EXPOSURE_ABSOLUTE] = {.low = 3, .high = 2047, .value = 250};
    device_[V4L2_CID_EXPOSURE_AUTO_PRIORITY] = {.value = 1};
    device_[V4L2_CID_AUTO_WHITE_BALANCE] = {.value = 1};
    device_[V4L2_CID_WHITE_BALANCE_TEMPERATURE] = {.low = 2000, .high = 6500, .value = 4000};
    device_[V4L2_CID_GAIN] = {.high = 255, .value = 64};
    device_[V4L2_CID_POWER_LINE_FREQUENCY] = {.high = 2, .value = 2};
  }

  Expected<V4l2Controls> hold(const V4l2Settings& settings = {}) {
    return V4l2Controls::hold("v4l2:/dev/video0", device_.ioctl(), settings);
  }

  FakeDevice device_;
};

TEST_F(V4l2Held, EverythingAutomaticIsSwitchedOff) {
  const auto controls = hold();
  ASSERT_TRUE(controls) << controls.error().text();
  EXPECT_THAT(controls->risks(), IsEmpty());
  EXPECT_EQ(device_[V4L2_CID_FOCUS_AUTO].value, 0);
  EXPECT_EQ(device_[V4L2_CID_EXPOSURE_AUTO].value, V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(device_[V4L2_CID_EXPOSURE_AUTO_PRIORITY].value, 0);
  EXPECT_EQ(device_[V4L2_CID_AUTO_WHITE_BALANCE].value, 0);
  // What the address does not state stays as the camera has it.
  EXPECT_EQ(device_[V4L2_CID_POWER_LINE_FREQUENCY].value, 2);
  EXPECT_EQ(device_[V4L2_CID_GAIN].value, 64);
  EXPECT_TRUE(controls->check());
}

TEST_F(V4l2Held, WhatIsOffAlreadyIsNotOrderedAgain) {
  ASSERT_TRUE(hold());
  device_.ordered.clear();
  ASSERT_TRUE(hold());
  EXPECT_THAT(device_.ordered, IsEmpty());
}

TEST_F(V4l2Held, StatedSettingsAreSetAfterTheirAutomatics) {
  const auto controls = hold({.exposure = seconds(8e-3),
                              .gain = 10,
                              .focus = 30,
                              .white_balance_K = 4600,
                              .power_line_Hz = 50});
  ASSERT_TRUE(controls) << controls.error().text();
  EXPECT_EQ(device_[V4L2_CID_EXPOSURE_ABSOLUTE].value, 80);  // units of 100 us
  EXPECT_EQ(device_[V4L2_CID_GAIN].value, 10);
  EXPECT_EQ(device_[V4L2_CID_FOCUS_ABSOLUTE].value, 30);
  EXPECT_EQ(device_[V4L2_CID_WHITE_BALANCE_TEMPERATURE].value, 4600);
  EXPECT_EQ(device_[V4L2_CID_POWER_LINE_FREQUENCY].value, V4L2_CID_POWER_LINE_FREQUENCY_50HZ);
  const auto place = [&](std::uint32_t id) {
    return std::find(device_.ordered.begin(), device_.ordered.end(), id);
  };
  EXPECT_LT(place(V4L2_CID_FOCUS_AUTO), place(V4L2_CID_FOCUS_ABSOLUTE));
  EXPECT_LT(place(V4L2_CID_EXPOSURE_AUTO), place(V4L2_CID_EXPOSURE_ABSOLUTE));
  EXPECT_NEAR(controls->exposure().value().in_s(), 8e-3, 1e-9);
}

TEST_F(V4l2Held, ACameraThatRefusesIsARisk) {
  device_[V4L2_CID_FOCUS_AUTO].refuses = EIO;
  const auto controls = hold();
  ASSERT_TRUE(controls) << controls.error().text();
  ASSERT_THAT(controls->risks(), SizeIs(1));
  EXPECT_EQ(controls->risks()[0].severity(), Severity::Warning);
  EXPECT_THAT(controls->risks()[0].text(),
              Reports("v4l2:/dev/video0: warning[tolerance-warning]",
                      "automatic focus stays on, \"Input/output error\""));
  EXPECT_TRUE(controls->check());
}

TEST_F(V4l2Held, ACameraThatDoesNotObeyIsARisk) {
  device_[V4L2_CID_EXPOSURE_AUTO].obeys = false;
  const auto controls = hold();
  ASSERT_TRUE(controls) << controls.error().text();
  ASSERT_THAT(controls->risks(), SizeIs(1));
  EXPECT_THAT(controls->risks()[0].text(),
              Reports("v4l2:/dev/video0: warning[tolerance-warning]",
                      "automatic exposure stays on, although it was switched off"));
  EXPECT_FALSE(controls->can_set_exposure());
  EXPECT_FALSE(controls->exposure());
}

TEST(V4l2Bare, ACameraWithoutAControlOfItsExposureIsARiskAndAFixedFocusIsNone) {
  FakeDevice device;
  const auto controls = V4l2Controls::hold("bare", device.ioctl(), {});
  ASSERT_TRUE(controls) << controls.error().text();
  ASSERT_THAT(controls->risks(), SizeIs(1));
  EXPECT_THAT(controls->risks()[0].text(),
              Reports("bare: warning[tolerance-warning]", "no control of its exposure"));
}

TEST_F(V4l2Held, AControlWithoutEffectIsNoRisk) {
  device_[V4L2_CID_EXPOSURE_AUTO_PRIORITY].flags = V4L2_CTRL_FLAG_INACTIVE;
  device_[V4L2_CID_EXPOSURE_AUTO_PRIORITY].refuses = EACCES;
  device_[V4L2_CID_AUTOGAIN] = {.value = 1, .flags = V4L2_CTRL_FLAG_DISABLED, .refuses = EINVAL};
  const auto controls = hold();
  ASSERT_TRUE(controls) << controls.error().text();
  EXPECT_THAT(controls->risks(), IsEmpty());
}

TEST_F(V4l2Held, AStatedSettingThatIsNotInForceIsAnError) {
  const V4l2Settings dark{.exposure = seconds(1e-4)};
  EXPECT_THAT(hold(dark), FailsWith(Code::DeviceCamera, "exposure_us=100"));
  EXPECT_EQ(hold(dark).error().expected, "300 to 204700");
  device_[V4L2_CID_GAIN].by = -3;
  EXPECT_THAT(hold({.gain = 10}), FailsWith(Code::DeviceCamera, "the camera holds 7"));
  device_[V4L2_CID_GAIN].refuses = EBUSY;
  EXPECT_THAT(hold({.gain = 10}), FailsWith(Code::DeviceCamera, "gain=10: the camera refuses"));
  EXPECT_THAT(V4l2Controls::hold("bare", FakeDevice().ioctl(), {.focus = 3}),
              FailsWith(Code::DeviceCamera, "focus=3: the camera has no such control"));
}

/// A camera that counts in steps of 5 holds 30 for 32: that is the value nearest to it.
TEST_F(V4l2Held, ASettingMayBeRoundedToAStep) {
  device_[V4L2_CID_FOCUS_ABSOLUTE].by = -2;
  const auto controls = hold({.focus = 32});
  ASSERT_TRUE(controls) << controls.error().text();
  EXPECT_EQ(device_[V4L2_CID_FOCUS_ABSOLUTE].value, 30);
  EXPECT_TRUE(controls->check());
}

TEST_F(V4l2Held, APictureThatAnotherProgramMeddledWithIsRefused) {
  const auto controls = hold({.gain = 10});
  ASSERT_TRUE(controls) << controls.error().text();
  device_[V4L2_CID_FOCUS_AUTO].value = 1;
  EXPECT_THAT(controls->check(), FailsWith(Code::DeviceFrame, "automatic focus was changed"));
  device_[V4L2_CID_FOCUS_AUTO].value = 0;
  EXPECT_TRUE(controls->check());
  device_[V4L2_CID_GAIN].value = 11;
  EXPECT_THAT(controls->check(), FailsWith(Code::DeviceFrame, "gain was changed from 10 to 11"));
}

TEST_F(V4l2Held, AnExposureForOneLookIsSetAndPutBack) {
  auto controls = hold({.exposure = seconds(8e-3)});
  ASSERT_TRUE(controls && controls->can_set_exposure());
  ASSERT_TRUE(controls->set_exposure(seconds(2e-2)));
  EXPECT_EQ(device_[V4L2_CID_EXPOSURE_ABSOLUTE].value, 200);
  EXPECT_TRUE(controls->check());
  EXPECT_THAT(controls->set_exposure(seconds(1)),
              FailsWith(Code::NotSupported, "exposure_us=1000000"));
  ASSERT_TRUE(controls->set_exposure(seconds(8e-3)));
  EXPECT_EQ(device_[V4L2_CID_EXPOSURE_ABSOLUTE].value, 80);
}

TEST_F(V4l2Held, ACameraThatIsPulledOutIsSaidWhereverItHappens) {
  // The number of calls that holding takes.
  const int kMany = 1000;
  device_.gone_after = kMany;
  const FakeDevice fresh = device_;
  const V4l2Settings all{.exposure = seconds(8e-3), .gain = 10, .focus = 30};
  ASSERT_TRUE(hold(all));
  const int n_calls = kMany - device_.gone_after;
  EXPECT_GT(n_calls, 20);
  for (int n = 0; n < n_calls; ++n) {
    device_ = fresh;
    device_.gone_after = n;
    EXPECT_THAT(hold(all), FailsWith(Code::DeviceCamera, "the camera is gone")) << n;
  }
  device_ = fresh;
  auto controls = hold(all);
  ASSERT_TRUE(controls) << controls.error().text();
  device_.is_gone = true;
  EXPECT_THAT(controls->check(), FailsWith(Code::DeviceFrame, "the camera is gone"));
  EXPECT_FALSE(controls->exposure());
  EXPECT_THAT(controls->set_exposure(seconds(0.02)), FailsWith(Code::DeviceCamera, "gone"));
}

}  // namespace
}  // namespace panelcal::internal
