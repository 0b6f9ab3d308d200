// SPDX-License-Identifier: Apache-2.0
#include "panelcal/tools/program_input.h"

#include <utility>

namespace panelcal {
namespace {

Expected<SourceText> read_program(const std::string& path) {
  if (path != "-") return read_source(path);
  PANELCAL_TRY(SourceText source, read_source("/dev/stdin"));
  source.file = "<stdin>";
  return source;
}

}  // namespace

std::optional<CheckedProgram> read_and_check(const std::string& path,
                                             const WalkOptions& options,
                                             DiagnosticLog& log) {
  Expected<SourceText> source = read_program(path);
  if (!source) {
    log.add(std::move(source).error());
    return std::nullopt;
  }
  CheckedProgram checked{load_program(*std::move(source), log), {}};
  NominalSource nominal;
  WalkOptions without_limits = options;
  without_limits.base_limits = {};
  without_limits.nested_limits = {};
  checked.nominal_survey = survey(checked.program, without_limits, nominal, log);
  return checked;
}

Tally tally_nominal(const CheckedProgram& checked, const WalkOptions& options, DiagnosticLog& log) {
  Tally tally;
  execute(checked.program, options, checked.nominal_survey, tally, log);
  return tally;
}

}  // namespace panelcal
