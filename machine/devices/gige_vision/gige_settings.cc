// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/gige_vision/gige_settings.h"

#include <string>
#include <utility>

#include "machine/devices/gige_vision/gige_pixels.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// One camera while it is set up.
class Setup {
 public:
  Setup(const GigeAddress& address, Object<ArvCamera> camera)
      : address_(address), camera_(std::move(camera)) {}

  Expected<void> set_all() {
    PANELCAL_CHECK(set_format());
    PANELCAL_CHECK(set_exposure(*camera(), address_, Code::DeviceCamera));
    PANELCAL_CHECK(set_gain());
    return set_trigger();
  }

  Expected<PictureSize> size() {
    gint x = 0;
    gint y = 0;
    PictureSize size;
    arv_camera_get_region(camera(), &x, &y, &size.width, &size.height, error_.out());
    PANELCAL_CHECK(done("the picture's size cannot be read"));
    return size;
  }

  Object<ArvCamera> release() { return std::move(camera_); }

 private:
  ArvCamera* camera() const { return camera_.get(); }

  tl::unexpected<Diagnostic> refuse(std::string what, std::string expected) const {
    return failure({Code::DeviceCamera,
                    {"gige://" + address_.address, 0, 0},
                    std::move(what),
                    std::move(expected)});
  }

  /// Checks that the last call of Aravis worked.
  Expected<void> done(const char* what) const {
    if (!error_) return {};
    return refuse(fmt::format("{}: {}", what, error_.text()), "");
  }

  std::string formats() {
    guint n = 0;
    const char** const words =
        arv_camera_dup_available_pixel_formats_as_strings(camera(), &n, error_.out());
    std::string text;
    for (guint i = 0; i < n; ++i) {
      if (!genicam_format(words[i])) continue;
      text += (text.empty() ? "" : ", ") + address_format(words[i]);
    }
    g_free(words);
    return text;
  }

  Expected<void> set_format() {
    if (address_.format) {
      const auto genicam = genicam_format(*address_.format);
      if (genicam) {
        arv_camera_set_pixel_format_from_string(
            camera(), std::string(*genicam).c_str(), error_.out());
      }
      if (!genicam || error_) {
        return refuse("the camera has no format " + quoted(*address_.format), formats());
      }
    }
    const char* const now = arv_camera_get_pixel_format_as_string(camera(), error_.out());
    PANELCAL_CHECK(done("the pixel format cannot be read"));
    if (genicam_format(now)) return {};
    return refuse(fmt::format("the camera sends {}, which is not read", now),
                  "format=" + formats());
  }

  Expected<void> set_gain() {
    if (!address_.gain) return {};
    if (arv_camera_is_gain_auto_available(camera(), nullptr)) {
      arv_camera_set_gain_auto(camera(), ARV_AUTO_OFF, error_.out());
      PANELCAL_CHECK(done("automatic gain cannot be switched off"));
    }
    double low = 0;
    double high = 0;
    arv_camera_get_gain_bounds(camera(), &low, &high, error_.out());
    PANELCAL_CHECK(done("the gain cannot be set"));
    if (*address_.gain < low || *address_.gain > high) {
      return refuse(fmt::format("gain={}", *address_.gain), fmt::format("{} to {}", low, high));
    }
    arv_camera_set_gain(camera(), *address_.gain, error_.out());
    return done("the gain cannot be set");
  }

  Expected<void> set_trigger() {
    arv_camera_set_acquisition_mode(camera(), ARV_ACQUISITION_MODE_CONTINUOUS, error_.out());
    PANELCAL_CHECK(done("continuous acquisition cannot be set"));
    arv_camera_set_trigger(camera(), "Software", error_.out());
    PANELCAL_CHECK(done("a software trigger cannot be set"));
    arv_camera_gv_set_packet_size_adjustment(camera(), ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
    arv_camera_gv_set_packet_size(camera(), address_.packet_bytes, error_.out());
    return done("the packet size cannot be set");
  }

  const GigeAddress& address_;
  Object<ArvCamera> camera_;
  DeviceError error_;
};

}  // namespace

Expected<void> set_exposure(ArvCamera& camera, const GigeAddress& address, Code code_outside) {
  if (!address.exposure) return {};
  const double wanted_us = address.exposure->in_s() * 1e6;
  const Place place{"gige://" + address.address, 0, 0};
  const auto fail = [&](const char* what, const DeviceError& error) {
    return failure({Code::DeviceCamera, place, fmt::format("{}: {}", what, error.text()), ""});
  };
  DeviceError error;
  if (arv_camera_is_exposure_auto_available(&camera, nullptr)) {
    arv_camera_set_exposure_time_auto(&camera, ARV_AUTO_OFF, error.out());
    if (error) return fail("automatic exposure cannot be switched off", error);
  }
  double low_us = 0;
  double high_us = 0;
  arv_camera_get_exposure_time_bounds(&camera, &low_us, &high_us, error.out());
  if (!error && !(wanted_us >= low_us && wanted_us <= high_us)) {
    return failure({code_outside,
                    place,
                    fmt::format("exposure_us={}", wanted_us),
                    fmt::format("{} to {}", low_us, high_us)});
  }
  if (!error) arv_camera_set_exposure_time(&camera, wanted_us, error.out());
  if (error) return fail("the exposure cannot be set", error);
  return {};
}

Expected<ReadyCamera> set_up(const GigeAddress& address) {
  const Place place{"gige://" + address.address, 0, 0};
  DeviceError error;
  // By the interface itself: arv_camera_new would look through USB as well, and by its address: a
  // name may be found by way of another network.
  const Object<ArvDevice> device(arv_interface_open_device(
      arv_gv_interface_get_instance(), address.address.c_str(), error.out()));
  if (!device) {
    return failure({Code::DeviceCamera,
                    place,
                    "no camera answers: " + error.text(),
                    "a GigE Vision camera at this address"});
  }
  if (!ARV_IS_GV_DEVICE(device.get()) ||
      arv_gv_device_is_controller(ARV_GV_DEVICE(device.get())) == FALSE) {
    return failure({Code::DeviceCamera,
                    place,
                    "another program controls the camera",
                    "a free camera; one whose program died is free after a few seconds"});
  }
  Object<ArvCamera> camera(arv_camera_new_with_device(device.get(), error.out()));
  if (!camera) {
    return failure({Code::DeviceCamera, place, "not a camera: " + error.text(), ""});
  }
  Setup setup(address, std::move(camera));
  PANELCAL_CHECK(setup.set_all());
  PANELCAL_TRY(const PictureSize size, setup.size());
  return ReadyCamera{setup.release(), size};
}

}  // namespace panelcal::internal
