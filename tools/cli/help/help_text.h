// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace panelcal {

inline constexpr std::string_view kMainHeader =
    "panelcal - makes a drilling machine hit the panel on the table, not the panel in the drawing";

inline constexpr std::string_view kMainFooter =
    R"(Exit codes: 0 done; 1 a gate or check failed, nothing was written for the machine;
2 bad input or usage; 3 a device or the environment failed.
No output replaces a file that the command reads or that machine.toml names.
`panelcal help COMMAND` explains a command with an example.)";

/// Of every command that reads a part program.
inline constexpr const char* kAcceptUnterminatedHelp =
    "Accept an Excellon program that stops behind a complete line, without M30 or M00";

}  // namespace panelcal
