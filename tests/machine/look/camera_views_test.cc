// SPDX-License-Identifier: Apache-2.0
#include "machine/look/camera_views.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::IsNearPosition;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

using Orders = std::vector<std::string>;

class WrittenCamera final : public CameraDevice {
 public:
  WrittenCamera(Orders& orders, bool has_lamp, std::optional<double> exposure_us = 1500)
      : orders_(orders), has_lamp_(has_lamp), exposure_us_(exposure_us) {}
  Expected<Image> take() override {
    orders_.emplace_back("take");
    return Image(4, 3, 255);
  }
  std::string name() const override { return "test camera"; }
  bool can_set(CameraSetting setting) const override {
    return setting == CameraSetting::Exposure || (has_lamp_ && setting == CameraSetting::Lamp);
  }
  std::optional<double> value(CameraSetting setting) const override {
    return setting == CameraSetting::Exposure ? exposure_us_ : std::nullopt;
  }
  Expected<void> set(CameraSetting setting, double value) override {
    orders_.push_back(fmt::format("camera {} {}", panelcal::name(setting), value));
    if (setting == CameraSetting::Exposure) exposure_us_ = value;
    return {};
  }

 private:
  Orders& orders_;
  bool has_lamp_;
  std::optional<double> exposure_us_;  ///< absent: it does not tell
};

/// Stands a little beside where it was sent.
class WrittenStage final : public Stage {
 public:
  explicit WrittenStage(Orders& orders, int n_failures) : orders_(orders), n_left_(n_failures) {}
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& p) override {
    orders_.push_back(fmt::format("move {} {}", p.in_mm().x(), p.in_mm().y()));
    if (n_left_-- > 0) return failure({Code::DeviceStage, {}, "stuck", ""});
    return p + displacement_mm<frame::Machine>(0.25, 0);
  }
  bool can_set(CameraSetting setting) const override { return setting != CameraSetting::Zoom; }
  Expected<void> set(CameraSetting setting, double value) override {
    orders_.push_back(fmt::format("stage {} {}", name(setting), value));
    return {};
  }

 private:
  Orders& orders_;
  int n_left_;
};

class CameraViewsTest : public ::testing::Test {
 protected:
  CameraViews views(bool camera_has_lamp = false, int n_failures = 0) {
    return CameraViews(
        {displacement_mm<frame::Machine>(40, -3), {}},
        std::make_unique<WrittenCamera>(orders_, camera_has_lamp),
        std::make_unique<WrittenStage>(orders_, n_failures),
        seconds(0.5),
        [this](Time time) { orders_.push_back(fmt::format("wait {}", time.in_s())); });
  }
  Orders take_orders() { return std::exchange(orders_, {}); }

  Orders orders_;
  MeasurementRequest request_;
};

View at(double x_mm, double y_mm) {
  return {.axis = position_mm<frame::Machine>(x_mm, y_mm)};
}

TEST_F(CameraViewsTest, DrivesTheSpindleSoThatTheCameraSeesThePlace) {
  CameraViews views = this->views();
  const auto picture = views.take(request_, at(100, 50));
  ASSERT_TRUE(picture) << picture.error().text();
  EXPECT_THAT(take_orders(), ElementsAre("move 60 53", "wait 0.5", "take"));
  // The picture belongs to where the stage stands, not to where it was sent.
  EXPECT_EQ(picture->axis, position_mm<frame::Machine>(100.25, 50));
  EXPECT_EQ(picture->path, "test camera");
}

TEST_F(CameraViewsTest, TakesFurtherPicturesOfAPlaceWithoutMoving) {
  CameraViews views = this->views();
  ASSERT_TRUE(views.take(request_, at(100, 50)));
  take_orders();
  View again = at(100, 50);
  again.i_inspection = 1;
  const auto picture = views.take(request_, again);
  ASSERT_TRUE(picture);
  EXPECT_THAT(take_orders(), ElementsAre("take"));
  EXPECT_EQ(picture->axis, position_mm<frame::Machine>(100.25, 50));
}

TEST_F(CameraViewsTest, SetsLampAndFocusOnceWhereItStandsAndWaitsAfterwards) {
  CameraViews views = this->views();
  request_.settings.lamp = 0.75;
  View view = at(100, 50);
  view.focus_z = mm(-2);
  ASSERT_TRUE(views.take(request_, view));
  EXPECT_THAT(take_orders(),
              ElementsAre("move 60 53", "stage lamp 0.75", "stage focus -2", "wait 0.5", "take"));
  ASSERT_TRUE(views.take(request_, view));
  EXPECT_THAT(take_orders(), ElementsAre("take"));
  view.focus_z = mm(-1.5);
  ASSERT_TRUE(views.take(request_, view));
  EXPECT_THAT(take_orders(), ElementsAre("stage focus -1.5", "wait 0.5", "take"));
}

TEST_F(CameraViewsTest, ExposesOneLookOtherwiseAndTheNextAsBefore) {
  CameraViews views = this->views();
  EXPECT_EQ(views.exposure_us(), 1500);
  ASSERT_TRUE(views.take(request_, at(100, 50)));
  EXPECT_THAT(take_orders(), ElementsAre("move 60 53", "wait 0.5", "take"));
  request_.settings.exposure_us = 4000;
  ASSERT_TRUE(views.take(request_, at(100, 50)));
  EXPECT_THAT(take_orders(), ElementsAre("camera exposure 4000", "wait 0.5", "take"));
  ASSERT_TRUE(views.take(request_, at(100, 50)));
  EXPECT_THAT(take_orders(), ElementsAre("take"));
  request_.settings.exposure_us.reset();
  ASSERT_TRUE(views.take(request_, at(100, 50)));
  EXPECT_THAT(take_orders(), ElementsAre("camera exposure 1500", "wait 0.5", "take"));
  ASSERT_TRUE(views.take(request_, at(100, 50)));
  EXPECT_THAT(take_orders(), ElementsAre("take"));
}

TEST_F(CameraViewsTest, ChangesNoExposureThatItCouldNotPutBack) {
  CameraViews views({displacement_mm<frame::Machine>(40, -3), {}},
                    std::make_unique<WrittenCamera>(orders_, false, std::nullopt),
                    std::make_unique<WrittenStage>(orders_, 0),
                    seconds(0.5),
                    [](Time) {});
  request_.settings.exposure_us = 4000;
  EXPECT_THAT(views.take(request_, at(100, 50)), FailsWith(Code::NotSupported, "put back"));
  EXPECT_THAT(take_orders(), ElementsAre("move 60 53"));
}

TEST_F(CameraViewsTest, KeepsToWhatMachineTomlStatesUntilAProgramAsksForAnother) {
  CameraViews views = this->views();
  VisionOptions stated;
  stated.lamp = 40;
  stated.focus = mm(0.5);
  views.set_stated(stated);
  ASSERT_TRUE(views.take(request_, at(100, 50)));
  EXPECT_THAT(take_orders(),
              ElementsAre("move 60 53", "stage lamp 40", "stage focus 0.5", "wait 0.5", "take"));
  request_.settings.lamp = 0.75;
  View view = at(100, 50);
  view.focus_z = mm(-2);
  ASSERT_TRUE(views.take(request_, view));
  EXPECT_THAT(take_orders(), ElementsAre("stage lamp 0.75", "stage focus -2", "wait 0.5", "take"));
  // Views after `$uvis,focus` found the best height state it themselves.
  request_.settings.lamp.reset();
  ASSERT_TRUE(views.take(request_, at(100, 50)));
  EXPECT_THAT(take_orders(), ElementsAre("stage lamp 40", "stage focus 0.5", "wait 0.5", "take"));
}

TEST_F(CameraViewsTest, PrefersTheCamerasOwnLamp) {
  CameraViews views = this->views(true);
  request_.settings.lamp = 0.75;
  ASSERT_TRUE(views.take(request_, at(100, 50)));
  EXPECT_THAT(take_orders(), ElementsAre("move 60 53", "camera lamp 0.75", "wait 0.5", "take"));
}

TEST_F(CameraViewsTest, AZoomThatNobodyHasIsRefusedBeforeAnythingMoves) {
  CameraViews views = this->views();
  request_.settings.zoom = 3;
  EXPECT_THAT(views.take(request_, at(100, 50)), FailsWith(Code::ConfigValue, "zoom_command"));
  EXPECT_THAT(take_orders(), IsEmpty());
}

TEST_F(CameraViewsTest, AfterAFailedMoveTheSamePlaceIsOrderedAgain) {
  CameraViews views = this->views(false, 1);
  EXPECT_THAT(views.take(request_, at(100, 50)), FailsWith(Code::DeviceStage, "stuck"));
  EXPECT_THAT(take_orders(), ElementsAre("move 60 53"));
  EXPECT_TRUE(views.take(request_, at(100, 50)));
  EXPECT_THAT(take_orders(), ElementsAre("move 60 53", "wait 0.5", "take"));
}

TEST_F(CameraViewsTest, AfterAFailedMoveTheFocusIsStillToBeSet) {
  CameraViews views = this->views(false, 1);
  View view = at(100, 50);
  view.focus_z = mm(-2);
  EXPECT_FALSE(views.take(request_, view));
  EXPECT_THAT(take_orders(), ElementsAre("move 60 53"));
  EXPECT_TRUE(views.take(request_, view));
  EXPECT_THAT(take_orders(), ElementsAre("move 60 53", "stage focus -2", "wait 0.5", "take"));
}

TEST(OpenCameraViews, SaysWhatMachineTomlLacks) {
  const test::TemporaryFolder folder;
  const auto config = [&](std::string_view toml) {
    const auto parsed = test::config_with_camera(folder.path(), test::test_camera(4, 3), toml);
    EXPECT_TRUE(parsed) << parsed.error().text();
    return parsed ? *parsed : MachineConfig();
  };
  EXPECT_THAT(open_camera_views(config(""), "folder:x"), FailsWith(Code::ConfigValue, "[camera]"));
  EXPECT_THAT(
      open_camera_views(config("[camera]\ncalibration = \"camera.cal.json\"\n"), "folder:x"),
      FailsWith(Code::ConfigValue, "stage_command that drives the camera"));
  EXPECT_THAT(open_camera_views(config(""), "folder"), FailsWith(Code::CameraUri));
}

}  // namespace
}  // namespace panelcal
