// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

// Not installed.
namespace panelcal::internal {

/// Path of a module: a shared library that is loaded when it is needed.
///
/// Always an absolute path, so that neither the current folder nor LD_LIBRARY_PATH chooses the code
/// that runs. The first that exists of: the program's own folder; the folder of modules as
/// `cmake --install` lays it beside the program's (../lib/panelcal/modules); that folder below the
/// prefix the build was configured with. If none exists: the second, or the third where the program
/// does not know its own folder (no /proc).
///
/// In     file: its name alone
/// See    tests/tools/linkage_test.py
std::string module_path(std::string_view file);

}  // namespace panelcal::internal
