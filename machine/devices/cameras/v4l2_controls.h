// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"

namespace panelcal {

/// Settings that the address of a V4L2 camera states; absent: as the camera has them.
struct V4l2Settings {
  std::optional<Time> exposure;
  std::optional<int> gain;             ///< in the camera's own unit
  std::optional<int> focus;            ///< in the camera's own unit
  std::optional<int> white_balance_K;  ///< color temperature
  std::optional<int> power_line_Hz;    ///< 50, 60, or 0: exposures do not follow the lamps
};

namespace internal {

/// ioctl() on one device: 0, or the errno.
using Ioctl = std::function<int(unsigned long request, void* argument)>;

/// The controls of a V4L2 camera, held: everything automatic that changes pictures by itself is
/// switched off and read back, then the stated settings are set and read back.
///
/// A camera that keeps something automatic measures with a scale, a place of the axis or a
/// brightness that change between two pictures: each is a risk, and said.
///
/// Source Linux media documentation, User Controls and Camera Control Reference
/// See    tests/machine/devices/cameras/v4l2_controls_test.cc
class V4l2Controls {
 public:
  /// In     name: of the camera, for messages
  /// Fails  device-camera (a stated setting that the camera does not have, that is outside of its
  ///        bounds, refused, or another one when it is read back; the camera is gone)
  static Expected<V4l2Controls> hold(std::string name, Ioctl ioctl, const V4l2Settings& settings);

  /// Of everything that stays automatic, a tolerance-warning.
  const std::vector<Diagnostic>& risks() const { return risks_; }

  /// To be called behind a picture: it was taken as the camera was held.
  ///
  /// Fails  device-frame (another program has set the camera; the camera is gone)
  Expected<void> check() const;

  /// False while it is automatic: it could not be put back as it was.
  bool can_set_exposure() const { return can_set_exposure_; }
  /// In force; absent while it is automatic or unknown.
  std::optional<Time> exposure() const;
  /// Fails  not-supported (no exposure to set, or outside of its bounds); device-camera
  Expected<void> set_exposure(Time exposure);

 private:
  /// A control that has to stay as it is.
  struct Held {
    std::uint32_t id = 0;
    std::int32_t value = 0;
    std::string words;
  };

  V4l2Controls(std::string name, Ioctl ioctl) : name_(std::move(name)), ioctl_(std::move(ioctl)) {}

  Expected<void> hold_all(const V4l2Settings& settings);
  Expected<void> switch_off(std::uint32_t id,
                            std::int32_t off,
                            const char* words,
                            const char* effect);
  Expected<void> set(std::uint32_t id, std::string_view key, int value);
  Expected<void> find_exposure();
  void keep(Held held);
  void warn(std::string what, std::string expected);
  tl::unexpected<Diagnostic> gone(Code code) const;

  std::string name_;
  Ioctl ioctl_;
  std::vector<Held> held_;
  std::vector<Diagnostic> risks_;
  bool can_set_exposure_ = false;
  std::int32_t exposure_low_ = 0;  ///< units of 100 us
  std::int32_t exposure_high_ = 0;
};

}  // namespace internal
}  // namespace panelcal
