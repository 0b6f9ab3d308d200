// SPDX-License-Identifier: Apache-2.0
#include "calib/base/interruption.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <ctime>
#include <string>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace panelcal {
namespace {

std::atomic<int> seen_signal = 0;
std::atomic<int> event_fd = -1;
/// When that came; 0: not yet.
std::atomic<std::int64_t> first_ms = 0;
/// `timeout` and terminals may signal a process and then its group: that is one signal, and the
/// stage has this time at least to halt by itself.
constexpr std::int64_t kOneSignal_ms = 500;
/// 0 where there is none. A program that finds no place here is halted all the same, but not by a
/// second signal: no machine moves as many at once.
std::array<std::atomic<pid_t>, 16> halted_groups{};
static_assert(std::atomic<int>::is_always_lock_free &&
                  std::atomic<std::int64_t>::is_always_lock_free &&
                  std::atomic<pid_t>::is_always_lock_free,
              "a signal handler may not wait");

/// True if there was one.
bool end_halted_groups() {
  bool is_any = false;
  for (const std::atomic<pid_t>& group : halted_groups) {
    const pid_t number = group;
    if (number <= 0) continue;
    is_any = true;
    ::kill(-number, SIGKILL);
  }
  return is_any;
}

void end_by(int signal) {
  std::signal(signal, SIG_DFL);
  // Pending until this handler is left.
  ::raise(signal);
}

extern "C" void end_all_at_once(int signal) {
  end_halted_groups();
  end_by(signal);
}

std::int64_t monotonic_ms() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return 1000 * std::int64_t{now.tv_sec} + now.tv_nsec / 1'000'000;
}

extern "C" void note_interruption(int signal) {
  const int error = errno;
  const std::int64_t now_ms = monotonic_ms();
  std::int64_t none = 0;
  if (first_ms.compare_exchange_strong(none, now_ms)) {
    seen_signal = signal;
  } else if (now_ms - first_ms >= kOneSignal_ms) {
    seen_signal = signal;
    if (!end_halted_groups()) end_by(signal);
  }
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
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    action.sa_handler = signal == SIGQUIT ? end_all_at_once : note_interruption;
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

HaltedGroup::HaltedGroup(pid_t group) : group_(group) {
  for (std::atomic<pid_t>& place : halted_groups) {
    pid_t none = 0;
    if (place.compare_exchange_strong(none, group_)) return;
  }
}

HaltedGroup::~HaltedGroup() {
  for (std::atomic<pid_t>& place : halted_groups) {
    pid_t own = group_;
    if (place.compare_exchange_strong(own, 0)) return;
  }
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
