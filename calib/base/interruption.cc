// SPDX-License-Identifier: Apache-2.0
#include "calib/base/interruption.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <string>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace panelcal {
namespace {

std::atomic<int> seen_signal = 0;
std::atomic<int> event_fd = -1;
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may not wait");

extern "C" void note_interruption(int signal) {
  const int error = errno;
  seen_signal = signal;
  const std::uint64_t one = 1;
  // It cannot fail before 2^64 signals, and nothing could be done about it here.
  [[maybe_unused]] const ssize_t n = ::write(event_fd, &one, sizeof one);
  errno = error;
}

std::string signal_name(int signal) {
  switch (signal) {
    case SIGINT:
      return "SIGINT";
    case SIGTERM:
      return "SIGTERM";
    case SIGHUP:
      return "SIGHUP";
    default:
      return "signal " + std::to_string(signal);
  }
}

}  // namespace

void heed_interruptions() {
  if (event_fd >= 0) return;
  event_fd = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (event_fd < 0) return;
  struct sigaction action {};
  action.sa_handler = note_interruption;
  action.sa_flags = SA_RESETHAND | SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction present {};
    // A signal that the caller ignores, as nohup does, stays ignored.
    if (sigaction(signal, nullptr, &present) == 0 && present.sa_handler == SIG_IGN) continue;
    sigaction(signal, &action, nullptr);
  }
}

int interruption() {
  return seen_signal;
}

int interruption_fd() {
  return event_fd;
}

Expected<void> check_interruption() {
  const int signal = interruption();
  if (signal == 0) return {};
  return failure({Code::Interrupted, {"panelcal", 0, 0}, signal_name(signal), ""});
}

void sleep_for(Time time) {
  using Steady = std::chrono::steady_clock;
  const auto end = Steady::now() + std::chrono::duration_cast<Steady::duration>(
                                       std::chrono::duration<double>(time.in_s()));
  while (interruption() == 0) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Steady::now());
    if (left.count() <= 0) return;
    constexpr std::int64_t kLongest_ms = 60'000;
    pollfd interrupted{.fd = interruption_fd(), .events = POLLIN, .revents = 0};
    ::poll(&interrupted, 1, static_cast<int>(std::min<std::int64_t>(left.count(), kLongest_ms)));
  }
}

}  // namespace panelcal
