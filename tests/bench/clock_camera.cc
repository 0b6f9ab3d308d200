// SPDX-License-Identifier: Apache-2.0
// A GigE Vision camera whose pictures show when they were taken, for serve_bench.py:
//
//   clock_camera ADDRESS WIDTH HEIGHT
//
// 40 squares in the top left corner, each as wide as a fortieth of the picture, are the bits of the
// milliseconds since 1970, the highest first: white is 1. The rest is grey with noise, as a picture
// of a panel is, so that its JPEG has a usual size. Writes "ready" when it serves, and ends with
// its standard input.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "tests/machine/devices/cameras/fake_gige_camera.h"

namespace panelcal::test {
namespace {

constexpr std::size_t kBits = 40;
constexpr std::uint8_t kGrey = 110;
constexpr double kNoise = 3;

std::vector<std::uint8_t> noisy_grey(std::size_t n_pixels) {
  std::mt19937 random(1);
  std::normal_distribution<double> level(kGrey, kNoise);
  std::vector<std::uint8_t> pixels(n_pixels);
  for (std::uint8_t& pixel : pixels) pixel = static_cast<std::uint8_t>(level(random));
  return pixels;
}

void draw_time(std::span<std::uint8_t> bytes, std::size_t width) {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  const auto time_ms = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(since).count());
  const std::size_t side = width / kBits;
  for (std::size_t y = 0; y < side; ++y) {
    for (std::size_t x = 0; x < kBits * side; ++x) {
      const bool is_set = (time_ms >> (kBits - 1 - x / side) & 1U) != 0;
      bytes[y * width + x] = is_set ? 255 : 0;
    }
  }
}

int serve(int argc, char** argv) {
  if (argc != 4) return 2;
  const int width = std::stoi(argv[2]);
  const int height = std::stoi(argv[3]);
  const auto background =
      noisy_grey(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  FakeGigeCamera camera(argv[1], width, height, [&](const FakeFrame& frame) {
    std::ranges::copy(background, frame.bytes.begin());
    draw_time(frame.bytes, static_cast<std::size_t>(width));
  });
  return serve_until_input_ends(camera);
}

}  // namespace
}  // namespace panelcal::test

int main(int argc, char** argv) {
  return panelcal::test::serve(argc, argv);
}
