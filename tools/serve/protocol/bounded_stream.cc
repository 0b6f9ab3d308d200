// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/protocol/bounded_stream.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
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
  return limits_.transfer_time + Milliseconds(1000 * n_bytes / limits_.slowest_bytes_s);
}

bool BoundedStream::fill(Deadline deadline) {
  constexpr std::size_t kPiece_bytes = 4096;
  buffer_.resize(kPiece_bytes);
  at_ = 0;
  const std::size_t n = channel_.read_some(buffer_.data(), buffer_.size(), deadline);
  buffer_.resize(n);
  return n > 0;
}

bool BoundedStream::begin_request() {
  n_left_ = limits_.head_bytes;
  is_over_ = false;
  if (at_ == buffer_.size() && !fill(after(limits_.idle_time))) return false;
  deadline_ = after(limits_.head_time);
  return true;
}

bool BoundedStream::read_body(std::string& body, std::size_t n_bytes) {
  n_left_ = n_bytes;
  deadline_ = after(time_for(n_bytes));
  body.clear();
  std::array<char, 16384> piece{};
  while (body.size() < n_bytes) {
    const ssize_t n = read(piece.data(), std::min(piece.size(), n_bytes - body.size()));
    if (n <= 0) return false;
    body.append(piece.data(), static_cast<std::size_t>(n));
  }
  return true;
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
  if (n_left_ == 0) is_over_ = true;
  if (is_over_ || (at_ == buffer_.size() && !fill(deadline_))) return -1;
  const std::size_t n = std::min({size, buffer_.size() - at_, n_left_});
  std::memcpy(bytes, buffer_.data() + at_, n);
  at_ += n;
  n_left_ -= n;
  return static_cast<ssize_t>(n);
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
