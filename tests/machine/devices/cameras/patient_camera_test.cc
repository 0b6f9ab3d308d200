// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/patient_camera.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

/// A camera on a wire that is out for a number of tries.
struct Wire {
  int n_tries_out = 0;
  int n_opened = 0;
  int n_waits = 0;
  std::vector<double> lamps;

  Expected<void> pass(Code code) {
    if (n_tries_out == 0) return {};
    --n_tries_out;
    return failure({code, {"camera", 0, 0}, "no answer", ""});
  }
};

class WiredCamera final : public CameraDevice {
 public:
  WiredCamera(Wire& wire, Code code) : wire_(wire), code_(code) {}

  Expected<Image> take() override {
    PANELCAL_CHECK(wire_.pass(code_));
    return Image(4, 3, 255);
  }
  std::string name() const override { return "wired"; }
  bool can_set(CameraSetting setting) const override { return setting == CameraSetting::Lamp; }
  Expected<void> set(CameraSetting /*setting*/, double value) override {
    PANELCAL_CHECK(wire_.pass(code_));
    wire_.lamps.push_back(value);
    return {};
  }

 private:
  Wire& wire_;
  Code code_;
};

std::unique_ptr<CameraDevice> camera_on(Wire& wire, Code code = Code::DeviceFrame) {
  auto camera = PatientCamera::make(
      [&wire, code]() -> Expected<std::unique_ptr<CameraDevice>> {
        if (wire.n_opened > 0) PANELCAL_CHECK(wire.pass(Code::DeviceCamera));
        ++wire.n_opened;
        return std::make_unique<WiredCamera>(wire, code);
      },
      seconds(3),
      [&wire](Time) { ++wire.n_waits; });
  return *std::move(camera);
}

TEST(PatientCamera, WaitsForACameraThatIsAway) {
  Wire wire;
  const auto camera = camera_on(wire);
  ASSERT_TRUE(camera->take());
  EXPECT_EQ(wire.n_waits, 0);
  wire.n_tries_out = 10;
  EXPECT_TRUE(camera->take());
  EXPECT_EQ(wire.n_opened, 2);
  EXPECT_EQ(wire.n_waits, 10);
}

TEST(PatientCamera, SetsWhatWasSetBeforeTheCameraWentAway) {
  Wire wire;
  const auto camera = camera_on(wire);
  ASSERT_TRUE(camera->set(CameraSetting::Lamp, 30));
  wire.n_tries_out = 2;
  ASSERT_TRUE(camera->take());
  EXPECT_THAT(wire.lamps, testing::ElementsAre(30, 30));
}

TEST(PatientCamera, GivesUpAndTriesAgainWhenAskedAgain) {
  Wire wire;
  const auto camera = camera_on(wire);
  wire.n_tries_out = 100;
  EXPECT_THAT(camera->take(), FailsWith(Code::DeviceCamera));
  EXPECT_EQ(wire.n_waits, 12);
  wire.n_tries_out = 0;
  EXPECT_TRUE(camera->take());
  EXPECT_EQ(camera->name(), "wired");
}

TEST(PatientCamera, DoesNotWaitForWhatWaitingDoesNotMend) {
  Wire wire;
  const auto camera = camera_on(wire, Code::PictureDamaged);
  wire.n_tries_out = 1;
  EXPECT_THAT(camera->take(), FailsWith(Code::PictureDamaged));
  EXPECT_THAT(camera->set(CameraSetting::Zoom, 2), FailsWith(Code::NotSupported));
  EXPECT_EQ(wire.n_waits, 0);
}

TEST(PatientCamera, DoesNotWaitToBeOpenedFirst) {
  const auto camera = PatientCamera::make(
      []() -> Expected<std::unique_ptr<CameraDevice>> {
        return failure({Code::DeviceCamera, {"camera", 0, 0}, "no answer", ""});
      },
      seconds(3),
      [](Time) { FAIL() << "waited"; });
  EXPECT_THAT(camera, FailsWith(Code::DeviceCamera));
}

}  // namespace
}  // namespace panelcal
