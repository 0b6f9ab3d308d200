// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/gige_camera.h"

#include <cstddef>
#include <string>
#include <vector>

#include "vision/picture/files/raw_pixels.h"
#include <gtest/gtest.h>

#include "tests/machine/devices/cameras/gige_camera_fixture.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::GigeCameraTest;
using test::kHeight;
using test::kWidth;
using test::shows;

TEST_F(GigeCameraTest, APictureIsExactAndOfNow) {
  const auto camera = open();
  ASSERT_TRUE(camera);
  ASSERT_TRUE(camera->size());
  EXPECT_EQ(camera->size()->width, kWidth);
  EXPECT_EQ(camera->size()->height, kHeight);
  EXPECT_EQ(camera->name(), "gige://127.0.0.1");
  for (int n = 0; n < 3; ++n) {
    shown_ = n;
    const auto image = camera->take();
    ASSERT_TRUE(image) << image.error().text();
    EXPECT_TRUE(shows(*image, n));
  }
}

TEST_F(GigeCameraTest, SixteenBitsAndColoursAreConvertedAsRawPixelsAre) {
  constexpr PixelFormat kFormats[] = {PixelFormat::Mono16,
                                      PixelFormat::RGB8,
                                      PixelFormat::BayerRG8,
                                      PixelFormat::BayerGR8,
                                      PixelFormat::BayerGB8,
                                      PixelFormat::BayerBG8};
  for (const PixelFormat format : kFormats) {
    const auto camera = open("gige://127.0.0.1?format=" + std::string(name(format)));
    ASSERT_TRUE(camera);
    const auto image = camera->take();
    ASSERT_TRUE(image) << image.error().text();
    std::vector<std::byte> bytes(kWidth * kHeight * bytes_per_pixel(format));
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = std::byte{test::level(i, 0)};
    EXPECT_EQ(*image, *from_raw_pixels(bytes, kWidth, kHeight, format)) << name(format);
  }
}

TEST_F(GigeCameraTest, ExposureAndGainReachTheCamera) {
  const auto camera = open("gige://127.0.0.1?exposure_us=2345&gain=3");
  ASSERT_TRUE(camera);
  ASSERT_TRUE(camera->take());
  EXPECT_EQ(exposure_us_, 2345);
  EXPECT_EQ(gain_, 3);
}

TEST_F(GigeCameraTest, TakesAnotherExposureWhileItIsOpen) {
  const auto camera = open("gige://127.0.0.1?exposure_us=2345");
  ASSERT_TRUE(camera);
  ASSERT_TRUE(camera->can_set(CameraSetting::Exposure));
  EXPECT_FALSE(camera->can_set(CameraSetting::Lamp));
  EXPECT_EQ(camera->value(CameraSetting::Exposure), 2345);
  ASSERT_TRUE(camera->set(CameraSetting::Exposure, 4000));
  ASSERT_TRUE(camera->take());
  EXPECT_EQ(exposure_us_, 4000);
  EXPECT_EQ(camera->value(CameraSetting::Exposure), 4000);
  // No fault of the device, so that it is not opened anew.
  EXPECT_THAT(camera->set(CameraSetting::Exposure, 1),
              FailsWith(Code::NotSupported, "exposure_us=1"));
  EXPECT_EQ(camera->value(CameraSetting::Exposure), 4000);
}

TEST_F(GigeCameraTest, RefusesWhatTheCameraCannotDo) {
  EXPECT_THAT(open_camera("gige://127.0.0.1?exposure_us=1"),
              FailsWith(Code::DeviceCamera, "exposure_us=1"));
  EXPECT_THAT(open_camera("gige://127.0.0.1?gain=11"), FailsWith(Code::DeviceCamera, "gain=11"));
  EXPECT_THAT(open_camera("gige://127.0.0.1?format=mono9"),
              FailsWith(Code::DeviceCamera, "\"mono9\""));
  EXPECT_THAT(open_camera("gige://127.0.0.1?format=mono12"),
              FailsWith(Code::DeviceCamera, "mono8"));
}

}  // namespace
}  // namespace panelcal
