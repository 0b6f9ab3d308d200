// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/serve/http/connections.h"
#include "tools/serve/http/message.h"
#include "tools/serve/protocol/connection_limits.h"
#include "tools/serve/protocol/tls_identity.h"

// The part of HTTP and TLS that libraries do. In the program these functions come from a module
// (tools/modules/http_on_demand.cc).
namespace panelcal::serve {

/// Makes sure that the libraries are there, before anything depends on them. Throws ModuleError.
void load_protocol();

/// Serves the requests of one connection, until one side closes it. Blocks; the socket stays open.
///
/// In     socket: connected, non-blocking; shutdown() from another thread ends it soon
///        identity: null: without TLS
void serve_connection(int socket,
                      ConnectionNote& note,
                      TlsIdentity* identity,
                      HttpService& service,
                      const ConnectionLimits& limits);

}  // namespace panelcal::serve
