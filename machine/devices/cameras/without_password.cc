// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/without_password.h"

namespace panelcal {

std::string without_password(std::string_view uri) {
  constexpr std::string_view kNetwork = "rtsp://";
  if (!uri.starts_with(kNetwork)) return std::string(uri);
  const std::string_view host = uri.substr(kNetwork.size());
  // A password may hold an @ itself.
  const auto at = host.substr(0, host.find('/')).rfind('@');
  if (at == host.npos) return std::string(uri);
  return std::string(kNetwork) + std::string(host.substr(at + 1));
}

}  // namespace panelcal
