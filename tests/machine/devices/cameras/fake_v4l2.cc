// SPDX-License-Identifier: Apache-2.0
// A USB camera for programs that are started with this library in LD_PRELOAD: /dev/zero answers the
// ioctls of Video4Linux, as the media documentation describes them. Settings by the environment:
//
//   FAKE_V4L2_FRAME    file of width x height grey bytes, read when a frame's exposure begins
//   FAKE_V4L2_SIZE     "640 480"
//   FAKE_V4L2_REFUSES  control ids in hexadecimal, with spaces, whose orders end in EIO
//   FAKE_V4L2_LIVES    frames until the cable is pulled
//   FAKE_V4L2_LOG      file that gets a line for each order: id in hexadecimal, value
//
// Four buffers keep the oldest frames until they are asked for, as USB cameras' drivers do.
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <dlfcn.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <unistd.h>

namespace {

constexpr int kBuffers = 4;
constexpr std::chrono::milliseconds kPeriod(33);

struct Control {
  std::int32_t low;
  std::int32_t high;
  std::int32_t value;
};

std::string environment(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr ? value : "";
}

class FakeCamera {
 public:
  FakeCamera() {
    std::istringstream(environment("FAKE_V4L2_SIZE")) >> width_ >> height_;
    std::istringstream refused(environment("FAKE_V4L2_REFUSES"));
    for (std::uint32_t id = 0; refused >> std::hex >> id;) refuses_.insert(id);
    const std::string lives = environment("FAKE_V4L2_LIVES");
    if (!lives.empty()) n_to_live_ = std::stoi(lives);
  }
  ~FakeCamera() { stop(); }

  /// 0 or errno.
  int answer(unsigned long request, void* argument) {
    if (request == VIDIOC_STREAMOFF) return stop();
    const std::lock_guard lock(mutex_);
    if (is_gone_) return ENODEV;
    switch (request) {
      case VIDIOC_QUERYCAP:
        return capabilities(*static_cast<v4l2_capability*>(argument));
      case VIDIOC_G_INPUT:
      case VIDIOC_S_INPUT:
      case VIDIOC_ENUMINPUT:
        return 0;
      case VIDIOC_G_PARM:
      case VIDIOC_S_PARM:
        return rate(*static_cast<v4l2_streamparm*>(argument));
      case VIDIOC_G_FMT:
      case VIDIOC_S_FMT:
        return format(*static_cast<v4l2_format*>(argument));
      case VIDIOC_REQBUFS:
        return ask_buffers(*static_cast<v4l2_requestbuffers*>(argument));
      case VIDIOC_QUERYBUF:
        return describe(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_QBUF:
        queued_.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF:
        return give(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
        is_streaming_ = true;
        thread_ = std::thread([this] { expose(); });
        return 0;
      case VIDIOC_QUERYCTRL:
        return query(*static_cast<v4l2_queryctrl*>(argument));
      case VIDIOC_G_CTRL:
      case VIDIOC_S_CTRL:
        return control(request, *static_cast<v4l2_control*>(argument));
      default:
        return ENOTTY;
    }
  }

  void* map(std::size_t length, off_t offset) {
    void* const memory =
        ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    const std::lock_guard lock(mutex_);
    memory_.at(static_cast<std::size_t>(offset) / bytes()) = memory;
    return memory;
  }

  void wait_for_frame() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !done_.empty() || is_gone_ || !is_streaming_; });
  }

 private:
  struct Done {
    std::uint32_t index;
    timeval begin;
  };

  std::size_t bytes() const { return static_cast<std::size_t>(width_) * height_; }

  static int capabilities(v4l2_capability& out) {
    std::strcpy(reinterpret_cast<char*>(out.driver), "fake");
    out.capabilities = out.device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
    return 0;
  }
  static int rate(v4l2_streamparm& out) {
    out.parm.capture.timeperframe = {1, 30};
    return 0;
  }
  int format(v4l2_format& out) const {
    out.fmt.pix.width = width_;
    out.fmt.pix.height = height_;
    out.fmt.pix.pixelformat = V4L2_PIX_FMT_GREY;
    out.fmt.pix.field = V4L2_FIELD_NONE;
    out.fmt.pix.bytesperline = width_;
    out.fmt.pix.sizeimage = static_cast<std::uint32_t>(bytes());
    return 0;
  }
  int ask_buffers(v4l2_requestbuffers& out) {
    out.count = std::min<std::uint32_t>(out.count, kBuffers);
    queued_.clear();
    done_.clear();
    return 0;
  }
  int describe(v4l2_buffer& out) const {
    out.length = static_cast<std::uint32_t>(bytes());
    out.m.offset = out.index * out.length;
    return 0;
  }
  int give(v4l2_buffer& out) {
    if (done_.empty()) return EAGAIN;
    out.index = done_.front().index;
    out.timestamp = done_.front().begin;
    out.length = out.bytesused = static_cast<std::uint32_t>(bytes());
    out.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    done_.pop_front();
    return 0;
  }
  int query(v4l2_queryctrl& out) const {
    const auto found = controls_.find(out.id);
    if (found == controls_.end()) return EINVAL;
    out.minimum = found->second.low;
    out.maximum = found->second.high;
    out.step = 1;
    out.flags = 0;
    return 0;
  }
  int control(unsigned long request, v4l2_control& asked) {
    const auto found = controls_.find(asked.id);
    if (found == controls_.end()) return EINVAL;
    if (request == VIDIOC_G_CTRL) {
      asked.value = found->second.value;
      return 0;
    }
    const std::string log = environment("FAKE_V4L2_LOG");
    if (!log.empty()) {
      std::ofstream(log, std::ios::app)
          << std::hex << asked.id << std::dec << ' ' << asked.value << '\n';
    }
    if (refuses_.contains(asked.id)) return EIO;
    found->second.value = asked.value;
    return 0;
  }

  int stop() {
    {
      const std::lock_guard lock(mutex_);
      is_streaming_ = false;
      changed_.notify_all();
    }
    if (thread_.joinable()) thread_.join();
    return 0;
  }

  /// The picture is that of the exposure's begin, however late the frame is asked for.
  void expose() {
    const std::string file = environment("FAKE_V4L2_FRAME");
    std::unique_lock lock(mutex_);
    while (is_streaming_) {
      lock.unlock();
      timespec begin{};
      clock_gettime(CLOCK_MONOTONIC, &begin);
      std::ifstream stream(file, std::ios::binary);
      std::vector<char> frame{std::istreambuf_iterator<char>(stream), {}};
      std::this_thread::sleep_for(kPeriod);
      lock.lock();
      if (n_to_live_ == 0) is_gone_ = true;
      if (!is_gone_ && !queued_.empty()) {
        const std::uint32_t index = queued_.front();
        queued_.pop_front();
        frame.resize(bytes());
        std::memcpy(memory_.at(index), frame.data(), frame.size());
        done_.push_back({index, {begin.tv_sec, begin.tv_nsec / 1000}});
        --n_to_live_;
      }
      changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::thread thread_;
  std::uint32_t width_ = 640;
  std::uint32_t height_ = 480;
  std::set<std::uint32_t> refuses_;
  int n_to_live_ = -1;  ///< for ever
  bool is_gone_ = false;
  bool is_streaming_ = false;
  std::array<void*, kBuffers> memory_{};
  std::deque<std::uint32_t> queued_;
  std::deque<Done> done_;
  /// Everything is automatic, as a camera is plugged in.
  std::map<std::uint32_t, Control> controls_ = {
      {V4L2_CID_FOCUS_AUTO, {0, 1, 1}},
      {V4L2_CID_FOCUS_ABSOLUTE, {0, 250, 0}},
      {V4L2_CID_EXPOSURE_AUTO, {0, 3, V4L2_EXPOSURE_APERTURE_PRIORITY}},
      {V4L2_CID_EXPOSURE_ABSOLUTE, {3, 2047, 100}},
      {V4L2_CID_AUTO_WHITE_BALANCE, {0, 1, 1}},
      {V4L2_CID_GAIN, {0, 255, 0}},
      {V4L2_CID_POWER_LINE_FREQUENCY, {0, 2, 2}},
  };
};

FakeCamera& camera() {
  static FakeCamera one;
  return one;
}

bool is_camera(int fd) {
  struct stat status {};
  return fd >= 0 && fstat(fd, &status) == 0 && S_ISCHR(status.st_mode) &&
         status.st_rdev == makedev(1, 5);
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

#pragma GCC visibility push(default)
extern "C" {

int ioctl(int fd, unsigned long request, ...) noexcept {
  va_list list;
  va_start(list, request);
  void* const argument = va_arg(list, void*);
  va_end(list);
  if (_IOC_TYPE(request) != 'V' || !is_camera(fd)) {
    static auto* const real = next<int(int, unsigned long, ...)>("ioctl");
    return real(fd, request, argument);
  }
  const int error = camera().answer(request, argument);
  if (error == 0) return 0;
  errno = error;
  return -1;
}

/// The fake's own buffers are no camera's.
void* mmap(void* address, size_t length, int access, int flags, int fd, off_t offset) noexcept {
  if (is_camera(fd)) return camera().map(length, offset);
  // dlsym() itself may ask for memory.
  return reinterpret_cast<void*>(syscall(SYS_mmap, address, length, access, flags, fd, offset));
}

int select(int n, fd_set* reading, fd_set* writing, fd_set* others, timeval* limit) {
  if (reading != nullptr && n > 0 && FD_ISSET(n - 1, reading) && is_camera(n - 1)) {
    camera().wait_for_frame();
    return 1;
  }
  static auto* const real = next<int(int, fd_set*, fd_set*, fd_set*, timeval*)>("select");
  return real(n, reading, writing, others, limit);
}

}  // extern "C"
#pragma GCC visibility pop
