// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"

namespace panelcal::internal {

/// Runs a program and waits until it ends; returns what it wrote to standard output.
///
/// No shell: words[0] is looked for in PATH unless it has a slash, the others are passed on as they
/// are. Its standard input is empty. Past the limit it is asked to end (SIGTERM), so that it can
/// halt what it moves, and a second later it is ended (SIGKILL). So it is when a signal asks this
/// process to end; where heed_interruptions() was called it has a process group of its own, and the
/// whole group is halted. Else it stays in the caller's, so that Ctrl-C stops both.
///
/// Fails  interrupted; device-stage (cannot be started; ends with another code than 0, with its
///        last words from standard error; does not end in time; more than 64 KiB of output). Both
///        say so where it could not be halted, as a program under sudo, and is left running
/// Note   what a child of the program still writes after the program's end is not waited for
Expected<std::string> run_program(const std::vector<std::string>& words, Time limit);

}  // namespace panelcal::internal
