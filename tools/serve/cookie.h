// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "tools/serve/http/message.h"

namespace panelcal::serve {

/// The name of the session's cookie. It has the port: browsers share cookies among the ports of a
/// host.
inline std::string session_cookie(const Request& request) {
  return "panelcal_" + std::to_string(request.local_port);
}

/// The value of a cookie in the header Cookie; empty if it is not there.
inline std::string_view cookie_of(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const std::size_t end = header.find(';');
    std::string_view pair = header.substr(0, end);
    header = end == header.npos ? std::string_view() : header.substr(end + 1);
    while (pair.starts_with(' ')) pair.remove_prefix(1);
    if (pair.starts_with(name) && pair.substr(name.size()).starts_with('=')) {
      return pair.substr(name.size() + 1);
    }
  }
  return {};
}

}  // namespace panelcal::serve
