// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/access/origin.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include <arpa/inet.h>

namespace panelcal::serve {
namespace {

/// All addresses as those of IPv6, of which some are those of IPv4.
using Bytes = std::array<unsigned char, 16>;
constexpr std::array<unsigned char, 12> kMapped = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};

std::optional<Bytes> address_of(const std::string& text) {
  Bytes bytes{};
  const std::string bare = text.substr(0, text.find('%'));
  if (::inet_pton(AF_INET6, bare.c_str(), bytes.data()) == 1) return bytes;
  std::ranges::copy(kMapped, bytes.begin());
  if (::inet_pton(AF_INET, bare.c_str(), bytes.data() + kMapped.size()) == 1) return bytes;
  return std::nullopt;
}

struct HostAndPort {
  std::string host;  ///< in small letters, without brackets
  int port = 0;
};

std::optional<HostAndPort> parse_host(std::string_view text, bool is_encrypted) {
  HostAndPort parsed{{}, is_encrypted ? 443 : 80};
  std::string_view port;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == text.npos) return std::nullopt;
    parsed.host = text.substr(1, end - 1);
    port = text.substr(end + 1);
  } else {
    const std::size_t colon = std::min(text.find(':'), text.size());
    parsed.host = text.substr(0, colon);
    port = text.substr(colon);
  }
  if (!port.empty()) {
    const char* const end = port.data() + port.size();
    const auto read = std::from_chars(port.data() + 1, end, parsed.port);
    if (port.front() != ':' || read.ec != std::errc() || read.ptr != end) return std::nullopt;
  }
  for (char& c : parsed.host) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  if (parsed.host.empty()) return std::nullopt;
  return parsed;
}

bool is_listed(std::string_view host, std::span<const std::string> names) {
  return std::ranges::find(names, host) != names.end();
}

}  // namespace

bool is_loopback(const std::string& address) {
  const std::optional<Bytes> bytes = address_of(address);
  if (!bytes) return false;
  if (std::equal(kMapped.begin(), kMapped.end(), bytes->begin())) return (*bytes)[12] == 127;
  Bytes one{};
  one.back() = 1;
  return *bytes == one;
}

bool is_own_host(std::string_view host,
                 const Arrival& arrival,
                 std::span<const std::string> names) {
  const std::optional<HostAndPort> parsed = parse_host(host, arrival.is_encrypted);
  if (!parsed) return false;
  if (is_listed(parsed->host, names)) return true;
  if (parsed->port != arrival.local_port) return false;
  if (parsed->host == "localhost") return is_loopback(arrival.local_address);
  const std::optional<Bytes> address = address_of(parsed->host);
  return address && address == address_of(arrival.local_address);
}

bool is_own_origin(std::string_view origin,
                   std::string_view host,
                   const Arrival& arrival,
                   std::span<const std::string> names) {
  constexpr std::string_view kPlain = "http://";
  constexpr std::string_view kEncrypted = "https://";
  const bool is_encrypted = origin.starts_with(kEncrypted);
  if (!is_encrypted && !origin.starts_with(kPlain)) return false;
  const auto own = parse_host(host, arrival.is_encrypted);
  // A proxy that ends TLS tells no port of its own where it is the usual one.
  const bool is_proxy = own && is_listed(own->host, names) && is_encrypted;
  if (!own || (is_encrypted != arrival.is_encrypted && !is_proxy)) return false;
  const std::string_view rest = origin.substr((is_encrypted ? kEncrypted : kPlain).size());
  const auto theirs = parse_host(rest, is_encrypted);
  const auto seen = parse_host(host, is_encrypted);
  return theirs && seen && theirs->host == seen->host && theirs->port == seen->port;
}

}  // namespace panelcal::serve
