// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <atomic>
#include <memory>
#include <thread>

#include "machine/devices/cameras/gige_camera.h"
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/machine/devices/cameras/gige_camera_fixture.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::GigeCameraTest;
using test::kUri;
using test::seconds_of;
using test::shows;

/// Limit of "within a few seconds".
constexpr double kPatience_s = 8;

/// Aravis's camera numbers its frames from 65401, so that the 16 bits are full after 135.
TEST_F(GigeCameraTest, EveryPictureIsExactAndOfNowAlsoWhereFrameNumbersBeginAnew) {
  const auto camera = open();
  ASSERT_TRUE(camera);
  for (int n = 0; n < 160; ++n) {
    shown_ = n;
    const auto image = camera->take();
    ASSERT_TRUE(image) << n << ": " << image.error().text();
    ASSERT_TRUE(shows(*image, n)) << n;
  }
  EXPECT_EQ(camera->n_retaken(), 0);
}

TEST_F(GigeCameraTest, LostPacketsCostTimeButNoPixel) {
  constexpr int kFrames = 60;
  constexpr double kLost = 0.003;  // of 55 packets a frame: every seventh frame
  fake_->lose(kLost);
  const auto camera = open();
  ASSERT_TRUE(camera);
  for (int n = 0; n < kFrames; ++n) {
    shown_ = n;
    const auto image = camera->take();
    ASSERT_TRUE(image) << n << ": " << image.error().text();
    ASSERT_TRUE(shows(*image, n)) << n;
  }
  EXPECT_GT(camera->n_retaken(), 0);
}

TEST_F(GigeCameraTest, TooManyLostPacketsAreRefusedWithTheirNumber) {
  const auto camera = open("gige://127.0.0.1?format=mono8&retries=4&timeout_ms=300");
  ASSERT_TRUE(camera);
  fake_->lose(0.5);
  EXPECT_THAT(camera->take(), FailsWith(Code::DeviceFrame, "5 of 5 frames"));
  EXPECT_EQ(camera->n_retaken(), 5);
  // The line is mended.
  fake_->lose(0);
  shown_ = 7;
  const auto image = camera->take();
  ASSERT_TRUE(image) << image.error().text();
  EXPECT_TRUE(shows(*image, 7));
}

TEST_F(GigeCameraTest, AFrameThatComesLateIsNeverTakenForTheNextOne) {
  const auto camera = open("gige://127.0.0.1?format=mono8&retries=0&timeout_ms=100");
  ASSERT_TRUE(camera);
  for (int n = 0; n < 5; ++n) {
    shown_ = 2 * n;
    delay_ms_ = 150;
    EXPECT_THAT(camera->take(), FailsWith(Code::DeviceFrame, "1 "));
    shown_ = 2 * n + 1;
    Expected<Image> image = camera->take();
    // The camera may still be busy with the late one.
    if (!image) image = camera->take();
    ASSERT_TRUE(image) << image.error().text();
    EXPECT_TRUE(shows(*image, 2 * n + 1));
  }
}

TEST_F(GigeCameraTest, ACameraBelongsToOneProgramAtATime) {
  {
    const auto camera = open();
    ASSERT_TRUE(camera);
    const double time_s =
        seconds_of([] { EXPECT_THAT(open_camera(kUri), FailsWith(Code::DeviceCamera)); });
    EXPECT_LT(time_s, kPatience_s);
    EXPECT_TRUE(camera->take()) << "the first one keeps it";
  }
  EXPECT_TRUE(open());
}

TEST_F(GigeCameraTest, ACameraThatGoesAwayIsMissedWithinSeconds) {
  const auto camera = open();
  ASSERT_TRUE(camera);
  ASSERT_TRUE(camera->take());
  fake_.reset();
  const double time_s =
      seconds_of([&] { EXPECT_THAT(camera->take(), FailsWith(Code::DeviceFrame)); });
  EXPECT_LT(time_s, kPatience_s);
}

TEST_F(GigeCameraTest, NobodyAtTheAddressIsSaidWithinSeconds) {
  fake_.reset();
  const double time_s = seconds_of(
      [] { EXPECT_THAT(open_camera("gige://127.0.0.1"), FailsWith(Code::DeviceCamera)); });
  EXPECT_LT(time_s, kPatience_s);
}

/// Something else listens on the port of GigE Vision.
TEST_F(GigeCameraTest, WhatIsNoCameraIsRefused) {
  fake_.reset();
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ASSERT_GE(fd, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(3956);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  std::atomic<bool> ends = false;
  std::thread stranger([&] {
    timeval wait{.tv_sec = 0, .tv_usec = 50'000};
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
    while (!ends) {
      std::array<char, 2000> bytes{};
      sockaddr_in from{};
      socklen_t length = sizeof from;
      auto* const sender = reinterpret_cast<sockaddr*>(&from);
      if (recvfrom(fd, bytes.data(), bytes.size(), 0, sender, &length) > 0) {
        sendto(fd, "I am no camera", 14, 0, sender, length);
      }
    }
  });
  const double time_s = seconds_of(
      [] { EXPECT_THAT(open_camera("gige://127.0.0.1"), FailsWith(Code::DeviceCamera)); });
  ends = true;
  stranger.join();
  close(fd);
  EXPECT_LT(time_s, kPatience_s);
}

}  // namespace
}  // namespace panelcal
