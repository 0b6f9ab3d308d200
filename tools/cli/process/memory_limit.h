// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace panelcal {

/// The memory that this process may use, as a sentence names it: "512 MiB by ulimit -v", or what
/// the computer has.
std::string memory_limit();

}  // namespace panelcal
