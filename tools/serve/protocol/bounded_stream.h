// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <utility>

#include "tools/serve/protocol/channel.h"
#include "tools/serve/protocol/connection_limits.h"
#include <httplib.h>

namespace panelcal::serve {

/// cpp-httplib's view of a connection. It hands out no more bytes than the request may have, so
/// that neither an endless line nor endless headers fill the memory, and waits for none beyond its
/// time.
class BoundedStream final : public httplib::Stream {
 public:
  BoundedStream(int socket, Channel& channel, const ConnectionLimits& limits)
      : socket_(socket), channel_(channel), limits_(limits) {}

  /// Waits for the next request; false: none came.
  bool begin_request();
  /// False: it did not come whole.
  bool read_body(std::string& body, std::size_t n_bytes);
  /// Takes what is still on its way, for a moment: if a socket is closed with bytes unread, the
  /// other side may lose the response.
  void drain();

  /// True if the request had more bytes than it may have.
  bool is_over_limit() const { return is_over_; }
  /// False once the other side has closed; that is noticed without sending.
  bool is_open() const;

  bool is_readable() const override { return is_usable_; }
  bool is_writable() const override { return is_usable_; }
  ssize_t read(char* bytes, size_t size) override;
  ssize_t write(const char* bytes, size_t size) override;
  void get_remote_ip_and_port(std::string& address, int& port) const override;
  void get_local_ip_and_port(std::string& address, int& port) const override;
  int socket() const override { return socket_; }

 private:
  std::chrono::milliseconds time_for(std::size_t n_bytes) const;
  bool fill(Deadline deadline);

  int socket_;
  Channel& channel_;
  const ConnectionLimits& limits_;
  std::string buffer_;
  std::size_t at_ = 0;
  std::size_t n_left_ = 0;
  Deadline deadline_;
  bool is_over_ = false;
  bool is_usable_ = true;
};

}  // namespace panelcal::serve
