// SPDX-License-Identifier: Apache-2.0
#include "tests/program/program_run.h"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "tests/support/matchers.h"

namespace panelcal::test {
namespace {

/// Six significant decimals, so that 25.4 is 25.4 however it was worked out.
double rounded(double v) {
  return std::round(v * 1e6) / 1e6 + 0.0;  // a zero has no sign
}

std::string point(const Eigen::Vector2d& p_mm) {
  return fmt::format("({}, {})", rounded(p_mm.x()), rounded(p_mm.y()));
}

std::string depth(const DepthOfCut& cut) {
  std::string text;
  if (cut.z) text += fmt::format(" z {}", rounded(cut.z->in_mm()));
  if (cut.depth) text += fmt::format(" depth {}", rounded(cut.depth->in_mm()));
  if (cut.is_controlled() && !cut.depth) text += " depth by hand";
  if (cut.surface) text += fmt::format(" surface {}", rounded(cut.surface->in_mm()));
  return text;
}

struct TextOf {
  std::string operator()(const ToolChange& change) const {
    std::string text = fmt::format("tool {}", change.tool.number);
    if (change.compensation_index) text += fmt::format(" index {}", *change.compensation_index);
    return text;
  }
  std::string operator()(const Drill& drill) const {
    return fmt::format("drill {} {}{}", drill.tool, point(drill.actual.in_mm()), depth(drill.cut));
  }
  std::string operator()(const RapidMove& move) const {
    return "position " + point(move.actual.in_mm());
  }
  std::string operator()(const Rout& rout) const {
    std::string text =
        fmt::format("rout {} {} {}", rout.tool, name(rout.kind), point(rout.actual.in_mm()));
    if (rout.kind != RoutKind::Line) text += " about " + point(rout.center.in_mm());
    return text + depth(rout.cut);
  }
  std::string operator()(const Plunge& plunge) const {
    std::string text = plunge.kind == PlungeKind::Plain ? "plunge" : "plunge contouring";
    if (plunge.depth_offset) text += fmt::format(" {:.4f}", rounded(plunge.depth_offset->in_mm()));
    return text + depth(plunge.cut);
  }
  std::string operator()(const Retract& retract) const {
    return retract.with_clamping ? "retract clamping" : "retract";
  }
  std::string operator()(const Compensation& compensation) const {
    std::string text = compensation.side == CompensationSide::Off    ? "compensation off"
                       : compensation.side == CompensationSide::Left ? "compensation left"
                                                                     : "compensation right";
    if (compensation.value) text += fmt::format(" {:.4f}", compensation.value->in_mm());
    return text;
  }
  std::string operator()(const Slot& slot) const {
    return fmt::format("slot {} {} {}",
                       slot.tool,
                       point(slot.start.actual.in_mm()),
                       point(slot.end.actual.in_mm()));
  }
  std::string operator()(const StepSlot& slot) const {
    return fmt::format("step_slot {} {} {} {:.4f} {:.4f}",
                       slot.tool,
                       point(slot.start.actual.in_mm()),
                       point(slot.end.actual.in_mm()),
                       slot.initial_depth.in_mm(),
                       slot.increment.in_mm());
  }
  std::string operator()(const Stop& stop) const {
    const std::string kind = stop.kind == StopKind::EndRewind     ? "end rewind"
                             : stop.kind == StopKind::EndNoRewind ? "end"
                                                                  : std::string(name(stop.kind));
    return stop.actual ? kind + " " + point(stop.actual->in_mm()) : kind;
  }
  std::string operator()(const Message& message) const {
    return fmt::format("message {}", message.text);
  }
  std::string operator()(const Dwell& dwell) const {
    return fmt::format("dwell {:g}", dwell.duration.in_s());
  }
  std::string operator()(const Function& function) const {
    std::string text = fmt::format("function {}", name(function.kind));
    if (!function.text.empty()) text += fmt::format(" {}", function.text);
    if (function.kind == FunctionKind::ToolExpired) {
      text += fmt::format(" {}", function.tool);
      if (function.next_tool) text += fmt::format(" next {}", *function.next_tool);
    }
    return text;
  }
  std::string operator()(const ToolRate& rate) const {
    std::string text = fmt::format("rate {}", rate.tool);
    if (rate.infeed) text += fmt::format(" infeed {:g}", rate.infeed->in_mm_s());
    if (rate.retract) text += fmt::format(" retract {:g}", rate.retract->in_mm_s());
    return text;
  }
  std::string operator()(const Autocalibration& calibration) const {
    return "autocalibration " + point(calibration.actual.in_mm());
  }
  std::string operator()(const Setting& setting) const {
    return fmt::format(
        "setting {}{}", setting.text, setting.is_unperformed ? ", not performed" : "");
  }
  std::string operator()(const ZeroSet& zero) const {
    return "work zero " + point(zero.work_zero.in_mm());
  }
  std::string operator()(const PatternBegin&) const { return "pattern"; }
  std::string operator()(const PatternEnd& end) const {
    std::string text = "pattern_end";
    for (const Placement& copy : end.copies) text += " " + point(copy.translation());
    return text;
  }
  std::string operator()(const VisionSeries& series) const {
    std::string text = series.level == CorrectionLevel::Base ? "series" : "nested series";
    for (const auto& target : series.targets) text += " " + point(target.in_mm());
    return text;
  }
  std::string operator()(const TargetHole& hole) const {
    return fmt::format("target hole {} {}", hole.tool, point(hole.nominal.in_mm()));
  }
  std::string operator()(const CancelCorrection& cancel) const {
    return cancel.level == CorrectionLevel::Base ? "cancel" : "cancel nested";
  }
  std::string operator()(const StoredCorrection& stored) const {
    constexpr std::array kKinds = {"record", "rewind", "nest", "keep", "use"};
    return fmt::format("{} {}", kKinds.at(static_cast<std::size_t>(stored.kind)), stored.label);
  }
  std::string operator()(const VisionTool& tool) const {
    return fmt::format("vision tool {}", tool.number);
  }
  std::string operator()(const OpticalOrder& order) const {
    return "order " + std::string(order.text);
  }
  std::string operator()(const SurfaceOrder&) const { return "surface"; }
};

}  // namespace

/// Orders of surface detection are left out: the strokes have what they lead to.
void Recorder::put(const Operation& operation) {
  if (std::holds_alternative<SurfaceOrder>(operation.what)) return;
  std::string line = fmt::format("{} {}", operation.line, std::visit(TextOf{}, operation.what));
  if (!operation.file.empty()) line = fmt::format("{}:{}", operation.file, line);
  if (!operation.path.empty()) line += fmt::format(" [{}]", fmt::join(operation.path, ","));
  lines_.push_back(std::move(line));
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    holes_.push_back({operation.line, {operation.path.begin(), operation.path.end()}, *drill});
  }
  if (const auto* rout = std::get_if<Rout>(&operation.what)) routs_.push_back(*rout);
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

PartialFormat last_set_to_inch() {
  return {.unit = LengthUnit::Inch, .zeros = Zeros::LeadingKept, .digits = {}, .from = {}};
}

ProgramRun run_program(std::string text,
                       const WalkOptions& options,
                       MeasurementSource& source,
                       ReadOptions reading) {
  DiagnosticLog log;
  ProgramRun run;
  // One of inch would be refused in the other language.
  if (reading.last_format.is_empty() && text.find("%%") == std::string::npos) {
    reading.last_format = last_set_to_inch();
  }
  run.program = load_program({"p.exc", std::move(text)}, log, std::move(reading));
  run.survey = survey(run.program, options, source, log);
  run.has_errors = log.has_errors();
  if (!run.has_errors) execute(run.program, options, run.survey, run.executed, log);
  run.has_errors = log.has_errors();
  run.diagnostics = briefs(log);
  for (const Diagnostic& diagnostic : log.kept()) run.texts.push_back(diagnostic.text());
  return run;
}

ProgramRun run_program(std::string text, const WalkOptions& options, ReadOptions reading) {
  NominalSource source;
  return run_program(std::move(text), options, source, std::move(reading));
}

std::string metric(std::string_view body) {
  return "M48\nMETRIC,LZ\nT1C1.0\nT2C2.0\n%\n" + std::string(body);
}

std::string inch_leading_zeros(std::string_view body) {
  return "M48\nINCH,LZ\nT1C.04\nT2C.08\n%\n" + std::string(body);
}

testing::Matcher<const std::string&> says(int line, const std::string& what) {
  return testing::AllOf(testing::StartsWith(fmt::format("p.exc:{}:", line)),
                        testing::HasSubstr(what));
}

std::vector<Eigen::Vector2d> nominal_inch(const ProgramRun& run) {
  std::vector<Eigen::Vector2d> places;
  for (const Hole& hole : run.holes()) places.push_back(hole.nominal_inch());
  return places;
}

}  // namespace panelcal::test
