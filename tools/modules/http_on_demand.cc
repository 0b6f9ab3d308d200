// SPDX-License-Identifier: Apache-2.0
// The functions of HTTP and TLS, by way of their module (see module.h).
#include "tools/modules/http_functions.h"
#include "tools/modules/module.h"

namespace panelcal::serve {
namespace {

const modules::HttpFunctions& http_functions() {
  static const auto& functions = modules::load<modules::HttpFunctions>(modules::kHttpModule);
  return functions;
}

}  // namespace

Expected<std::shared_ptr<TlsIdentity>> open_tls_identity(const std::filesystem::path& certificate,
                                                         const std::filesystem::path& key) {
  return http_functions().open_tls_identity(certificate, key);
}

void load_protocol() {
  http_functions();
}

void serve_connection(int socket,
                      ConnectionNote& note,
                      TlsIdentity* identity,
                      HttpService& service,
                      const ConnectionLimits& limits) {
  http_functions().serve_connection(socket, note, identity, service, limits);
}

}  // namespace panelcal::serve
