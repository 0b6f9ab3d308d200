// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/http/listener.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <system_error>
#include <utility>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace panelcal::serve {
namespace {

union SocketAddress {
  sockaddr any;
  sockaddr_in v4;
  sockaddr_in6 v6;
};

tl::unexpected<Diagnostic> unusable(const std::string& address,
                                    const std::string& why,
                                    const char* expected) {
  return failure({Code::Usage,
                  {"panelcal serve", 0, 0},
                  fmt::format("--address {}{}", quoted(address), why),
                  expected});
}

/// Numbers only: no name server decides where this listens.
Expected<SocketAddress> parse_address(const std::string& text) {
  const std::size_t colon = std::min(text.rfind(':'), text.size());
  std::string host = text.substr(0, colon);
  const std::string port_text = colon < text.size() ? text.substr(colon + 1) : std::string();
  std::uint16_t port = 0;
  const char* const end = port_text.data() + port_text.size();
  const auto read = std::from_chars(port_text.data(), end, port);
  SocketAddress address{};
  bool is_address = false;
  if (host == "localhost") host = "127.0.0.1";
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
    address.v6.sin6_family = AF_INET6;
    address.v6.sin6_port = htons(port);
    is_address = ::inet_pton(AF_INET6, host.c_str(), &address.v6.sin6_addr) == 1;
  } else {
    address.v4.sin_family = AF_INET;
    address.v4.sin_port = htons(port);
    is_address = ::inet_pton(AF_INET, host.c_str(), &address.v4.sin_addr) == 1;
  }
  if (port_text.empty() || read.ec != std::errc() || read.ptr != end || !is_address) {
    return unusable(text, "", "HOST:PORT with an address in numbers, such as 127.0.0.1:8330");
  }
  return address;
}

socklen_t size_of(const SocketAddress& address) {
  return address.any.sa_family == AF_INET6 ? sizeof address.v6 : sizeof address.v4;
}

std::string host_text(const SocketAddress& address) {
  const void* const bytes = address.any.sa_family == AF_INET6
                                ? static_cast<const void*>(&address.v6.sin6_addr)
                                : static_cast<const void*>(&address.v4.sin_addr);
  std::array<char, INET6_ADDRSTRLEN> text{};
  ::inet_ntop(address.any.sa_family, bytes, text.data(), text.size());
  return text.data();
}

std::string host_and_port(const std::string& host, int port) {
  const bool is_v6 = host.find(':') != host.npos;
  return is_v6 ? fmt::format("[{}]:{}", host, port) : fmt::format("{}:{}", host, port);
}

bool begin_listening(int socket, const SocketAddress& address) {
  constexpr int kYes = 1;
  constexpr int kBacklog = 64;
  // A server that has just ended leaves its port for a minute; two never share one.
  ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &kYes, sizeof kYes);
  if (address.any.sa_family == AF_INET6) {
    ::setsockopt(socket, IPPROTO_IPV6, IPV6_V6ONLY, &kYes, sizeof kYes);
  }
  return ::bind(socket, &address.any, size_of(address)) == 0 && ::listen(socket, kBacklog) == 0;
}

}  // namespace

Expected<Listener> Listener::open(const std::string& text) {
  PANELCAL_TRY(SocketAddress address, parse_address(text));
  Listener listener;
  listener.socket_ = ::socket(address.any.sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  socklen_t size = sizeof address;
  if (listener.socket_ < 0 || !begin_listening(listener.socket_, address) ||
      ::getsockname(listener.socket_, &address.any, &size) != 0) {
    const std::string why = ": " + std::generic_category().message(errno);
    return unusable(text, why, "an address of this computer with a free port");
  }
  const bool is_v6 = address.any.sa_family == AF_INET6;
  listener.host_ = host_text(address);
  listener.port_ = ntohs(is_v6 ? address.v6.sin6_port : address.v4.sin_port);
  return listener;
}

Listener::Listener(Listener&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), host_(std::move(other.host_)), port_(other.port_) {
}

Listener::~Listener() {
  if (socket_ >= 0) ::close(socket_);
}

std::string Listener::text() const {
  return host_and_port(host_, port_);
}

std::vector<std::string> Listener::reachable_at() const {
  if (host_ != "0.0.0.0" && host_ != "::") return {text()};
  std::vector<std::string> addresses;
  std::vector<std::string> own;
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) return {text()};
  for (const ifaddrs* at = all; at != nullptr; at = at->ifa_next) {
    const int family = host_ == "::" ? AF_INET6 : AF_INET;
    if (at->ifa_addr == nullptr || at->ifa_addr->sa_family != family) continue;
    SocketAddress address{};
    std::memcpy(&address, at->ifa_addr, family == AF_INET6 ? sizeof address.v6 : sizeof address.v4);
    const bool is_loopback = (at->ifa_flags & IFF_LOOPBACK) != 0;
    (is_loopback ? own : addresses).push_back(host_and_port(host_text(address), port_));
  }
  ::freeifaddrs(all);
  addresses.insert(addresses.end(), own.begin(), own.end());
  return addresses;
}

}  // namespace panelcal::serve
