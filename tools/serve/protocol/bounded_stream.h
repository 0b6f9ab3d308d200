// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "tools/serve/protocol/channel.h"
#include "tools/serve/protocol/connection_limits.h"
#include <httplib.h>

namespace panelcal::serve {

/// A connection, and cpp-httplib's view of it. The library reads no byte of a stranger: it is given
/// a head of ours, and what it writes goes out. Nothing waits beyond its time.
class BoundedStream final : public httplib::Stream {
 public:
  BoundedStream(int socket, Channel& channel, const ConnectionLimits& limits)
      : socket_(socket), channel_(channel), limits_(limits) {}

  /// Waits for the head of the next request, up to and with its empty line. Empty: it is larger
  /// than allowed. Nothing: none came, or not in time.
  std::optional<std::string> read_head();
  /// False: it did not come whole.
  bool read_body(std::string& body, std::size_t n_bytes);
  /// Waits, but not for one who has gone.
  void pause(std::chrono::milliseconds time) const;
  /// The bytes that read() hands out from here on.
  void give(std::string head) { given_ = std::move(head); }
  /// Takes what is still on its way, for a moment: if a socket is closed with bytes unread, the
  /// other side may lose the response.
  void drain();

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
  bool receive(Deadline deadline);

  int socket_;
  Channel& channel_;
  const ConnectionLimits& limits_;
  std::string buffer_;  ///< received and not yet taken
  std::string given_;   ///< to the library
  bool is_usable_ = true;
};

}  // namespace panelcal::serve
