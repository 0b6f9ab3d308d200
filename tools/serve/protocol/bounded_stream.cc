// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/protocol/bounded_stream.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <string_view>
#include <tuple>

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>

namespace panelcal::serve {
namespace {

using Milliseconds = std::chrono::milliseconds;

Deadline after(Milliseconds time) {
  return std::chrono::steady_clock::now() + time;
}

/// Address and port of one end of a socket, by getsockname or getpeername.
std::pair<std::string, int> end_of(int socket, int (*ask)(int, sockaddr*, socklen_t*)) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  constexpr int kNumbers = NI_NUMERICHOST | NI_NUMERICSERV;
  if (ask(socket, any, &size) != 0 ||
      ::getnameinfo(any, size, host.data(), host.size(), port.data(), port.size(), kNumbers) != 0) {
    return {};
  }
  int number = 0;
  std::from_chars(port.data(), port.data() + std::strlen(port.data()), number);
  return {host.data(), number};
}

}  // namespace

Milliseconds BoundedStream::time_for(std::size_t n_bytes) const {
  constexpr Milliseconds kLongest{300'000};
  return std::min(kLongest,
                  limits_.transfer_time + Milliseconds(1000 * n_bytes / limits_.slowest_bytes_s));
}

bool BoundedStream::receive(Deadline deadline) {
  std::array<char, 16384> piece{};
  const std::size_t n = channel_.read_some(piece.data(), piece.size(), deadline);
  buffer_.append(piece.data(), n);
  return n > 0;
}

std::optional<std::string> BoundedStream::read_head() {
  constexpr std::string_view kEnd = "\r\n\r\n";
  if (buffer_.empty() && !receive(after(limits_.idle_time))) return std::nullopt;
  const Deadline deadline = after(limits_.head_time);
  while (true) {
    const std::size_t end = buffer_.find(kEnd);
    if (std::min(end, buffer_.size()) > limits_.head_bytes) return std::string();
    if (end != buffer_.npos) {
      std::string head = buffer_.substr(0, end + kEnd.size());
      buffer_.erase(0, head.size());
      return head;
    }
    if (!receive(deadline)) return std::nullopt;
  }
}

bool BoundedStream::read_body(std::string& body, std::size_t n_bytes) {
  const Deadline deadline = after(time_for(n_bytes));
  while (buffer_.size() < n_bytes) {
    if (!receive(deadline)) return false;
  }
  body = buffer_.substr(0, n_bytes);
  buffer_.erase(0, n_bytes);
  return true;
}

void BoundedStream::pause(Milliseconds time) const {
  wait_for(socket_, POLLRDHUP, after(time));
}

void BoundedStream::drain() {
  ::shutdown(socket_, SHUT_WR);
  std::array<char, 16384> piece{};
  constexpr std::size_t kEnough_bytes = std::size_t{1} << 20;
  const Deadline deadline = after(Milliseconds(500));
  for (std::size_t n_bytes = 0; n_bytes < kEnough_bytes;) {
    const ssize_t n = ::recv(socket_, piece.data(), piece.size(), 0);
    if (n > 0) {
      n_bytes += static_cast<std::size_t>(n);
    } else if (n == 0 || !wait_for(socket_, POLLIN, deadline)) {
      return;
    }
  }
}

bool BoundedStream::is_open() const {
  pollfd asked{.fd = socket_, .events = POLLRDHUP, .revents = 0};
  return is_usable_ && ::poll(&asked, 1, 0) == 0;
}

ssize_t BoundedStream::read(char* bytes, size_t size) {
  const std::size_t n = given_.copy(bytes, size);
  given_.erase(0, n);
  return n > 0 ? static_cast<ssize_t>(n) : -1;
}

ssize_t BoundedStream::write(const char* bytes, size_t size) {
  if (is_usable_) is_usable_ = channel_.write_all({bytes, size}, after(time_for(size)));
  return is_usable_ ? static_cast<ssize_t>(size) : -1;
}

void BoundedStream::get_remote_ip_and_port(std::string& address, int& port) const {
  std::tie(address, port) = end_of(socket_, ::getpeername);
}

void BoundedStream::get_local_ip_and_port(std::string& address, int& port) const {
  std::tie(address, port) = end_of(socket_, ::getsockname);
}

}  // namespace panelcal::serve
