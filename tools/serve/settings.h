// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "tools/serve/http/listener.h"

namespace panelcal::serve {

/// The options of the command line about access.
struct AccessSettings {
  std::string token_file;   ///< empty: no token is asked for
  std::string certificate;  ///< PEM; empty: without TLS
  std::string key;          ///< PEM
  bool allows_plain_http = false;
  std::vector<std::string> host_names;
};

/// Refuses what is not safe on the address on which the server listens: another one than loopback
/// needs a token, and TLS for the token's sake unless plain HTTP is asked for.
///
/// Fails  usage, naming the option that helps
Expected<void> check_access(const AccessSettings& settings, const Listener& listener);

}  // namespace panelcal::serve
