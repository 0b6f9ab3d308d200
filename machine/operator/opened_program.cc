// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/opened_program.h"

#include <algorithm>
#include <utility>

#include "calib/base/files/digest.h"
#include "machine/job/checked_program.h"
#include "machine/job/facts/survey_facts.h"
#include "machine/job/walk_terms.h"
#include "machine/operator/command.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

ScreenTarget waiting_target(const MeasurementRequest& request) {
  ScreenTarget target;
  target.seq = request.seq;
  target.line = request.line;
  target.command = request.command;
  target.tool = request.settings.tools.empty() ? 0 : request.settings.tools.front();
  target.path = request.path;
  target.nominal_mm = request.nominal.in_mm();
  target.expected_mm = request.expected.in_mm();
  return target;
}

std::string series_words(const SeriesResult& series) {
  if (series.is_left_out) return "board left out";
  if (!series.is_fitted()) return "no fit";
  return fmt::format("{}, {}", series.model_text(), series.is_accepted() ? "accepted" : "refused");
}

}  // namespace

Expected<OpenedProgram> open_program(const std::filesystem::path& machine_file,
                                     const std::filesystem::path& program,
                                     std::chrono::sys_seconds now) {
  OpenedProgram out;
  PANELCAL_TRY(out.machine, read_machine_config(machine_file));
  MachineConfig machine = out.machine;
  const WalkTerms terms = {.program = program.string(), .now = now, .command = "panelcal serve"};
  PANELCAL_CHECK(set_walk_terms(terms, machine));
  PANELCAL_TRY(out.job, read_job(program.string(), machine, now));
  out.job.command = "panelcal serve";
  out.program_sha256 = sha256(out.job.program.source.bytes);
  DiagnosticLog log = out.job.reading;
  out.nominal = survey_nominal(out.job.program, machine.walk, log);
  out.findings.assign(log.kept().begin(), log.kept().end());
  return out;
}

OutputFormat output_format(const Program& program) {
  return program.dialect == Dialect::Excellon ? OutputFormat::Excellon : OutputFormat::SiebMeyer;
}

ScreenJob checked_job(const OpenedProgram& opened, std::string id, std::string program) {
  ScreenJob job;
  job.id = std::move(id);
  job.program = std::move(program);
  job.findings = opened.findings;
  job.program_sha256 = opened.program_sha256;
  job.output_format = name(output_format(opened.job.program));
  for (const Measurement& nominal : opened.nominal.measurements) {
    job.targets.push_back(waiting_target(nominal.request));
  }
  for (const SeriesResult& series : opened.nominal.series) {
    job.series.push_back(
        {series.line, series.path, series.measurements.size(), false, false, std::string()});
  }
  return job;
}

void show_series(const Survey& survey, ScreenJob& job) {
  job.series.resize(std::max(job.series.size(), survey.series.size()));
  for (std::size_t i = 0; i < survey.series.size(); ++i) {
    const SeriesResult& series = survey.series[i];
    job.series[i] = {series.line,
                     series.path,
                     series.measurements.size(),
                     series.is_fitted(),
                     series.is_accepted(),
                     series_words(series)};
  }
  for (const facts::TargetFact& fact : facts::target_facts(survey)) {
    const auto i = static_cast<std::size_t>(fact.measurement->request.seq);
    if (i >= job.targets.size() || !fact.residual_mm) continue;
    job.targets[i].residual_um = 1e3 * *fact.residual_mm;
  }
}

}  // namespace panelcal::internal
