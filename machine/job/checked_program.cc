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

/// Allegro's file beside the program states its format before [program] does.
Expected<void> read_format_beside(const std::filesystem::path& folder, ReadOptions& reading) {
  const std::filesystem::path path = folder / excellon::kNcParamName;
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return {};
  const PartialFormat& forced = reading.forced_format;
  if (forced.unit && forced.zeros && forced.digits) return {};
  PANELCAL_TRY(const SourceText source, read_source(path));
  PANELCAL_TRY(reading.format_beside, excellon::read_nc_param(source));
  return {};
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
  if (path != "-") {
    if (auto beside = read_format_beside(folder, reading); !beside) {
      log.add(std::move(beside).error());
      return std::nullopt;
    }
  }
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
