// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/job/job.h"
#include "machine/operator/screen.h"
#include "program/walk/survey.h"

namespace panelcal::internal {

/// A program that was read and checked on a perfect panel.
struct OpenedProgram {
  MachineConfig machine;  ///< without the terms of a walk: correct() sets them
  Job job;
  Survey nominal;  ///< of the check; as far as it came, if that found errors
  std::vector<Diagnostic> findings;
  std::string program_sha256;  ///< of its bytes, without a byte order mark
};

/// Reads machine.toml and a program, and checks the program.
///
/// Fails  what read_machine_config, read_job and set_walk_terms report; findings of the check are
///        no failure
Expected<OpenedProgram> open_program(const std::filesystem::path& machine_file,
                                     const std::filesystem::path& program,
                                     std::chrono::sys_seconds now);

/// The language that a corrected program is written in: its own.
OutputFormat output_format(const Program& program);

/// The job as a screen shows it before anything is measured.
ScreenJob checked_job(const OpenedProgram& opened, std::string id, std::string program);

/// The series as far as they are fitted, and the residuals of their targets.
void show_series(const Survey& survey, ScreenJob& job);

}  // namespace panelcal::internal
