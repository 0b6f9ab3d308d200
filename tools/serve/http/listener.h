// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"

namespace panelcal::serve {

/// A socket that takes connections; closed with the object.
class Listener {
 public:
  /// In     address: "127.0.0.1:8330", "[::1]:8330", "localhost:0"; port 0: any free one
  /// Fails  usage: no address of this form, or none where this computer may listen, with the
  ///        system's text
  static Expected<Listener> open(const std::string& address);

  Listener(Listener&& other) noexcept;
  Listener& operator=(Listener&&) = delete;
  ~Listener();

  int socket() const { return socket_; }
  /// As numbers, as the socket has it: the port is never 0.
  const std::string& host() const { return host_; }
  int port() const { return port_; }
  /// "127.0.0.1:8330", "[::1]:8330"
  std::string text() const;
  /// The same; if it listens on all addresses, those of this computer, loopback last.
  std::vector<std::string> reachable_at() const;

 private:
  Listener() = default;

  int socket_ = -1;
  std::string host_;
  int port_ = 0;
};

}  // namespace panelcal::serve
