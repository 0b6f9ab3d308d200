// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "machine/files/file_register.h"
#include "tools/cli/console.h"
#include "tools/cli/options/options.h"
#include "tools/cli/process/exit_code.h"

namespace panelcal {

/// The input of every command besides its own options.
struct CommandContext {
  Console& console;
  StandardOutput& output;
  const Options& options;
  FileRegister& files;  ///< files in use, which no output may replace; commands add to them
};

ExitCode run_command(const CheckOptions& options, CommandContext& context);
ExitCode run_command(const SurveyOptions& options, CommandContext& context);
ExitCode run_command(const PlanOptions& options, CommandContext& context);
ExitCode run_command(const RunOptions& options, CommandContext& context);
ExitCode run_command(const TranslateOptions& options, CommandContext& context);
ExitCode run_command(const LocateCommandOptions& options, CommandContext& context);
ExitCode run_command(const SynthOptions& options, CommandContext& context);
ExitCode run_command(const CalibrateOptions& options, CommandContext& context);
ExitCode run_command(const NightlyOptions& options, CommandContext& context);
ExitCode run_command(const HistoryOptions& options, CommandContext& context);
ExitCode run_command(const SurfaceOptions& options, CommandContext& context);

}  // namespace panelcal
