// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/opencv_camera.h"

#include <cmath>
#include <string>

#include "calib/base/files/atomic_file.h"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr int kFrames = 5;
/// FFV1 loses nothing, but it is given blue, green and red and makes them YUV of 8 bit.
constexpr double kSameLevel = 2;

double level(int x, int y, int i_frame) {
  return 20 + 2 * x + y + 12 * i_frame;
}

void write_video(const std::string& file) {
  cv::VideoWriter writer(file,
                         cv::CAP_FFMPEG,
                         cv::VideoWriter::fourcc('F', 'F', 'V', '1'),
                         25,
                         cv::Size(kWidth, kHeight));
  if (!writer.isOpened()) GTEST_SKIP() << "this FFmpeg writes no FFV1";
  for (int i = 0; i < kFrames; ++i) {
    cv::Mat frame(kHeight, kWidth, CV_8UC3);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x)
        frame.at<cv::Vec3b>(y, x) = cv::Vec3b::all(cv::saturate_cast<uchar>(level(x, y, i)));
    }
    writer.write(frame);
  }
}

class VideoFileTest : public ::testing::Test {
 protected:
  std::string file(const char* name) const { return (folder_.path() / name).string(); }
  test::TemporaryFolder folder_;
};

TEST_F(VideoFileTest, GivesItsFramesInOrderUntilItEnds) {
  write_video(file("a%d.avi"));
  const auto camera = open_opencv_camera({.what = file("a%d.avi")});
  ASSERT_TRUE(camera) << camera.error().text();
  for (int i = 0; i < kFrames; ++i) {
    const auto image = (*camera)->take();
    ASSERT_TRUE(image) << image.error().text();
    ASSERT_EQ(image->width(), kWidth);
    ASSERT_EQ(image->height(), kHeight);
    EXPECT_EQ(image->full_scale(), Image::kFullScale8);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_NEAR(image->at(x, y), level(x, y, i), kSameLevel) << x << ' ' << y << ' ' << i;
      }
    }
  }
  EXPECT_THAT((*camera)->take(), FailsWith(Code::DeviceFrame, "5 frames"));
}

TEST_F(VideoFileTest, WhatIsNoVideoIsRefused) {
  ASSERT_TRUE(write_file(file("a.avi"), "RIFF but no video at all"));
  EXPECT_THAT(open_opencv_camera({.what = file("a.avi")}), FailsWith(Code::PictureFormat));
  EXPECT_THAT(open_opencv_camera({.what = folder_.path().string()}),
              FailsWith(Code::FileUnreadable, "video"));
}

TEST_F(VideoFileTest, ACutOffVideoEndsWithAnErrorAndNotWithAPatchedFrame) {
  write_video(file("a.avi"));
  const auto bytes = read_file(file("a.avi"));
  ASSERT_TRUE(bytes);
  ASSERT_TRUE(write_file(file("b.avi"), bytes->substr(0, bytes->size() / 2)));
  const auto camera = open_opencv_camera({.what = file("b.avi")});
  if (!camera) return;  // refused as a whole: also right
  int n = 0;
  for (; n < kFrames; ++n) {
    const auto image = (*camera)->take();
    if (!image) break;
    ASSERT_NEAR(image->at(5, 5), level(5, 5, n), kSameLevel) << n;
  }
  EXPECT_LT(n, kFrames);
}

TEST(VideoDevice, WhatIsNoCameraIsRefused) {
  EXPECT_THAT(open_opencv_camera({.kind = VideoAddress::Kind::V4l2, .what = "/dev/null"}),
              FailsWith(Code::DeviceCamera, "/dev/null"));
}

TEST(VideoStream, AServerThatIsNotThereIsSaidWithoutItsPassword) {
  const auto camera = open_opencv_camera(
      {.kind = VideoAddress::Kind::Rtsp, .what = "rtsp://me:secret@127.0.0.1:9/live"});
  EXPECT_THAT(camera, FailsWith(Code::DeviceCamera, "rtsp://127.0.0.1:9/live"));
  EXPECT_EQ(camera.error().text().find("secret"), std::string::npos);
  EXPECT_EQ(camera.error().text().find("0x"), std::string::npos) << camera.error().text();
}

}  // namespace
}  // namespace panelcal
