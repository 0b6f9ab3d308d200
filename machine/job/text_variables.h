// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "program/walk/control_settings.h"
#include "program/walk/walk.h"

namespace panelcal {

/// The time on the wall that `--clock` names: `2026-11-21T13:45:00`. An empty text is `now` where
/// this computer stands.
///
/// In     command: as diagnostics name who asks
/// Fails  usage
Expected<std::string> wall_time(std::string_view clock,
                                std::chrono::sys_seconds now,
                                const std::string& command = "panelcal");

/// Sets what texts of a SIEB & MEYER program say of the day and of the program's name: &D, &T, &F
/// and &E.
///
/// In     path: as on the command line; standard input (`-`) has no name
///        time: from wall_time()
void set_text_variables(std::string_view path,
                        std::string_view time,
                        sieb_meyer::TextVariables& text);

/// The program or a subprogram of its drills the date or the time, so that its output depends on
/// when it was made.
bool drills_the_time(const Program& program);

}  // namespace panelcal
