// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace panelcal {

/// A script by which bash completes commands, options, their words and the names of files.
///
/// In     app: the whole command line; each command and option of it is in the script
/// See    tests/tools/completion_test.sh
std::string bash_completion(const CLI::App& app);

}  // namespace panelcal
