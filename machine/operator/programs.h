// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "machine/operator/screen.h"

namespace panelcal::internal {

/// A name that a file of a job may have: letters, digits and `._-`, not beginning with a point, at
/// most 100 characters. So no name leads out of its folder.
///
/// Fails  usage
Expected<void> check_name(const std::string& name);

/// The programs that may be opened: files of the folder with such names, by name. Links are not
/// followed.
std::vector<ScreenProgram> list_programs(const std::filesystem::path& folder);

/// Fails  usage (the name; too large); device-write
Expected<void> store_program(const std::filesystem::path& folder,
                             const std::string& name,
                             std::string_view bytes);

}  // namespace panelcal::internal
