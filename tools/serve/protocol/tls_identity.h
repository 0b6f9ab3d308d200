// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "calib/base/expected.h"

namespace panelcal::serve {

/// A certificate with its key, ready for connections.
class TlsIdentity {
 public:
  virtual ~TlsIdentity() = default;
};

/// Fails  file-unreadable: no PEM file of a certificate or a key, or they do not belong together
Expected<std::shared_ptr<TlsIdentity>> open_tls_identity(const std::filesystem::path& certificate,
                                                         const std::filesystem::path& key);

}  // namespace panelcal::serve
