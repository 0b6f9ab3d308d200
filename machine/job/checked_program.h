// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "calib/base/diagnostic.h"
#include "program/walk/walk.h"

namespace panelcal {

/// A program that was walked through once on a perfect panel, so that its mistakes are known before
/// anything moves.
struct CheckedProgram {
  Program program;
  Survey nominal_survey;  ///< its measurements at nominal places
};

/// As diagnostics name a program that was read from there.
inline constexpr std::string_view kStandardInput = "<stdin>";

/// Reads PROGRAM (`-` is standard input, which can be read only once) and the stored patterns it
/// names, which are looked for beside it and then where `reading` says; also nc_param.txt beside
/// it. Problems go into the log; absent if the program could not even be read.
std::optional<Program> read_program(const std::string& path,
                                    ReadOptions reading,
                                    DiagnosticLog& log);

/// The survey of a perfect panel, which breaks no limit: gates are left out.
Survey survey_nominal(const Program& program, const WalkOptions& options, DiagnosticLog& log);

/// The two, one after the other.
std::optional<CheckedProgram> read_and_check(const std::string& path,
                                             ReadOptions reading,
                                             const WalkOptions& options,
                                             DiagnosticLog& log);

/// Passes the whole job on the perfect panel to `sink`. Precondition: no errors in the check.
void execute_nominal(const CheckedProgram& checked,
                     const WalkOptions& options,
                     OperationSink& sink,
                     DiagnosticLog& log);

}  // namespace panelcal
