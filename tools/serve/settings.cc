// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/settings.h"

#include <algorithm>

#include "tools/serve/access/origin.h"
#include <fmt/format.h>

namespace panelcal::serve {
namespace {

tl::unexpected<Diagnostic> unsafe(std::string what, const char* expected) {
  return failure({Code::Usage, {"panelcal serve", 0, 0}, std::move(what), expected});
}

bool is_host_name(const std::string& name) {
  return !name.empty() && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.';
  });
}

}  // namespace

Expected<void> check_access(const AccessSettings& settings, const Listener& listener) {
  if (settings.certificate.empty() != settings.key.empty()) {
    return unsafe("--certificate and --key belong together", "both of them, or neither");
  }
  for (const std::string& name : settings.host_names) {
    if (is_host_name(name)) continue;
    return unsafe(fmt::format("--host-name {}", quoted(name)),
                  "a name in small letters without a port, such as drill.example.org");
  }
  if (is_loopback(listener.host())) return {};
  if (settings.token_file.empty()) {
    return unsafe(fmt::format("other computers reach \"{}\" without a token", listener.text()),
                  "--token-file FILE, or an address of loopback such as 127.0.0.1:8330");
  }
  if (settings.certificate.empty() && !settings.allows_plain_http) {
    return unsafe(
        fmt::format("the token would pass the network readable on its way to \"{}\"",
                    listener.text()),
        "--certificate PEM --key PEM, or --plain-http where the network itself is trusted");
  }
  return {};
}

}  // namespace panelcal::serve
