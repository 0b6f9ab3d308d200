// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "machine/devices/cameras/camera_uri.h"
#include "vision/picture/image.h"
#include <gtest/gtest.h>

#include "tests/machine/devices/cameras/fake_gige_camera.h"

namespace panelcal::test {

inline constexpr const char* kUri = "gige://127.0.0.1?format=mono8";
inline constexpr int kWidth = 320;
inline constexpr int kHeight = 240;
/// A pixel of frame number `n`: every byte of every frame is its own.
inline std::uint8_t level(std::size_t i, int n) {
  const auto mixed =
      static_cast<std::uint32_t>(i * 2654435761u) ^ (static_cast<std::uint32_t>(n) * 0x9E3779B9u);
  return static_cast<std::uint8_t>(mixed >> 24);
}

inline bool shows(const Image& image, int n) {
  if (image.width() != kWidth || image.height() != kHeight) return false;
  const auto pixels = image.pixels();
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i] != level(i, n)) return false;
  }
  return true;
}

class GigeCameraTest : public ::testing::Test {
 protected:
  void SetUp() override {
    static const bool has_own_network = enter_own_network();
    start();
    if (!fake_->is_running()) {
      GTEST_SKIP() << "no camera can be simulated on 127.0.0.1"
                   << (has_own_network ? "" : ": the port may be taken");
    }
  }

  void start() {
    fake_ = std::make_unique<FakeGigeCamera>(
        "127.0.0.1", kWidth, kHeight, [this](const FakeFrame& frame) { draw(frame); });
  }

  void draw(const FakeFrame& frame) {
    exposure_us_ = frame.exposure_us;
    gain_ = frame.gain;
    const int n = shown_;
    for (std::size_t i = 0; i < frame.bytes.size(); ++i) frame.bytes[i] = level(i, n);
    if (const int delay_ms = delay_ms_.exchange(0)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
    }
  }

  std::unique_ptr<CameraDevice> open(const std::string& uri = kUri) {
    auto camera = open_camera(uri);
    EXPECT_TRUE(camera) << camera.error().text();
    return camera ? *std::move(camera) : nullptr;
  }

  std::atomic<int> shown_ = 0;     ///< picture that the camera sees now
  std::atomic<int> delay_ms_ = 0;  ///< of the next frame only
  std::atomic<double> exposure_us_ = 0;
  std::atomic<double> gain_ = 0;
  std::unique_ptr<FakeGigeCamera> fake_;
};

inline double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace panelcal::test
