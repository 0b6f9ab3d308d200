// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/expected.h"
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

/// The rest for standard output, and the exit code of what was done.
struct Answer {
  std::string text;
  ExitCode code = ExitCode::Done;
};

// The handlers that the rows of tools/cli/command_table.cc name.
//
// Fails  with the problem that ended the command, which it has not printed
Expected<Answer> run_command(const CheckOptions& options, CommandContext& context);
Expected<Answer> run_command(const SurveyOptions& options, CommandContext& context);
Expected<Answer> run_command(const PlanOptions& options, CommandContext& context);
Expected<Answer> run_command(const RunOptions& options, CommandContext& context);
Expected<Answer> run_command(const TranslateOptions& options, CommandContext& context);
Expected<Answer> run_command(const LocateCommandOptions& options, CommandContext& context);
Expected<Answer> run_command(const SynthOptions& options, CommandContext& context);
Expected<Answer> run_command(const BatchOptions& options, CommandContext& context);
Expected<Answer> run_command(const NightlyOptions& options, CommandContext& context);
Expected<Answer> run_command(const ServeOptions& options, CommandContext& context);
Expected<Answer> run_command(const InitOptions& options, CommandContext& context);
Expected<Answer> run_command(const DoctorOptions& options, CommandContext& context);

namespace align {
Expected<Answer> measure(const AlignOptions& options, CommandContext& context);
Expected<Answer> verify(const AlignOptions& options, CommandContext& context);
Expected<Answer> show(const AlignOptions& options, CommandContext& context);
Expected<Answer> apply(const ApplyOptions& options, CommandContext& context);
Expected<Answer> filter(const ApplyOptions& options, CommandContext& context);
}  // namespace align

namespace batch {
Expected<Answer> merge(const BatchReportOptions& options, CommandContext& context);
Expected<Answer> push(const BatchReportOptions& options, CommandContext& context);
Expected<Answer> report(const BatchReportOptions& options, CommandContext& context);
Expected<Answer> show(const BatchReportOptions& options, CommandContext& context);
}  // namespace batch

namespace calibrate {
Expected<Answer> spindle_camera(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> camera(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> camera_import(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> camera_export(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> table(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> surface(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> focus(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> light(const CalibrateOptions& options, CommandContext& context);
Expected<Answer> settle(const CalibrateOptions& options, CommandContext& context);
}  // namespace calibrate

namespace history {
Expected<Answer> list(const HistoryOptions& options, CommandContext& context);
Expected<Answer> export_entries(const HistoryOptions& options, CommandContext& context);
Expected<Answer> show(const HistoryOptions& options, CommandContext& context);
Expected<Answer> diff(const HistoryOptions& options, CommandContext& context);
Expected<Answer> roll_back(const HistoryOptions& options, CommandContext& context);
Expected<Answer> fresh_start(const HistoryOptions& options, CommandContext& context);
Expected<Answer> plot(const HistoryOptions& options, CommandContext& context);
Expected<Answer> verify(const HistoryOptions& options, CommandContext& context);
Expected<Answer> push(const HistoryOptions& options, CommandContext& context);
Expected<Answer> show_fleet(const HistoryOptions& options, CommandContext& context);
Expected<Answer> certify(const HistoryOptions& options, CommandContext& context);
}  // namespace history

namespace surface {
Expected<Answer> fit(const SurfaceOptions& options, CommandContext& context);
Expected<Answer> query(const SurfaceOptions& options, CommandContext& context);
Expected<Answer> diff(const SurfaceOptions& options, CommandContext& context);
Expected<Answer> plan(const SurfaceOptions& options, CommandContext& context);
Expected<Answer> apply(const SurfaceOptions& options, CommandContext& context);
Expected<Answer> export_map(const SurfaceOptions& options, CommandContext& context);
}  // namespace surface

}  // namespace panelcal
