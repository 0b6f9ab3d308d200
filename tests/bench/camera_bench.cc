// SPDX-License-Identifier: Apache-2.0
// Number of fiducials a second that one core measures from GigE Vision frames of 640 x 480 px,
// Mono8.
//
//   camera_bench [FRAMES]
//
// A process of its own, on another core, serves rendered pictures through Aravis's camera over the
// real protocol. Columns: frames found and frames that arrived damaged; frames a second by the
// clock and by processor time; ms of processor time a frame. Aravis's camera answers triggers at 25
// frames a second only, so the frames run free here; what is done with each is what GigeCamera and
// locate do with it.
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include "machine/devices/gige_vision/gige_objects.h"
#include "machine/devices/gige_vision/gige_pixels.h"
#include "vision/locate/locate.h"
#include "vision/render/render.h"
#include <fmt/format.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/machine/devices/cameras/fake_gige_camera.h"

namespace panelcal::bench {
namespace {

using internal::DeviceError;
using internal::Object;

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr int kPictures = 8;
constexpr double kRadius_px = 40;
constexpr double kScale_mm = 0.01;
constexpr std::uint64_t kSeed = 20261121;

CameraMapping::Parameters parameters() {
  CameraMapping::Parameters p;
  p.scale_mm_per_px = kScale_mm;
  p.axis_px << 0.5 * (kWidth - 1), 0.5 * (kHeight - 1);
  return p;
}

/// Clean pictures of a pad near the middle: contrast 140 of 255, noise 2, blur 1.
std::vector<Image> make_pictures() {
  Camera camera{.mapping = CameraMapping(parameters()), .width = kWidth, .height = kHeight};
  camera.noise = 2;
  std::vector<Image> pictures;
  for (int i = 0; i < kPictures; ++i) {
    Random random = Random(kSeed).fork(static_cast<std::uint64_t>(i));
    Feature pad;
    pad.center =
        position_mm<frame::Optical>(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05));
    pad.size = mm(2 * kRadius_px * kScale_mm);
    pad.level = 180.0 / 255;
    Scene scene;
    scene.background = 40.0 / 255;
    scene.features = {pad};
    pictures.push_back(render(scene, camera, random));
  }
  return pictures;
}

void stay_on_core(int core) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(core, &cores);
  sched_setaffinity(0, sizeof cores, &cores);
}

/// The camera's process; ends with `quit`.
[[noreturn]] void serve(int ready, int quit) {
  stay_on_core(0);
  const std::vector<Image> pictures = make_pictures();
  std::size_t n = 0;
  test::FakeGigeCamera camera("127.0.0.1", kWidth, kHeight, [&](const test::FakeFrame& frame) {
    const auto pixels = pictures[n++ % pictures.size()].pixels();
    for (std::size_t i = 0; i < frame.bytes.size(); ++i) {
      frame.bytes[i] = static_cast<std::uint8_t>(pixels[i]);
    }
  });
  const char state = camera.is_running() ? 'y' : 'n';
  char none = 0;
  if (write(ready, &state, 1) == 1) static_cast<void>(!read(quit, &none, 1));
  std::_Exit(0);
}

struct Count {
  int found = 0;
  int not_found = 0;
  int damaged = 0;
  double convert_s = 0;  ///< processor time
  double locate_s = 0;   ///< processor time
  double cpu_s = 0;      ///< of the whole process: receiving as well
  double wall_s = 0;
};

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Processor time of this thread: what others run on the core does not count.
double thread_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

LocateOptions options_of(bool is_area_known) {
  LocateOptions options;
  if (is_area_known) {
    options.search_center = position_px<frame::Image>(Eigen::Vector2d(319.5, 239.5));
    options.search_radius = px(10);
  }
  return options;
}

Count measure(ArvStream& stream, int n_frames, bool is_area_known) {
  const CameraMapping mapping{parameters()};
  const LocateOptions options = options_of(is_area_known);
  const Target target{.size = mm(2 * kRadius_px * kScale_mm)};
  Count count;
  const double cpu_before_s = cpu_s();
  const double begin_s = now_s();
  while (count.found + count.not_found < n_frames) {
    ArvBuffer* const buffer = arv_stream_timeout_pop_buffer(&stream, 2'000'000);
    if (buffer == nullptr) break;
    const double t0 = thread_s();
    if (arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS) {
      ++count.damaged;
      arv_stream_push_buffer(&stream, buffer);
      continue;
    }
    const auto image = internal::image_of(*buffer, "bench");
    arv_stream_push_buffer(&stream, buffer);
    const double t1 = thread_s();
    const bool is_found =
        image && locate(*image, target, &mapping, options).status == DetectionStatus::Found;
    count.locate_s += thread_s() - t1;
    count.convert_s += t1 - t0;
    ++(is_found ? count.found : count.not_found);
  }
  count.wall_s = now_s() - begin_s;
  count.cpu_s = cpu_s() - cpu_before_s;
  return count;
}

void print(const char* what, const Count& c) {
  const double n = c.found + c.not_found;
  fmt::print("{:<28} {:5} {:8} {:8.1f} {:8.1f} {:9.3f} {:9.3f} {:9.3f}\n",
             what,
             c.found,
             c.damaged,
             n / c.wall_s,
             n / c.cpu_s,
             1e3 * (c.cpu_s - c.convert_s - c.locate_s) / n,
             1e3 * c.convert_s / n,
             1e3 * c.locate_s / n);
}

int run_client(int n_frames) {
  stay_on_core(1);
  DeviceError error;
  const Object<ArvDevice> device(
      arv_interface_open_device(arv_gv_interface_get_instance(), "127.0.0.1", error.out()));
  if (!device) return std::fprintf(stderr, "%s\n", error.text().c_str()), 3;
  const Object<ArvCamera> camera(arv_camera_new_with_device(device.get(), error.out()));
  arv_camera_gv_set_packet_size(camera.get(), 1500, error.out());
  arv_camera_clear_triggers(camera.get(), error.out());
  const Object<ArvStream> stream(
      arv_camera_create_stream(camera.get(), nullptr, nullptr, error.out()));
  if (!stream) return std::fprintf(stderr, "%s\n", error.text().c_str()), 3;
  const std::size_t bytes = arv_camera_get_payload(camera.get(), error.out());
  for (int i = 0; i < 4; ++i) arv_stream_push_buffer(stream.get(), arv_buffer_new_allocate(bytes));
  arv_camera_start_acquisition(camera.get(), error.out());
  fmt::print("{:<28} {:>5} {:>8} {:>8} {:>8} {:>9} {:>9} {:>9}\n",
             "640 x 480 Mono8, packet 1500",
             "found",
             "damaged",
             "per s",
             "cpu 1/s",
             "receive",
             "convert",
             "locate");
  print("place known to 10 px", measure(*stream, n_frames, true));
  print("whole picture", measure(*stream, n_frames, false));
  arv_camera_stop_acquisition(camera.get(), error.out());
  return 0;
}

int run(int n_frames) {
  test::enter_own_network();
  std::array<int, 2> ready{};
  std::array<int, 2> quit{};
  if (pipe(ready.data()) != 0 || pipe(quit.data()) != 0) return 3;
  const pid_t child = fork();
  if (child == 0) serve(ready[1], quit[0]);
  char state = 'n';
  const bool is_serving = child > 0 && read(ready[0], &state, 1) == 1 && state == 'y';
  const int code = is_serving ? run_client(n_frames) : 3;
  if (child > 0) {
    static_cast<void>(!write(quit[1], "q", 1));
    waitpid(child, nullptr, 0);
  }
  return code;
}

}  // namespace
}  // namespace panelcal::bench

int main(int argc, char** argv) {
  return panelcal::bench::run(argc > 1 ? std::atoi(argv[1]) : 400);
}
