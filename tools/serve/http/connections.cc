// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/http/connections.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <exception>
#include <string_view>
#include <utility>

#include "tools/serve/access/attempts.h"
#include "tools/serve/access/origin.h"
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace panelcal::serve {
namespace {

constexpr std::string_view kFull =
    "HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nContent-Length: 0\r\n\r\n";

void set_options(int socket) {
  const auto set = [socket](int level, int option, int value) {
    ::setsockopt(socket, level, option, &value, sizeof value);
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  // A screen that vanished without a word is noticed after this time, and frees the controls.
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, 15'000);
}

std::string address_text(const sockaddr_storage& address, socklen_t size) {
  std::array<char, NI_MAXHOST> host{};
  const auto* const any = reinterpret_cast<const sockaddr*>(&address);
  const int failed = ::getnameinfo(any, size, host.data(), host.size(), nullptr, 0, NI_NUMERICHOST);
  return failed == 0 ? host.data() : "";
}

}  // namespace

Connections::~Connections() {
  {
    const std::lock_guard lock(mutex_);
    for (auto& [number, connection] : connections_) {
      if (!connection.is_over) ::shutdown(connection.socket, SHUT_RDWR);
    }
  }
  // No thread but that of run() adds any or takes any away.
  for (auto& [number, connection] : connections_) connection.thread.join();
}

void Connections::join_finished() {
  std::vector<std::thread> finished;
  {
    const std::lock_guard lock(mutex_);
    for (auto& [number, connection] : connections_) {
      if (connection.is_over) finished.push_back(std::move(connection.thread));
    }
    std::erase_if(connections_, [](const auto& entry) { return entry.second.is_over; });
  }
  for (std::thread& thread : finished) thread.join();
}

/// Ends the connection that has been idle longest and shows no person; false: there is none. Its
/// thread ends a moment later, so that there may be a few more than allowed.
bool Connections::make_room() {
  Connection* oldest = nullptr;
  for (auto& [number, connection] : connections_) {
    const ConnectionNote& note = connection.note;
    if (connection.is_over || connection.is_shut || note.is_trusted || note.is_busy) continue;
    if (oldest == nullptr || note.idle_since < oldest->note.idle_since) oldest = &connection;
  }
  if (oldest == nullptr) return false;
  ::shutdown(oldest->socket, SHUT_RDWR);
  oldest->is_shut = true;
  return true;
}

bool Connections::has_place_for(const std::string& address) {
  const std::lock_guard lock(mutex_);
  std::size_t n_open = 0;
  std::size_t n_own = 0;
  for (const auto& [number, connection] : connections_) {
    if (connection.is_shut) continue;
    ++n_open;
    if (connection.address == address) ++n_own;
  }
  if (n_own >= counts_.n_per_address && !is_loopback(address)) return false;
  if (connections_.size() >= 2 * counts_.n_in_total) return false;
  return n_open < counts_.n_in_total || make_room();
}

bool Connections::begin(int socket, const std::string& address) {
  const std::lock_guard lock(mutex_);
  const std::size_t number = next_++;
  try {
    Connection& connection = connections_[number];
    connection.socket = socket;
    connection.address = address;
    connection.thread = std::thread([this, socket, &connection] {
      try {
        serve_(socket, connection.note);
      } catch (...) {
        // Of this connection alone, such as no memory for its response.
      }
      // Closed under the lock: a number that is shut down belongs to this connection.
      const std::lock_guard ending(mutex_);
      ::close(socket);
      connection.is_over = true;
    });
    return true;
  } catch (const std::exception&) {
    connections_.erase(number);
    return false;
  }
}

void Connections::accept_one(int listening_socket) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  const int socket = ::accept4(
      listening_socket, reinterpret_cast<sockaddr*>(&peer), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (socket < 0) {
    // No file is left to open: others will end.
    const bool is_full = errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS;
    if (is_full) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return;
  }
  set_options(socket);
  join_finished();
  const std::string address = network_of(address_text(peer, size));
  if (has_place_for(address) && begin(socket, address)) return;
  ::send(socket, kFull.data(), kFull.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  ::close(socket);
}

void Connections::run(int listening_socket, int stop_fd) {
  while (true) {
    std::array<pollfd, 2> waiting = {{{.fd = listening_socket, .events = POLLIN, .revents = 0},
                                      {.fd = stop_fd, .events = POLLIN, .revents = 0}}};
    if (::poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR) return;
    if (waiting[1].revents != 0) return;
    if (waiting[0].revents != 0) accept_one(listening_socket);
  }
}

}  // namespace panelcal::serve
