// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/opencv_camera.h"

#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "calib/base/files/file_descriptor.h"
#include "machine/devices/cameras/fresh_frame.h"
#include "machine/devices/cameras/without_password.h"
#include "machine/devices/module_path.h"
#include "machine/devices/video/video_reader.h"
#include "vision/picture/luma.h"
#include "vision/picture/stderr_capture.h"
#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>

namespace panelcal {
namespace {

constexpr const char* kModule = "libpanelcal_video.so";
/// Frames per second of a camera that does not tell its rate.
constexpr double kUsualRate = 30;
/// No camera is slower; a wrong rate must not make every frame look old.
constexpr double kSlowestRate = 1;
/// Pictures that may still be on their way through the sensor when an exposure is set.
constexpr int kOldExposures = 3;

/// The functions of the module.
struct VideoModule {
  decltype(&panelcal_video_open) open = nullptr;
  decltype(&panelcal_video_rate) rate = nullptr;
  decltype(&panelcal_video_grab) grab = nullptr;
  decltype(&panelcal_video_stamp_ms) stamp_ms = nullptr;
  decltype(&panelcal_video_decode) decode = nullptr;
  decltype(&panelcal_video_close) close = nullptr;
};

template <class Function>
bool find_symbol(void* library, const char* symbol, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, symbol));
  return function != nullptr;
}

Expected<VideoModule> load_module(const std::string& camera) {
  // Never unloaded: FFmpeg and GStreamer keep threads and handlers of their own.
  const std::string path = internal::module_path(kModule);
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  VideoModule module;
  if (library != nullptr && find_symbol(library, "panelcal_video_open", module.open) &&
      find_symbol(library, "panelcal_video_rate", module.rate) &&
      find_symbol(library, "panelcal_video_grab", module.grab) &&
      find_symbol(library, "panelcal_video_stamp_ms", module.stamp_ms) &&
      find_symbol(library, "panelcal_video_decode", module.decode) &&
      find_symbol(library, "panelcal_video_close", module.close)) {
    return module;
  }
  const char* const reason = dlerror();
  return failure(
      {Code::DeviceCamera,
       {camera, 0, 0},
       fmt::format("the video module cannot be loaded: {}", reason ? reason : kModule),
       fmt::format("{} where panelcal was installed, with OpenCV's videoio (Debian package "
                   "panelcal-cameras)",
                   kModule)});
}

std::string address_name(const VideoAddress& address) {
  switch (address.kind) {
    case VideoAddress::Kind::File:
      return "video:" + address.what;
    case VideoAddress::Kind::V4l2:
      return "v4l2:" + address.what;
    case VideoAddress::Kind::Rtsp:
      break;
  }
  return without_password(address.what);
}

/// FFmpeg says "[tcp @ 0x55d1c0] Connection failed": the address is another one every time, and of
/// no use.
std::string without_pointers(std::string words) {
  constexpr std::string_view kPointer = " @ 0x";
  for (auto at = words.find(kPointer); at != std::string::npos; at = words.find(kPointer, at)) {
    const auto end = words.find_first_not_of("0123456789abcdefABCDEF", at + kPointer.size());
    words.erase(at, (end == std::string::npos ? words.size() : end) - at);
  }
  return words;
}

/// Blue, green and red become luma as in read_image.
template <class Sample>
void copy_row(const Sample* samples, int channels, std::span<float> row) {
  for (float& level : row) {
    level = channels == 1 ? static_cast<float>(samples[0])
                          : internal::luma(static_cast<float>(samples[0]),
                                           static_cast<float>(samples[1]),
                                           static_cast<float>(samples[2]));
    samples += channels;
  }
}

Image image_of(const PanelcalVideoFrame& frame) {
  const bool is_wide = frame.bytes_per_sample == 2;
  Image image(frame.width, frame.height, is_wide ? Image::kFullScale16 : Image::kFullScale8);
  for (int y = 0; y < frame.height; ++y) {
    const unsigned char* const bytes = frame.pixels + static_cast<std::size_t>(y) * frame.row_bytes;
    if (is_wide) {
      copy_row(reinterpret_cast<const std::uint16_t*>(bytes), frame.channels, image.row(y));
    } else {
      copy_row(bytes, frame.channels, image.row(y));
    }
  }
  return image;
}

Time steady_time() {
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  return seconds(std::chrono::duration<double>(since).count());
}

/// Controls of a device beside OpenCV's own handle of it, after it has begun: OpenCV sets some.
Expected<internal::V4l2Controls> hold_controls(const VideoAddress& address,
                                               const std::string& name) {
  auto device = std::make_shared<internal::FileDescriptor>(
      ::open(address.what.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (device->get() < 0) {
    return failure({Code::DeviceCamera,
                    {name, 0, 0},
                    "its controls cannot be opened: " +
                        std::error_code(errno, std::generic_category()).message(),
                    "a camera that is on and not used by another program"});
  }
  internal::Ioctl ioctl = [device = std::move(device)](unsigned long request, void* argument) {
    int result = 0;
    do {
      result = ::ioctl(device->get(), request, argument);
    } while (result < 0 && errno == EINTR);
    return result < 0 ? errno : 0;
  };
  return internal::V4l2Controls::hold(name, std::move(ioctl), address.settings);
}

class OpenCvCamera final : public CameraDevice {
 public:
  OpenCvCamera(const VideoAddress& address, const VideoModule& module, PanelcalVideo* video)
      : name_(address_name(address)),
        is_live_(address.kind != VideoAddress::Kind::File),
        module_(module),
        video_(video) {
    double rate = module_.rate(video_);
    if (rate < kSlowestRate) rate = kUsualRate;
    period_ = seconds(1 / rate);
  }
  OpenCvCamera(const OpenCvCamera&) = delete;
  OpenCvCamera& operator=(const OpenCvCamera&) = delete;
  ~OpenCvCamera() override { module_.close(video_); }

  void set_controls(internal::V4l2Controls controls) { controls_ = std::move(controls); }

  Expected<Image> take() override {
    internal::StderrCapture capture;
    PANELCAL_CHECK(is_live_ ? grab_fresh() : grab_next());
    ++n_taken_;
    PanelcalVideoFrame frame{};
    if (module_.decode(video_, &frame) == 0) {
      return failure(problem(fmt::format("frame {} cannot be decoded", n_taken_), "a whole frame"));
    }
    if (controls_) PANELCAL_CHECK(controls_->check());
    return image_of(frame);
  }
  std::string name() const override { return name_; }
  std::vector<Diagnostic> risks() const override {
    return controls_ ? controls_->risks() : std::vector<Diagnostic>();
  }

  bool can_set(CameraSetting setting) const override {
    return setting == CameraSetting::Exposure && controls_ && controls_->can_set_exposure();
  }
  std::optional<double> value(CameraSetting setting) const override {
    if (!can_set(setting)) return std::nullopt;
    const std::optional<Time> exposure = controls_->exposure();
    return exposure ? std::optional(exposure->in_s() * 1e6) : std::nullopt;
  }
  Expected<void> set(CameraSetting setting, double value) override {
    if (!can_set(setting)) return CameraDevice::set(setting, value);
    n_old_ = kOldExposures;
    return controls_->set_exposure(seconds(value * 1e-6));
  }

 private:
  Diagnostic problem(std::string what, std::string expected) const {
    return {Code::DeviceFrame, {name_, 0, 0}, std::move(what), std::move(expected)};
  }

  Expected<void> grab_next() {
    if (module_.grab(video_) != 0) return {};
    return failure(problem(fmt::format("ends after {} frames", n_taken_), "a frame for each view"));
  }

  Expected<void> grab_fresh() {
    const auto grab = [this] { return module_.grab(video_) != 0; };
    const auto stamp = [this] { return seconds(module_.stamp_ms(video_) * 1e-3); };
    // A stamp may be of the last row's end: its frame began with the first row's exposure.
    const Time exposure = controls_ ? controls_->exposure().value_or(period_) : period_;
    switch (controls_ ? internal::grab_stamped_frame(
                            period_, period_ + exposure, grab, stamp, steady_time)
                      : internal::grab_fresh_frame(period_, grab, steady_time)) {
      case internal::FreshFrame::Grabbed:
        return pass_old_exposures();
      case internal::FreshFrame::Lost:
        return failure(problem("sends no frame any more", "the camera that was there before"));
      case internal::FreshFrame::Endless:
        break;
    }
    return failure(problem("old frames come without an end", "frames as fast as they are made"));
  }

  Expected<void> pass_old_exposures() {
    for (; n_old_ > 0; --n_old_) PANELCAL_CHECK(grab_next());
    return {};
  }

  std::string name_;
  bool is_live_;
  VideoModule module_;
  PanelcalVideo* video_;
  Time period_;
  std::optional<internal::V4l2Controls> controls_;  ///< of a V4L2 device
  int n_taken_ = 0;
  int n_old_ = 0;  ///< fresh frames to come that may have the exposure of before
};

}  // namespace

Expected<std::unique_ptr<CameraDevice>> open_opencv_camera(const VideoAddress& address) {
  const std::string name = address_name(address);
  const bool is_file = address.kind == VideoAddress::Kind::File;
  std::error_code error;
  if (address.kind != VideoAddress::Kind::Rtsp) {
    const auto status = std::filesystem::status(address.what, error);
    const auto type =
        is_file ? std::filesystem::file_type::regular : std::filesystem::file_type::character;
    if (error || status.type() != type) {
      return failure({is_file ? Code::FileUnreadable : Code::DeviceCamera,
                      {name, 0, 0},
                      error ? error.message() : std::string(is_file ? "no file" : "no device"),
                      is_file ? "a video file" : "a video device such as /dev/video0"});
    }
  }
  PANELCAL_TRY(const VideoModule module, load_module(name));
  internal::StderrCapture capture;
  PanelcalVideo* const video = module.open(
      static_cast<int>(address.kind), address.what.c_str(), address.width, address.height);
  const std::string words = without_pointers(capture.finish());
  if (video != nullptr) {
    auto camera = std::make_unique<OpenCvCamera>(address, module, video);
    if (address.kind == VideoAddress::Kind::V4l2) {
      PANELCAL_TRY(internal::V4l2Controls controls, hold_controls(address, name));
      camera->set_controls(std::move(controls));
    }
    return camera;
  }
  return failure({is_file ? Code::PictureFormat : Code::DeviceCamera,
                  {name, 0, 0},
                  is_file ? "not a video that FFmpeg reads"
                          : "cannot be opened" + (words.empty() ? "" : ": " + quoted(words)),
                  is_file ? "a video" : "a camera that is on and not used by another program"});
}

}  // namespace panelcal
