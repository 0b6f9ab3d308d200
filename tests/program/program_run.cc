// SPDX-License-Identifier: Apache-2.0
#include "tests/program/program_run.h"

#include <utility>

#include <fmt/format.h>

namespace panelcal::test {
namespace {

struct TextOf {
  std::string operator()(const ToolChange& change) const {
    std::string text = fmt::format("tool {}", change.tool.number);
    if (change.compensation_index) text += fmt::format(" index {}", *change.compensation_index);
    return text;
  }
  std::string operator()(const Drill& drill) const {
    return fmt::format(
        "drill {} ({}, {})", drill.tool, drill.actual.in_mm().x(), drill.actual.in_mm().y());
  }
  std::string operator()(const Stop& stop) const {
    std::string text = stop.kind == StopKind::EndRewind ? "end rewind" : "end";
    if (stop.actual) {
      text += fmt::format(" ({}, {})", stop.actual->in_mm().x(), stop.actual->in_mm().y());
    }
    return text;
  }
  std::string operator()(const Message& message) const {
    return fmt::format("message {}", message.text);
  }
  std::string operator()(const Setting& setting) const {
    return fmt::format("setting {}", setting.text);
  }
  std::string operator()(const ZeroSet& zero) const {
    return fmt::format(
        "work zero ({}, {})", zero.work_zero.in_mm().x(), zero.work_zero.in_mm().y());
  }
};

}  // namespace

void Recorder::put(const Operation& operation) {
  std::string line = fmt::format("{} {}", operation.line, std::visit(TextOf{}, operation.what));
  if (!operation.path.empty()) line += fmt::format(" [{}]", fmt::join(operation.path, ","));
  lines_.push_back(std::move(line));
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    holes_.push_back({operation.line, {operation.path.begin(), operation.path.end()}, *drill});
  }
  if (const auto* change = std::get_if<ToolChange>(&operation.what)) {
    tools_.push_back(change->tool);
  }
}

Expected<Measurement> FunctionSource::measure(const MeasurementRequest& request) {
  constexpr double kVariance_mm2 = 1e-6;  // one micrometre squared
  requests_.push_back(request);
  Measurement measurement{.request = request, .status = MeasurementStatus::Found};
  if (const auto loss = losses_.find(request.seq); loss != losses_.end()) {
    measurement.status = loss->second.status;
    measurement.reason = loss->second.reason;
    return measurement;
  }
  measurement.measured = {position_mm<frame::Actual>(place_mm_(request)),
                          kVariance_mm2 * Eigen::Matrix2d::Identity()};
  return measurement;
}

void FunctionSource::lose(std::int64_t seq, MeasurementStatus status, std::string reason) {
  losses_.emplace(seq, Loss{status, std::move(reason)});
}

FunctionSource shifted_by(double x_mm, double y_mm) {
  return FunctionSource([x_mm, y_mm](const MeasurementRequest& request) -> Eigen::Vector2d {
    return request.nominal.in_mm() + Eigen::Vector2d(x_mm, y_mm);
  });
}

ProgramRun run_program(std::string text, const WalkOptions& options, MeasurementSource& source) {
  DiagnosticLog log;
  ProgramRun run;
  run.program = load_program({"p.exc", std::move(text)}, log);
  run.survey = survey(run.program, options, source, log);
  run.has_errors = log.has_errors();
  if (!run.has_errors) execute(run.program, options, run.survey, run.executed, log);
  run.has_errors = log.has_errors();
  for (const Diagnostic& diagnostic : log.kept()) run.diagnostics.push_back(diagnostic.text());
  return run;
}

ProgramRun run_program(std::string text, const WalkOptions& options) {
  NominalSource source;
  return run_program(std::move(text), options, source);
}

std::string metric(std::string_view body) {
  return "M48\nMETRIC,LZ\nT1C1.0\nT2C2.0\n%\n" + std::string(body);
}

std::string inch_leading_zeros(std::string_view body) {
  return "M48\nINCH,LZ\nT1C.04\nT2C.08\n%\n" + std::string(body);
}

std::vector<Eigen::Vector2d> nominal_inch(const ProgramRun& run) {
  std::vector<Eigen::Vector2d> places;
  for (const Hole& hole : run.holes()) places.push_back(hole.nominal_inch());
  return places;
}

}  // namespace panelcal::test
