// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "tools/serve/http/listener.h"
#include "tools/serve/protocol/protocol.h"
#include "tools/serve/service.h"

namespace panelcal::serve {

/// Answers requests until `stop_fd` is readable; then ends all streams and connections.
void run_server(const Listener& listener,
                TlsIdentity* identity,
                Service& service,
                Announcer& announcer,
                int stop_fd,
                const ConnectionLimits& limits = {});

}  // namespace panelcal::serve
