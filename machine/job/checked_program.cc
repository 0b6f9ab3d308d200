// SPDX-License-Identifier: Apache-2.0
#include "machine/job/checked_program.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "program/excellon/text/nc_param.h"

namespace panelcal {
namespace {

Expected<SourceText> read_text(const std::string& path) {
  if (path != "-") return read_source(path);
  PANELCAL_TRY(SourceText source, read_source("/dev/stdin"));
  source.file = kStandardInput;
  return source;
}

/// Allegro's file. A program that does not need it is read whatever is wrong with it.
FormatBeside read_format_beside(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / excellon::kNcParamName;
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return {};
  Expected<FormatBeside> beside = read_source(path).and_then(excellon::read_nc_param);
  if (beside) return *std::move(beside);
  FormatBeside unreadable;
  unreadable.file = path.string();
  unreadable.fault = std::move(beside).error();
  return unreadable;
}

}  // namespace

std::optional<Program> read_program(const std::string& path,
                                    ReadOptions reading,
                                    DiagnosticLog& log) {
  Expected<SourceText> source = read_text(path);
  if (!source) {
    log.add(std::move(source).error());
    return std::nullopt;
  }
  const std::filesystem::path folder =
      path == "-" ? std::filesystem::path() : std::filesystem::path(path).parent_path();
  reading.pattern_folders.insert(reading.pattern_folders.begin(), folder);
  if (path != "-") reading.format_beside = read_format_beside(folder);
  return load_program(*std::move(source), log, std::move(reading));
}

Survey survey_nominal(const Program& program, const WalkOptions& options, DiagnosticLog& log) {
  return check(program, options, log).survey;
}

std::optional<CheckedProgram> read_and_check(const std::string& path,
                                             ReadOptions reading,
                                             const WalkOptions& options,
                                             DiagnosticLog& log) {
  std::optional<Program> program = read_program(path, std::move(reading), log);
  if (!program) return std::nullopt;
  Survey nominal_survey = survey_nominal(*program, options, log);
  return CheckedProgram{*std::move(program), std::move(nominal_survey)};
}

void execute_nominal(const CheckedProgram& checked,
                     const WalkOptions& options,
                     OperationSink& sink,
                     DiagnosticLog& log) {
  execute(checked.program, options, checked.nominal_survey, sink, log);
}

}  // namespace panelcal
