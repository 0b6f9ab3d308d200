// SPDX-License-Identifier: Apache-2.0
#include "tests/machine/devices/cameras/fake_gige_camera.h"

#include <fstream>
#include <iostream>
#include <string>
#include <utility>

#include <arv.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace panelcal::test {
namespace {

/// Milliseconds would make long tests of many frames.
constexpr std::uint32_t kFramePeriod_us = 1000;

bool bring_up_loopback() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  ifreq request{};
  request.ifr_name[0] = 'l';
  request.ifr_name[1] = 'o';
  request.ifr_flags = IFF_UP | IFF_RUNNING;
  const bool is_up = ioctl(fd, SIOCSIFFLAGS, &request) == 0;
  close(fd);
  return is_up;
}

void draw_frame(
    ArvBuffer* buffer, void* camera, guint32 exposure_us, guint32 gain, ArvPixelFormat format) {
  std::size_t unused = 0;  // Aravis says 0 here
  const void* const bytes = arv_buffer_get_data(buffer, &unused);
  static_cast<const FakeGigeCamera*>(camera)->draw(
      const_cast<std::uint8_t*>(static_cast<const std::uint8_t*>(bytes)),
      exposure_us,
      gain,
      format);
}

}  // namespace

bool enter_own_network() {
  const std::string uid = std::to_string(getuid());
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  std::ofstream("/proc/self/uid_map") << "0 " << uid << " 1";
  return bring_up_loopback();
}

FakeGigeCamera::FakeGigeCamera(const char* address, int width_px, int height_px, Fill fill)
    : fill_(std::move(fill)),
      width_px_(width_px),
      height_px_(height_px),
      camera_(arv_gv_fake_camera_new(address, "PANEL1")) {
  ArvFakeCamera* const fake = arv_gv_fake_camera_get_fake_camera(camera_);
  const auto width = static_cast<std::uint32_t>(width_px);
  const auto height = static_cast<std::uint32_t>(height_px);
  arv_fake_camera_write_register(fake, ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, width);
  arv_fake_camera_write_register(fake, ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, height);
  arv_fake_camera_write_register(fake, ARV_FAKE_CAMERA_REGISTER_WIDTH, width);
  arv_fake_camera_write_register(fake, ARV_FAKE_CAMERA_REGISTER_HEIGHT, height);
  arv_fake_camera_write_register(
      fake, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, kFramePeriod_us);
  arv_fake_camera_set_fill_pattern(fake, draw_frame, this);
}

FakeGigeCamera::~FakeGigeCamera() {
  g_object_unref(camera_);
}

bool FakeGigeCamera::is_running() const {
  return arv_gv_fake_camera_is_running(camera_) != FALSE;
}

void FakeGigeCamera::lose(double share) {
  g_object_set(camera_, "gvsp-lost-ratio", share, nullptr);
}

void FakeGigeCamera::draw(std::uint8_t* bytes,
                          double exposure_us,
                          double gain,
                          std::uint32_t pixel_format) const {
  const std::size_t n_pixels =
      static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_);
  const std::size_t n_bytes = n_pixels * ARV_PIXEL_FORMAT_BIT_PER_PIXEL(pixel_format) / 8;
  fill_({{bytes, n_bytes}, exposure_us, gain, pixel_format});
}

int serve_until_input_ends(const FakeGigeCamera& camera) {
  if (!camera.is_running()) {
    std::cerr << "the port of GigE Vision is taken\n";
    return 3;
  }
  std::cout << "ready" << std::endl;
  while (std::cin.get() != std::char_traits<char>::eof()) {
  }
  return 0;
}

}  // namespace panelcal::test
