// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace panelcal::serve {

struct ConnectionCounts {
  /// A screen has one stream of events and up to a handful of connections beside it.
  std::size_t n_in_total = 160;
  /// One computer cannot take the places of all others. Loopback is exempt from this one.
  std::size_t n_per_address = 40;
};

/// Connections, each with a thread of its own, so that none waits for another one.
class Connections {
 public:
  /// In     serve: answers the requests of a connected, non-blocking socket; called from many
  ///        threads, returns soon after the socket is shut down
  explicit Connections(std::function<void(int)> serve, ConnectionCounts counts = {})
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
    bool is_over = false;
  };

  void accept_one(int listening_socket);
  bool has_place_for(const std::string& address);
  void join_finished();

  std::function<void(int)> serve_;
  ConnectionCounts counts_;
  std::mutex mutex_;
  std::map<std::size_t, Connection> connections_;  ///< by a running number
  std::size_t next_ = 0;
};

}  // namespace panelcal::serve
