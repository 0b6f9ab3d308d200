// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/gige_camera.h"

#include <cstdint>
#include <string>
#include <utility>

#include "machine/devices/gige_vision/gige_objects.h"
#include "machine/devices/gige_vision/gige_pixels.h"
#include "machine/devices/gige_vision/gige_settings.h"
#include <arv.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

namespace panelcal {
namespace {

using internal::DeviceError;
using internal::Object;

/// One on the wire, one being filled, two in reserve.
constexpr int kBuffers = 4;
/// Holds the packets of a frame while this process is kept waiting; more than the kernel allows
/// (net.core.rmem_max) is cut by it.
constexpr int kSocketBytes = 4'000'000;
/// Frames in a row that never come: the camera is not merely losing packets.
constexpr int kMostSilent = 3;

/// A packet socket takes frames from the card itself and does not lose packets.
bool has_raw_socket() {
  const int fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  close(fd);
  return true;
}

class GigeCamera final : public CameraDevice {
 public:
  GigeCamera(GigeAddress address, Object<ArvCamera> camera, PictureSize size)
      : address_(std::move(address)), camera_(std::move(camera)), size_(size) {}
  ~GigeCamera() override {
    if (is_gone_) {
      abandon();
      return;
    }
    end_stream();
  }

  Expected<Image> take() override;
  std::string name() const override { return "gige://" + address_.address; }
  std::optional<PictureSize> size() const override { return size_; }
  int n_retaken() const override { return n_retaken_; }
  bool can_set(CameraSetting setting) const override;
  std::optional<double> value(CameraSetting setting) const override;
  Expected<void> set(CameraSetting setting, double value) override;

  Expected<void> begin_stream();

 private:
  struct Tally {
    int damaged = 0;
    int silent = 0;
    int silent_in_row = 0;
    const char* last = "";
  };

  void end_stream();
  void abandon();
  Expected<void> get_in_step();
  Expected<std::optional<Image>> take_once(Tally& tally);
  Diagnostic problem(Code code, std::string what, std::string expected) const {
    return {code, {name(), 0, 0}, std::move(what), std::move(expected)};
  }

  GigeAddress address_;
  Object<ArvCamera> camera_;
  PictureSize size_;
  Object<ArvStream> stream_;
  int n_retaken_ = 0;
  /// True if every frame that was triggered has come.
  bool is_in_step_ = false;
  bool is_gone_ = false;  ///< did not answer any more
};

/// Not while it is automatic: that could not be put back as it was.
bool GigeCamera::can_set(CameraSetting setting) const {
  if (setting != CameraSetting::Exposure) return false;
  ArvCamera* const camera = camera_.get();
  if (arv_camera_is_exposure_time_available(camera, nullptr) == FALSE) return false;
  if (arv_camera_is_exposure_auto_available(camera, nullptr) == FALSE) return true;
  DeviceError error;
  const ArvAuto automatic = arv_camera_get_exposure_time_auto(camera, error.out());
  return !error && automatic == ARV_AUTO_OFF;
}

std::optional<double> GigeCamera::value(CameraSetting setting) const {
  if (is_gone_ || !can_set(setting)) return std::nullopt;
  DeviceError error;
  const double exposure_us = arv_camera_get_exposure_time(camera_.get(), error.out());
  return error ? std::nullopt : std::optional(exposure_us);
}

/// A value beyond the bounds is no fault of the device, so that it is not tried again.
Expected<void> GigeCamera::set(CameraSetting setting, double value) {
  if (is_gone_ || !can_set(setting)) return CameraDevice::set(setting, value);
  GigeAddress wanted = address_;
  wanted.exposure = seconds(value * 1e-6);
  Expected<void> set = internal::set_exposure(*camera_, wanted, Code::NotSupported);
  if (set) address_.exposure = wanted.exposure;
  return set;
}

Expected<void> GigeCamera::begin_stream() {
  is_in_step_ = false;
  DeviceError error;
  const std::size_t bytes = arv_camera_get_payload(camera_.get(), error.out());
  if (!error) stream_.reset(arv_camera_create_stream(camera_.get(), nullptr, nullptr, error.out()));
  if (error || !stream_) {
    return failure(problem(Code::DeviceCamera, "no stream: " + error.text(), ""));
  }
  const bool resends = address_.resend.value_or(has_raw_socket());
  g_object_set(stream_.get(),
               "socket-buffer",
               ARV_GV_STREAM_SOCKET_BUFFER_FIXED,
               "socket-buffer-size",
               kSocketBytes,
               "packet-resend",
               resends ? ARV_GV_STREAM_PACKET_RESEND_ALWAYS : ARV_GV_STREAM_PACKET_RESEND_NEVER,
               nullptr);
  for (int i = 0; i < kBuffers; ++i) {
    arv_stream_push_buffer(stream_.get(), arv_buffer_new_allocate(bytes));
  }
  arv_camera_start_acquisition(camera_.get(), error.out());
  if (error) {
    return failure(problem(Code::DeviceCamera, "does not begin to send: " + error.text(), ""));
  }
  is_in_step_ = true;
  return {};
}

void GigeCamera::end_stream() {
  if (!stream_) return;
  DeviceError ignored;
  arv_camera_stop_acquisition(camera_.get(), ignored.out());
  stream_.reset();
}

/// To take leave of a camera that does not answer would take ten seconds of waiting. What is given
/// up here belongs to threads of Aravis that wait for it, until the process ends.
void GigeCamera::abandon() {
  static_cast<void>(stream_.release());
  static_cast<void>(camera_.release());
}

Expected<void> GigeCamera::get_in_step() {
  if (is_gone_) {
    return failure(problem(Code::DeviceFrame, "the camera was lost", "a camera that is there"));
  }
  if (is_in_step_ && stream_) return {};
  end_stream();
  return begin_stream();
}

/// Absent: the frame was lost.
Expected<std::optional<Image>> GigeCamera::take_once(Tally& tally) {
  DeviceError error;
  arv_camera_software_trigger(camera_.get(), error.out());
  if (error) {
    is_gone_ = true;
    return failure(problem(Code::DeviceFrame,
                           "does not answer: " + error.text(),
                           "the camera that was there when the job began"));
  }
  const double wait_s = address_.timeout.in_s() + address_.exposure.value_or(Time()).in_s();
  ArvBuffer* const buffer =
      arv_stream_timeout_pop_buffer(stream_.get(), static_cast<std::uint64_t>(wait_s * 1e6));
  if (buffer == nullptr) {
    is_in_step_ = false;
    ++tally.silent;
    ++tally.silent_in_row;
    return std::nullopt;
  }
  tally.silent_in_row = 0;
  if (arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS) {
    tally.last = internal::status_text(arv_buffer_get_status(buffer));
    ++tally.damaged;
    arv_stream_push_buffer(stream_.get(), buffer);
    return std::nullopt;
  }
  Expected<Image> image = internal::image_of(*buffer, name());
  arv_stream_push_buffer(stream_.get(), buffer);
  if (!image) return failure(std::move(image).error());
  return *std::move(image);
}

Expected<Image> GigeCamera::take() {
  PANELCAL_CHECK(get_in_step());
  Tally tally;
  int n_tried = 0;
  while (n_tried <= address_.retries && tally.silent_in_row < kMostSilent) {
    PANELCAL_TRY(std::optional<Image> image, take_once(tally));
    if (image) return *std::move(image);
    ++n_tried;
    ++n_retaken_;
  }
  std::string lost = fmt::format("{} of {} frames were lost", n_tried, n_tried);
  if (tally.damaged > 0) lost += fmt::format(", {} of them with {}", tally.damaged, tally.last);
  if (tally.silent > 0) lost += fmt::format(", {} never came", tally.silent);
  return failure(problem(Code::DeviceFrame,
                         std::move(lost),
                         "a whole frame; see retries, packet and timeout_ms of the address"));
}

}  // namespace

bool has_gige_vision() {
  return true;
}

Expected<std::unique_ptr<CameraDevice>> open_gige_camera(const GigeAddress& address) {
  PANELCAL_TRY(internal::ReadyCamera ready, internal::set_up(address));
  auto camera = std::make_unique<GigeCamera>(address, std::move(ready.camera), ready.size);
  PANELCAL_CHECK(camera->begin_stream());
  return camera;
}

}  // namespace panelcal
