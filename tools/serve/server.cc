// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/server.h"

#include "tools/serve/http/connections.h"

namespace panelcal::serve {

void run_server(const Listener& listener,
                TlsIdentity* identity,
                Service& service,
                Announcer& announcer,
                int stop_fd,
                const ConnectionLimits& limits) {
  Connections connections([&](int socket, ConnectionNote& note) {
    serve_connection(socket, note, identity, service, limits);
  });
  connections.run(listener.socket(), stop_fd);
  announcer.end();
}

}  // namespace panelcal::serve
