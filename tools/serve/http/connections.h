// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace panelcal::serve {

/// The state of a connection that others may know.
struct ConnectionNote {
  std::atomic<bool> is_trusted = false;          ///< of a person who may look
  std::atomic<bool> is_busy = false;             ///< a request is answered
  std::atomic<std::int64_t> idle_since = now();  ///< of the steady clock

  void begin_request() { is_busy = true; }
  void end_request() {
    idle_since = now();
    is_busy = false;
  }
  static std::int64_t now() { return std::chrono::steady_clock::now().time_since_epoch().count(); }
};

struct ConnectionCounts {
  /// A screen has one stream of events and up to a handful of connections beside it. Where there
  /// are more, the one that has been idle longest makes room, unless a person is known behind it.
  std::size_t n_in_total = 160;
  /// One computer cannot take the places of all others. Loopback is exempt from this one.
  std::size_t n_per_address = 40;
};

/// Connections, each with a thread of its own, so that none waits for another one.
class Connections {
 public:
  /// Answers the requests of a connected, non-blocking socket; called from many threads, returns
  /// soon after the socket is shut down. What it throws ends its connection alone.
  using Serve = std::function<void(int socket, ConnectionNote& note)>;

  explicit Connections(Serve serve, ConnectionCounts counts = {})
      : serve_(std::move(serve)), counts_(counts) {}
  Connections(const Connections&) = delete;
  Connections& operator=(const Connections&) = delete;
  /// Shuts all down, and waits for their threads.
  ~Connections();

  /// Takes connections until `stop_fd` is readable.
  void run(int listening_socket, int stop_fd);

 private:
  struct Connection {
    int socket = -1;
    std::string address;
    std::thread thread;
    ConnectionNote note;
    bool is_over = false;
    bool is_shut = false;  ///< it made room for another one
  };

  void accept_one(int listening_socket);
  bool has_place_for(const std::string& address);
  bool make_room();
  bool begin(int socket, const std::string& address);
  void join_finished();

  Serve serve_;
  ConnectionCounts counts_;
  std::mutex mutex_;
  std::map<std::size_t, Connection> connections_;  ///< by a running number
  std::size_t next_ = 0;
};

}  // namespace panelcal::serve
