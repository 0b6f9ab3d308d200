// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string_view>

#include "tools/serve/protocol/tls_identity.h"
#include <sys/types.h>

namespace panelcal::serve {

using Deadline = std::chrono::steady_clock::time_point;

/// Bytes to and from a connected, non-blocking socket, plain or by TLS, never waiting beyond a
/// deadline.
class Channel {
 public:
  virtual ~Channel() = default;
  /// Waits for at least one byte. 0: closed, failed, or too late.
  virtual std::size_t read_some(char* bytes, std::size_t n, Deadline deadline) = 0;
  /// False: closed, failed, or too late; the connection is of no use then.
  virtual bool write_all(std::string_view bytes, Deadline deadline) = 0;
};

/// Null: the handshake of TLS failed or was too slow.
std::unique_ptr<Channel> open_channel(int socket, TlsIdentity* identity, Deadline deadline);

/// Waits for an event of poll(); false: too late, or the socket is closed.
bool wait_for(int socket, short events, Deadline deadline);

}  // namespace panelcal::serve
