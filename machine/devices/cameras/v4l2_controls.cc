// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/v4l2_controls.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <linux/videodev2.h>

namespace panelcal::internal {

namespace {

/// The unit of V4L2_CID_EXPOSURE_ABSOLUTE.
constexpr double kExposureUnit_us = 100;

/// A control by which the camera changes its pictures by itself.
struct V4l2Automatic {
  std::uint32_t id;
  std::int32_t off;
  const char* words;
  const char* effect;
};

constexpr const char* kBrightness = "edges move with the brightness";

/// The exposure first: others have no effect where it is off.
constexpr auto kAutomatics = std::to_array<V4l2Automatic>({
    {V4L2_CID_FOCUS_AUTO, 0, "automatic focus", "the scale and the axis move with it"},
    {V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, "automatic exposure", kBrightness},
    {V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0, "frame rate that follows the light", kBrightness},
    {V4L2_CID_AUTOGAIN, 0, "automatic gain", kBrightness},
    {V4L2_CID_AUTOBRIGHTNESS, 0, "automatic brightness", kBrightness},
    {V4L2_CID_AUTO_WHITE_BALANCE, 0, "automatic white balance", "edges move with the colors"},
    {V4L2_CID_IMAGE_STABILIZATION, 0, "image stabilization", "it moves the picture"},
});

bool is_gone(int error) {
  return error == ENODEV || error == ENXIO;
}

std::string errno_words(int error) {
  return std::error_code(error, std::generic_category()).message();
}

int get_control(const Ioctl& ioctl, std::uint32_t id, std::int32_t& value) {
  v4l2_control control{};
  control.id = id;
  const int error = ioctl(VIDIOC_G_CTRL, &control);
  value = control.value;
  return error;
}

int set_control(const Ioctl& ioctl, std::uint32_t id, std::int32_t value) {
  v4l2_control control{};
  control.id = id;
  control.value = value;
  return ioctl(VIDIOC_S_CTRL, &control);
}

/// 0; or errno, EINVAL where the camera has no such control.
int query_control(const Ioctl& ioctl, std::uint32_t id, v4l2_queryctrl& query) {
  query = {};
  query.id = id;
  const int error = ioctl(VIDIOC_QUERYCTRL, &query);
  return error == 0 && (query.flags & V4L2_CTRL_FLAG_DISABLED) != 0 ? EINVAL : error;
}

int exposure_units(Time exposure) {
  return static_cast<int>(std::lround(exposure.in_s() * 1e6 / kExposureUnit_us));
}

std::string bounds_us(std::int32_t low, std::int32_t high) {
  return fmt::format("{} to {}", low * kExposureUnit_us, high * kExposureUnit_us);
}

}  // namespace

tl::unexpected<Diagnostic> V4l2Controls::gone(Code code) const {
  return failure({code, {name_, 0, 0}, "the camera is gone", "the camera that was there before"});
}

void V4l2Controls::warn(std::string what, std::string expected) {
  risks_.push_back({Code::ToleranceWarning, {name_, 0, 0}, std::move(what), std::move(expected)});
}

void V4l2Controls::keep(Held held) {
  std::erase_if(held_, [&](const Held& other) { return other.id == held.id; });
  held_.push_back(std::move(held));
}

/// Written only where it is on: some cameras begin to focus anew by each order.
Expected<void> V4l2Controls::switch_off(std::uint32_t id,
                                        std::int32_t off,
                                        const char* words,
                                        const char* effect) {
  v4l2_queryctrl query{};
  const int absent = query_control(ioctl_, id, query);
  if (is_gone(absent)) return gone(Code::DeviceCamera);
  if (absent != 0 || (query.flags & V4L2_CTRL_FLAG_INACTIVE) != 0) return {};
  std::int32_t value = 0;
  int error = get_control(ioctl_, id, value);
  if (error == 0 && value != off) {
    error = set_control(ioctl_, id, off);
    if (error == 0) error = get_control(ioctl_, id, value);
  }
  if (is_gone(error)) return gone(Code::DeviceCamera);
  if (error == 0 && value == off) {
    keep({id, off, words});
    return {};
  }
  warn(fmt::format("{} stays on, {}: {}",
                   words,
                   error != 0 ? fmt::format("\"{}\"", errno_words(error))
                              : std::string("although it was switched off"),
                   effect),
       "a camera in which it can be switched off");
  return {};
}

Expected<void> V4l2Controls::set(std::uint32_t id, std::string_view key, int value) {
  const bool is_exposure = id == V4L2_CID_EXPOSURE_ABSOLUTE;
  const auto shown = [&](std::int32_t number) {
    return is_exposure ? number * kExposureUnit_us : static_cast<double>(number);
  };
  const auto refuse = [&](std::string_view what, std::string expected) {
    return failure({Code::DeviceCamera,
                    {name_, 0, 0},
                    fmt::format("{}={}{}", key, shown(value), what),
                    std::move(expected)});
  };
  v4l2_queryctrl query{};
  int error = query_control(ioctl_, id, query);
  if (is_gone(error)) return gone(Code::DeviceCamera);
  if (error != 0) return refuse(": the camera has no such control", "");
  if (value < query.minimum || value > query.maximum) {
    return refuse("", fmt::format("{} to {}", shown(query.minimum), shown(query.maximum)));
  }
  std::int32_t now = 0;
  error = set_control(ioctl_, id, value);
  if (error == 0) error = get_control(ioctl_, id, now);
  if (is_gone(error)) return gone(Code::DeviceCamera);
  if (error != 0) return refuse(": the camera refuses: " + errno_words(error), "");
  if (std::abs(now - value) >= std::max(1, query.step)) {
    return refuse(fmt::format(": the camera holds {}", shown(now)), "a value that it takes");
  }
  keep({id, now, std::string(key)});
  return {};
}

Expected<void> V4l2Controls::find_exposure() {
  v4l2_queryctrl exposure{};
  v4l2_queryctrl automatic{};
  const int error = query_control(ioctl_, V4L2_CID_EXPOSURE_ABSOLUTE, exposure);
  const int error_automatic = query_control(ioctl_, V4L2_CID_EXPOSURE_AUTO, automatic);
  if (is_gone(error) || is_gone(error_automatic)) return gone(Code::DeviceCamera);
  if (error != 0 && error_automatic != 0) {
    warn("the camera has no control of its exposure, which may be automatic: " +
             std::string(kBrightness),
         "a camera whose exposure can be held");
  }
  const bool is_held = std::ranges::any_of(
      held_, [](const Held& held) { return held.id == V4L2_CID_EXPOSURE_AUTO; });
  can_set_exposure_ = error == 0 && (is_held || error_automatic != 0) &&
                      (exposure.flags & V4L2_CTRL_FLAG_READ_ONLY) == 0;
  exposure_low_ = exposure.minimum;
  exposure_high_ = exposure.maximum;
  return {};
}

Expected<void> V4l2Controls::hold_all(const V4l2Settings& settings) {
  for (const V4l2Automatic& one : kAutomatics) {
    PANELCAL_CHECK(switch_off(one.id, one.off, one.words, one.effect));
  }
  PANELCAL_CHECK(find_exposure());
  if (settings.power_line_Hz) {
    constexpr const char* kKey = "power_line_hz";
    const int hz = *settings.power_line_Hz;
    const int choice = hz == 0    ? V4L2_CID_POWER_LINE_FREQUENCY_DISABLED
                       : hz == 50 ? V4L2_CID_POWER_LINE_FREQUENCY_50HZ
                                  : V4L2_CID_POWER_LINE_FREQUENCY_60HZ;
    PANELCAL_CHECK(set(V4L2_CID_POWER_LINE_FREQUENCY, kKey, choice));
  }
  if (settings.exposure) {
    const int units = exposure_units(*settings.exposure);
    PANELCAL_CHECK(set(V4L2_CID_EXPOSURE_ABSOLUTE, "exposure_us", units));
  }
  if (settings.gain) PANELCAL_CHECK(set(V4L2_CID_GAIN, "gain", *settings.gain));
  if (settings.focus) PANELCAL_CHECK(set(V4L2_CID_FOCUS_ABSOLUTE, "focus", *settings.focus));
  if (!settings.white_balance_K) return {};
  return set(V4L2_CID_WHITE_BALANCE_TEMPERATURE, "white_balance_k", *settings.white_balance_K);
}

Expected<V4l2Controls> V4l2Controls::hold(std::string name,
                                          Ioctl ioctl,
                                          const V4l2Settings& settings) {
  V4l2Controls controls(std::move(name), std::move(ioctl));
  PANELCAL_CHECK(controls.hold_all(settings));
  return controls;
}

Expected<void> V4l2Controls::check() const {
  for (const Held& held : held_) {
    std::int32_t value = 0;
    const int error = get_control(ioctl_, held.id, value);
    if (is_gone(error)) return gone(Code::DeviceFrame);
    if (error == 0 && value == held.value) continue;
    return failure({Code::DeviceFrame,
                    {name_, 0, 0},
                    error != 0 ? fmt::format("{}: {}", held.words, errno_words(error))
                               : fmt::format("{} was changed from {} to {} by another program",
                                             held.words,
                                             held.value,
                                             value),
                    "no other program that sets the camera"});
  }
  return {};
}

std::optional<Time> V4l2Controls::exposure() const {
  if (!can_set_exposure_) return std::nullopt;
  std::int32_t value = 0;
  if (get_control(ioctl_, V4L2_CID_EXPOSURE_ABSOLUTE, value) != 0) return std::nullopt;
  return seconds(value * kExposureUnit_us * 1e-6);
}

/// A value beyond the bounds is no fault of the device, so that it is not tried again.
Expected<void> V4l2Controls::set_exposure(Time exposure) {
  const double exposure_us = exposure.in_s() * 1e6;
  const bool is_inside = exposure_us >= exposure_low_ * kExposureUnit_us &&
                         exposure_us <= exposure_high_ * kExposureUnit_us;
  if (!can_set_exposure_ || !is_inside) {
    return failure({Code::NotSupported,
                    {name_, 0, 0},
                    fmt::format("exposure_us={}", exposure_us),
                    can_set_exposure_ ? bounds_us(exposure_low_, exposure_high_)
                                      : std::string("a camera that lets its exposure be set")});
  }
  return set(V4L2_CID_EXPOSURE_ABSOLUTE, "exposure_us", exposure_units(exposure));
}

}  // namespace panelcal::internal
