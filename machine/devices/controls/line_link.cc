// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/line_link.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <system_error>

#include "calib/base/interruption.h"
#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

namespace panelcal {
namespace {

using LinkClock = std::chrono::steady_clock;

constexpr std::size_t kMaxLine = std::size_t{64} << 10;
constexpr auto kLongestSend = std::chrono::seconds(5);

LinkClock::time_point link_deadline(Time within) {
  return LinkClock::now() + std::chrono::duration_cast<LinkClock::duration>(
                                std::chrono::duration<double>(within.in_s()));
}

std::string link_error(int error) {
  return std::generic_category().message(error);
}

Diagnostic link_problem(const std::string& name, std::string what, std::string expected) {
  return {Code::DeviceStage, {name, 0, 0}, std::move(what), std::move(expected)};
}

/// Waits for an event of a descriptor; 0: the time is over, or a signal asked to end.
short wait_for(int fd, short events, LinkClock::time_point until, bool heeds_signals) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - LinkClock::now());
    std::array<pollfd, 2> waiting = {
        {{.fd = fd, .events = events, .revents = 0},
         {.fd = heeds_signals ? interruption_fd() : -1, .events = POLLIN, .revents = 0}}};
    constexpr std::int64_t kLongest_ms = 1000;
    poll(waiting.data(),
         waiting.size(),
         static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, kLongest_ms)));
    if (waiting[0].revents != 0) return waiting[0].revents;
    if (left.count() <= 0 || (heeds_signals && interruption() != 0)) return 0;
  }
}

std::optional<speed_t> speed_of(int baud) {
  constexpr std::array<std::pair<int, speed_t>, 14> kSpeeds = {{{1200, B1200},
                                                                {2400, B2400},
                                                                {4800, B4800},
                                                                {9600, B9600},
                                                                {19200, B19200},
                                                                {38400, B38400},
                                                                {57600, B57600},
                                                                {115200, B115200},
                                                                {230400, B230400},
                                                                {460800, B460800},
                                                                {921600, B921600},
                                                                {1000000, B1000000},
                                                                {2000000, B2000000},
                                                                {4000000, B4000000}}};
  for (const auto& [rate, speed] : kSpeeds) {
    if (rate == baud) return speed;
  }
  return std::nullopt;
}

/// A plug that is pulled is noticed within seconds, and no order waits for the next one.
void watch_socket(int fd) {
  const auto set = [fd](int level, int option, int value) {
    setsockopt(fd, level, option, &value, sizeof value);
  };
  constexpr int kNoAnswer_ms = 5000;
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 2);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 1);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, kNoAnswer_ms);
}

/// An errno, 0 if it is connected.
int connect_within(int fd,
                   const addrinfo& address,
                   LinkClock::time_point until,
                   bool heeds_signals) {
  if (connect(fd, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  if (wait_for(fd, POLLOUT, until, heeds_signals) == 0) {
    return heeds_signals && interruption() != 0 ? EINTR : ETIMEDOUT;
  }
  int error = 0;
  socklen_t size = sizeof error;
  getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

}  // namespace

Expected<std::unique_ptr<LineLink>> LineLink::tcp(const std::string& host,
                                                  int port,
                                                  Time limit,
                                                  bool heeds_signals) {
  const std::string name = fmt::format("{}:{}", host, port);
  const std::string expected = "a control that listens there, switched on and in reach";
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found)) {
    return failure(link_problem(
        name, std::string("no connection: ") + gai_strerror(error), "name or address of a host"));
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> addresses(found, freeaddrinfo);
  const auto until = link_deadline(limit);
  int error = EADDRNOTAVAIL;
  for (const addrinfo* address = found; address != nullptr; address = address->ai_next) {
    internal::FileDescriptor fd(socket(address->ai_family,
                                       address->ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK,
                                       address->ai_protocol));
    error = fd.get() < 0 ? errno : connect_within(fd.get(), *address, until, heeds_signals);
    if (heeds_signals) PANELCAL_CHECK(check_interruption());
    if (error != 0) continue;
    watch_socket(fd.get());
    return std::unique_ptr<LineLink>(new LineLink(std::move(fd), name));
  }
  return failure(link_problem(name, "no connection: " + link_error(error), expected));
}

Expected<std::unique_ptr<LineLink>> LineLink::serial(const std::string& device, int baud) {
  const auto refuse = [&](int error, std::string expected) {
    return failure(
        link_problem(device, "cannot be opened: " + link_error(error), std::move(expected)));
  };
  const auto speed = speed_of(baud);
  if (!speed) {
    return failure(link_problem(device, fmt::format("no speed of {} baud", baud), "115200"));
  }
  internal::FileDescriptor fd(open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (fd.get() < 0) {
    return refuse(errno, "a serial device that is plugged in and that this user may open");
  }
  if (flock(fd.get(), LOCK_EX | LOCK_NB) != 0) {
    return failure(link_problem(
        device, "in use by another program", "that program closed, or another device"));
  }
  termios setting{};
  if (tcgetattr(fd.get(), &setting) != 0) return refuse(errno, "a serial device");
  cfmakeraw(&setting);
  // Without HUPCL the next program that opens an Arduino does not reset it by our closing.
  setting.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS | HUPCL);
  setting.c_cflag |= CLOCAL | CREAD;
  cfsetispeed(&setting, *speed);
  cfsetospeed(&setting, *speed);
  if (tcsetattr(fd.get(), TCSANOW, &setting) != 0) return refuse(errno, "a serial device");
  ioctl(fd.get(), TIOCEXCL);
  tcflush(fd.get(), TCIOFLUSH);
  return std::unique_ptr<LineLink>(new LineLink(std::move(fd), device));
}

Diagnostic LineLink::problem(std::string what) const {
  return link_problem(name_, std::move(what), "a control that stays connected");
}

Expected<void> LineLink::send(std::string_view bytes) {
  const auto until = LinkClock::now() + kLongestSend;
  while (!bytes.empty()) {
    // A socket that the other side has closed would end this process by a signal.
    ssize_t n = ::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == ENOTSOCK) n = write(fd_.get(), bytes.data(), bytes.size());
    if (n >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(n));
    } else if (errno != EAGAIN && errno != EINTR) {
      return failure(problem("lost connection: " + link_error(errno)));
    } else if (wait_for(fd_.get(), POLLOUT, until, false) == 0) {
      return failure(problem("lost connection: the control takes nothing for 5 s"));
    }
  }
  return {};
}

Expected<void> LineLink::take() {
  std::array<char, 4096> piece{};
  const ssize_t n = read(fd_.get(), piece.data(), piece.size());
  if (n > 0) {
    received_.append(piece.data(), static_cast<std::size_t>(n));
  } else if (n == 0) {
    return failure(problem("lost connection: the control has closed it"));
  } else if (errno != EAGAIN && errno != EINTR) {
    return failure(problem("lost connection: " + link_error(errno)));
  }
  return {};
}

std::optional<std::string> LineLink::next_line() {
  const std::size_t end = received_.find('\n');
  if (end == std::string::npos) return std::nullopt;
  std::string line = received_.substr(0, end);
  received_.erase(0, end + 1);
  while (!line.empty() && line.back() == '\r') line.pop_back();
  return line;
}

Expected<std::optional<std::string>> LineLink::line(Time within, bool heeds_signals) {
  const auto until = link_deadline(within);
  for (;;) {
    if (heeds_signals) PANELCAL_CHECK(check_interruption());
    if (std::optional<std::string> line = next_line()) return line;
    if (received_.size() > kMaxLine) return failure(problem("a line of more than 64 KiB"));
    if (wait_for(fd_.get(), POLLIN, until, heeds_signals) != 0) {
      PANELCAL_CHECK(take());
    } else if (!heeds_signals || interruption() == 0) {
      return std::optional<std::string>();
    }
  }
}

}  // namespace panelcal
