// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace panelcal::serve {

/// The end at which a request arrived.
struct Arrival {
  std::string local_address;
  int local_port = 0;
  bool is_encrypted = false;
};

/// True if a request's header Host names this server: by the very address at which it arrived,
/// `localhost` on loopback, or one of the names that the command line lists. Any other name may be
/// one of a stranger whose DNS points here, so that a stranger's page would be of the same origin.
///
/// In     names: in small letters, without a port; behind a proxy any port is theirs
bool is_own_host(std::string_view host, const Arrival& arrival, std::span<const std::string> names);

/// True if the header Origin is that of the pages which this server sends under `host`.
bool is_own_origin(std::string_view origin,
                   std::string_view host,
                   const Arrival& arrival,
                   std::span<const std::string> names);

/// True of 127.0.0.0/8 and ::1, also as IPv6 writes an address of IPv4.
bool is_loopback(const std::string& address);

}  // namespace panelcal::serve
