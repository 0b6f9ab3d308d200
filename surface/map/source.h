// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace panelcal {

/// A file that probes of a map came from.
struct MapSource {
  std::string file;
  std::string sha256;  ///< of its bytes; empty if unknown
};

}  // namespace panelcal
