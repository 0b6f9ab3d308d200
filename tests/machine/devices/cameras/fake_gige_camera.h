// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>

typedef struct _ArvGvFakeCamera ArvGvFakeCamera;

namespace panelcal::test {

/// Gives this process a network of its own with nothing but loopback, so that cameras of tests that
/// run at the same time do not meet; false where the system does not allow it. Only works while the
/// process has one thread.
bool enter_own_network();

/// Content that a frame is to show, and the client's settings of the camera.
struct FakeFrame {
  std::span<std::uint8_t> bytes;  ///< to be filled
  double exposure_us;
  double gain;
  std::uint32_t pixel_format;  ///< code of GigE Vision
};

/// Aravis's camera without a camera: speaks the real protocol on loopback.
class FakeGigeCamera {
 public:
  /// Called in the camera's thread for each frame.
  using Fill = std::function<void(const FakeFrame&)>;

  FakeGigeCamera(const char* address, int width_px, int height_px, Fill fill);
  ~FakeGigeCamera();
  FakeGigeCamera(const FakeGigeCamera&) = delete;
  FakeGigeCamera& operator=(const FakeGigeCamera&) = delete;

  bool is_running() const;
  /// Share of packets that are lost on the way, 0 to 1.
  void lose(double share);

  /// Called by Aravis.
  void draw(std::uint8_t* bytes, double exposure_us, double gain, std::uint32_t pixel_format) const;

 private:
  Fill fill_;
  int width_px_;
  int height_px_;
  ArvGvFakeCamera* camera_;
};

/// A program that is a camera: says "ready" and serves until its standard input ends.
///
/// Out    its exit code: 3, with a word on standard error, where the camera does not run
int serve_until_input_ends(const FakeGigeCamera& camera);

}  // namespace panelcal::test
