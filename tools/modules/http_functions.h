// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/serve/protocol/protocol.h"

namespace panelcal::modules {

inline constexpr const char* kHttpModule = "libpanelcal_http.so";

/// HTTP and TLS of `panelcal serve`. cpp-httplib, with OpenSSL, zlib and Brotli.
struct HttpFunctions {
  decltype(&serve::open_tls_identity) open_tls_identity;
  decltype(&serve::serve_connection) serve_connection;
};

}  // namespace panelcal::modules
