// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "machine/calibrate/spindle/calibration.h"
#include "tools/cli/console.h"

namespace panelcal {

/// Asks a person at the terminal one thing, and waits for Enter.
///
/// In     command: as diagnostics name it; expected: what they ask for instead of silence
/// Fails  usage (the input ends without an answer)
Expected<void> ask_operator(const std::string& command,
                            const std::string& expected,
                            Console& console,
                            std::string_view what);

/// The same for whatever is to be asked. `console` outlives it.
///
/// In     command: as diagnostics name it
/// Fails  usage (no person at a terminal); the prompt itself the same, if there is no answer
Expected<Prompt> operator_prompt(const std::string& command, Console& console);

}  // namespace panelcal
