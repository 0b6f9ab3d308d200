// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "tools/serve/http/message.h"

namespace panelcal::serve {

/// Request line and headers of a request.
struct Head {
  Request request;  ///< without body and addresses
  bool is_http_1_0 = false;
  bool closes = false;  ///< the other side wants no further request
};

/// Reads the head of a request, as strictly as RFC 9112 allows: what two programs could read in two
/// ways is refused, since a proxy may stand before this one. Values stay as they were sent.
///
/// In     text: up to and with the empty line
/// Out    nothing: a line without CRLF, a name that is no token or has a blank behind it, a
///        continued line, a control character, a version other than HTTP/1.0 and HTTP/1.1
/// Source RFC 9112, sections 2 to 5
/// See    tests/tools/serve/http/head_test.cc
std::optional<Head> parse_head(std::string_view text);

}  // namespace panelcal::serve
