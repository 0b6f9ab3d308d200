// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "calib/base/expected.h"

namespace panelcal::internal {

/// Reads a file of a folder, as far as both are what they seem: no link leads elsewhere, and no
/// pipe or device keeps the reader waiting.
///
/// In     name: without folders
/// Fails  file-unreadable
Expected<std::string> read_regular(const std::filesystem::path& folder,
                                   const std::string& name,
                                   std::size_t max_bytes);

}  // namespace panelcal::internal
