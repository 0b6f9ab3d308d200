// SPDX-License-Identifier: Apache-2.0
#include "machine/align/measure.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/base/statistics/chi_square.h"
#include "machine/job/alignment_check.h"
#include "machine/job/spindle_age.h"
#include "machine/sources/measurement_file_source.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// A panel that lies still fails a check so often.
constexpr double kCheckFalseAlarm = 1e-3;
/// Fits of the same numbers on different computers differ by less.
constexpr double kSameFit_mm = 1e-6;
constexpr double kSameSigma = 1e-6;

/// A request as the pads' own file would have made it.
MeasurementRequest request_of(const std::vector<Pad>& pads, MeasurementRequest request) {
  const Pad& pad = pads[static_cast<std::size_t>(request.seq)];
  request.line = pad.line;
  request.command = pad.command;
  return request;
}

/// Asks for pads by the lines of their file.
class PadSource final : public MeasurementSource {
 public:
  PadSource(std::shared_ptr<MeasurementSource> source, const std::vector<Pad>& pads)
      : source_(std::move(source)), pads_(pads) {}

  void foresee(RequestForecast forecast) override {
    source_->foresee([this, forecast = std::move(forecast)] {
      std::vector<MeasurementRequest> requests = forecast();
      for (MeasurementRequest& request : requests) {
        request = request_of(pads_, std::move(request));
      }
      return requests;
    });
  }
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    return source_->measure(request_of(pads_, request));
  }
  Expected<void> finish() override { return source_->finish(); }

 private:
  std::shared_ptr<MeasurementSource> source_;
  const std::vector<Pad>& pads_;
};

/// The lines of the generated program, and those of the pads that they measure.
std::map<int, int> pad_lines(const std::string& program, const std::vector<Pad>& pads) {
  std::map<int, int> lines;
  std::size_t i_pad = 0;
  int number = 0;
  for (std::size_t at = 0; at < program.size(); at = program.find('\n', at) + 1) {
    ++number;
    if (program.compare(at, 3, "G36") == 0) lines[number] = pads[i_pad++].line;
  }
  return lines;
}

/// Lines of the generated program become those of the pads' file; what PadSource has asked for has
/// them already.
DiagnosticLog at_pads(const DiagnosticLog& log,
                      const std::string& file,
                      const std::map<int, int>& lines) {
  DiagnosticLog out;
  for (Diagnostic diagnostic : log.kept()) {
    const int line = diagnostic.place.line;
    const bool is_of_pad =
        std::ranges::any_of(lines, [&](const auto& row) { return row.second == line; });
    if (diagnostic.place.file == file && !is_of_pad) {
      const auto generated = lines.find(line);
      diagnostic.place.line = generated == lines.end() ? 0 : generated->second;
      diagnostic.place.column = 0;
    }
    out.add(std::move(diagnostic));
  }
  return out;
}

/// Nothing but the series counts: no hole is drilled.
void leave_only_the_series(std::size_t n_pads, WalkOptions& walk) {
  walk.series_size = static_cast<int>(n_pads);
  walk.tolerances = {};
  walk.board = {};
  walk.scaling.reset();
  walk.aligned.reset();
}

Diagnostic gate_failure(const Alignment& alignment, std::string what, std::string expected) {
  return {Code::GateFailed, {alignment.file, 0, 0}, std::move(what), std::move(expected)};
}

std::string remedy_of_input(const AlignmentInput& input) {
  return input.what + " with the content that it had then, or `panelcal align` again";
}

/// The machine has what the alignment was measured with.
Expected<void> check_inputs(const Alignment& alignment, const MachineConfig& machine) {
  PANELCAL_TRY(const std::vector<AlignmentInput> now, alignment_inputs(machine));
  const auto refuse = [&](const AlignmentInput& input, std::string_view how) {
    return failure(
        {Code::Usage,
         {alignment.file, 0, 0},
         fmt::format("the alignment was measured {} {} {}", how, input.what, quoted(input.name)),
         remedy_of_input(input)});
  };
  const auto same_kind = [](const AlignmentInput& input) {
    return [&input](const AlignmentInput& other) { return other.what == input.what; };
  };
  for (const AlignmentInput& then : alignment.inputs) {
    const auto found = std::ranges::find_if(now, same_kind(then));
    if (found == now.end() || found->sha256 != then.sha256) return refuse(then, "with another");
  }
  for (const AlignmentInput& input : now) {
    if (std::ranges::none_of(alignment.inputs, same_kind(input)))
      return refuse(input, "without the");
  }
  return {};
}

PadList pads_of(const Alignment& alignment) {
  PadList list{alignment.file, {}, {}};
  for (std::size_t i = 0; i < alignment.measurements.size(); ++i) {
    const MeasurementRequest& request = alignment.measurements[i].request;
    list.pads.push_back({.nominal = request.nominal,
                         .line = request.line,
                         .name = alignment.names[i],
                         .command = request.command,
                         .settings = request.settings});
  }
  return list;
}

/// The stored fit carries the pads where the new one does, and is as sure of it.
bool is_fit_of(const AlignmentFit& stored, const Survey& survey) {
  const SeriesResult& series = survey.series.front();
  if (series.model_text() != stored.model) return false;
  for (const Measurement& pad : survey.measurements) {
    const Eigen::Vector2d nominal_mm = pad.request.nominal.in_mm();
    const Eigen::Vector2d apart_mm = (series.linear - stored.linear) * nominal_mm +
                                     series.translation_mm - stored.translation_mm;
    if (!(apart_mm.norm() <= kSameFit_mm)) return false;
  }
  const double size = series.cov.norm();
  return (series.cov - stored.cov).norm() <= kSameSigma * size;
}

Expected<void> check_held(const Alignment& alignment) {
  if (!alignment.held.empty()) {
    return failure(gate_failure(alignment,
                                "the alignment is held: " + alignment.held,
                                "`panelcal align` again, with a panel that keeps the limits"));
  }
  if (!alignment.checks.empty() && !alignment.checks.back().is_accepted) {
    const AlignmentCheck& last = alignment.checks.back();
    return failure(gate_failure(
        alignment,
        fmt::format("{} when {} looked again at {}",
                    last.has_seen_all()
                        ? "the panel had moved"
                        : fmt::format("pad {} was not found", last.pads[last.seen.size()]),
                    last.by,
                    iso_8601(last.time)),
        "`panelcal align` again"));
  }
  if (alignment.fit) return {};
  return failure(gate_failure(
      alignment, "a pad was not found", "`panelcal align` again, with pads that are to be seen"));
}

Diagnostic not_found(std::size_t number,
                     const Eigen::Vector2d& nominal_mm,
                     const Measurement& now) {
  return {now.status == MeasurementStatus::NotFound    ? Code::TargetNotFound
          : now.status == MeasurementStatus::Ambiguous ? Code::TargetAmbiguous
                                                       : Code::TargetRejected,
          {},
          fmt::format("pad {} at nominal ({:.4f}, {:.4f}) mm{}{}",
                      number,
                      nominal_mm.x(),
                      nominal_mm.y(),
                      now.reason.empty() ? "" : ": ",
                      now.reason),
          ""};
}

}  // namespace

Expected<JobResult> measure_pads(const PadList& list,
                                 const OpenJobSources& open,
                                 MachineConfig machine,
                                 std::chrono::sys_seconds now,
                                 const JobSinks& sinks) {
  leave_only_the_series(list.pads.size(), machine.walk);
  Job job;
  const std::string text = pad_program(list.pads);
  job.program = load_program({list.file, text}, job.reading);
  job.now = now;
  job.compares_models = true;
  const OpenJobSources open_at_pads = [&](const Survey& nominal) -> Expected<JobSources> {
    Survey asked = nominal;
    for (Measurement& pad : asked.measurements) {
      pad.request = request_of(list.pads, std::move(pad.request));
    }
    PANELCAL_TRY(JobSources sources, open(asked));
    sources.targets = std::make_shared<PadSource>(std::move(sources.targets), list.pads);
    return sources;
  };
  Expected<JobResult> result = correct(job, open_at_pads, machine, sinks);
  const std::map<int, int> lines = pad_lines(text, list.pads);
  if (sinks.log != nullptr) *sinks.log = at_pads(*sinks.log, list.file, lines);
  if (!result) return result;
  result->log = at_pads(result->log, list.file, lines);
  auto survey = std::make_shared<Survey>(*result->survey);
  for (SeriesResult& series : survey->series) {
    if (const auto line = lines.find(series.line); line != lines.end()) series.line = line->second;
  }
  result->survey = std::move(survey);
  return result;
}

Expected<std::vector<AlignmentInput>> alignment_inputs(const MachineConfig& machine) {
  std::vector<AlignmentInput> inputs;
  const auto add = [&](std::string what, const std::filesystem::path& file) -> Expected<void> {
    if (file.empty()) return {};
    PANELCAL_TRY(const std::string bytes, read_file(file));
    inputs.push_back({std::move(what), file.filename().string(), sha256(bytes)});
    return {};
  };
  PANELCAL_CHECK(add("machine file", machine.file));
  PANELCAL_CHECK(add("camera calibration", machine.camera_file));
  for (const auto& [level, file] : machine.zoom_files) {
    PANELCAL_CHECK(add(fmt::format("calibration of zoom {:g}", level), file));
  }
  std::error_code error;
  const bool has_spindle = std::filesystem::exists(machine.spindle_setting.file, error);
  if (has_spindle) PANELCAL_CHECK(add("spindle calibration", machine.spindle_setting.file));
  PANELCAL_CHECK(add("table calibration", machine.table_file));
  return inputs;
}

void put_result(const JobResult& result, Alignment& alignment) {
  alignment.measurements = result.survey->measurements;
  alignment.fit.reset();
  alignment.gates.clear();
  alignment.held = result.may_be_drilled() ? "" : result.refusal().message();
  if (result.survey->series.empty() || !result.survey->series.front().is_fitted()) return;
  const SeriesResult& series = result.survey->series.front();
  alignment.fit = {.model = series.model_text(),
                   .linear = series.linear,
                   .translation_mm = series.translation_mm,
                   .cov = series.cov,
                   .chi_square = series.chi_square,
                   .degrees_of_freedom = series.degrees_of_freedom};
  for (const GateVerdict& gate : series.gates) {
    alignment.gates.push_back(
        {std::string(gate.gate), gate.value, gate.limit, std::string(gate.unit), gate.accepted});
  }
}

AlignedPanel::AlignedPanel(std::shared_ptr<const Survey> survey, const MachineUncertainty& machine)
    : survey_(std::move(survey)), stack_(machine) {
  stack_.set_base(survey_->series.front().base);
}

Expected<AlignedPanel> restore_panel(const Alignment& alignment,
                                     const MachineConfig& machine,
                                     std::chrono::sys_seconds now) {
  PANELCAL_CHECK(check_inputs(alignment, machine));
  PANELCAL_CHECK(check_held(alignment));
  const OpenJobSources open = [&](const Survey&) -> Expected<JobSources> {
    RecordedMeasurements recorded{alignment.file, {}};
    for (const Measurement& measurement : alignment.measurements) {
      recorded.measurements.push_back({measurement, 0});
    }
    return JobSources{std::make_shared<MeasurementFileSource>(std::move(recorded)),
                      std::make_shared<NominalProbeSource>(),
                      alignment.source};
  };
  PANELCAL_TRY(const JobResult result, measure_pads(pads_of(alignment), open, machine, now));
  if (!result.may_be_drilled()) return failure(result.refusal());
  if (!is_fit_of(*alignment.fit, *result.survey)) {
    return failure({Code::CalibrationInvalid,
                    {alignment.file, 0, 0},
                    "the fit is not that of the measurements",
                    "the file as `panelcal align` has written it"});
  }
  // Reports name where the targets stand.
  auto survey = std::make_shared<Survey>(*result.survey);
  const std::string name = std::filesystem::path(alignment.file).filename().string();
  for (Measurement& pad : survey->measurements) pad.request.file = name;
  MachineConfig aged = machine;
  PANELCAL_CHECK(age_offset(aged, now));
  return AlignedPanel(std::move(survey), aged.walk.uncertainty);
}

Expected<void> check_age(const Alignment& alignment,
                         std::chrono::sys_seconds now,
                         std::chrono::seconds valid) {
  const std::chrono::seconds age = now - alignment.last_seen();
  const auto hours = [](std::chrono::seconds s) { return static_cast<double>(s.count()) / 3600; };
  if (age < std::chrono::seconds(0)) {
    return failure({Code::Usage,
                    {alignment.file, 0, 0},
                    "the panel was measured at " + iso_8601(alignment.last_seen()) +
                        ", after this computer's time",
                    "a clock that is right"});
  }
  if (age <= valid) return {};
  return failure(gate_failure(
      alignment,
      fmt::format(
          "the panel was seen {:.1f} hours ago, limit {:g} hours", hours(age), hours(valid)),
      "`panelcal align verify` to look at two pads again, or another --valid"));
}

Expected<SecondLook> look_again(const AlignedPanel& panel,
                                const MachineConfig& machine,
                                const OpenJobSources& open) {
  const Survey& then = *panel.survey();
  const std::vector<std::size_t>& points = then.series.front().points;
  const auto place_mm = [&](std::size_t i) { return then.measurements[i].request.nominal.in_mm(); };
  std::vector<std::size_t> chosen = {points.front()};
  double farthest_mm = 0;
  for (const std::size_t a : points) {
    for (const std::size_t b : points) {
      const double apart_mm = (place_mm(a) - place_mm(b)).norm();
      if (a >= b || apart_mm <= farthest_mm) continue;
      farthest_mm = apart_mm;
      chosen = {a, b};
    }
  }
  Survey nominal;
  for (const std::size_t i : chosen) {
    Measurement asked;
    asked.request = then.measurements[i].request;
    asked.request.file.clear();
    asked.request.seq = static_cast<std::int64_t>(nominal.measurements.size());
    asked.request.expected = panel.place_of(asked.request.nominal).position;
    asked.request.work_zero = configured_zero(machine.walk);
    asked.status = MeasurementStatus::Found;
    asked.measured.position = asked.request.expected;
    nominal.measurements.push_back(std::move(asked));
  }
  PANELCAL_TRY(const JobSources sources, open(nominal));
  SecondLook look;
  AlignmentCheck& check = look.check;
  check.limit = chi_square_limit(kCheckFalseAlarm, static_cast<int>(2 * chosen.size()));
  for (const std::size_t i : chosen) check.pads.push_back(static_cast<int>(i) + 1);
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const Measurement& old = then.measurements[chosen[k]];
    PANELCAL_TRY(const Measurement now, sources.targets->measure(nominal.measurements[k].request));
    if (now.status != MeasurementStatus::Found) {
      look.lost = not_found(chosen[k] + 1, old.request.nominal.in_mm(), now);
      return look;
    }
    const Eigen::Matrix2d cov_mm2 =
        now.measured.cov + old.measured.cov + 2 * machine.walk.uncertainty.of_target_mm2();
    const Eigen::Vector2d moved_mm = (now.measured.position - old.measured.position).in_mm();
    const double det = cov_mm2(0, 0) * cov_mm2(1, 1) - cov_mm2(0, 1) * cov_mm2(0, 1);
    check.chi_square += (cov_mm2(1, 1) * moved_mm.x() * moved_mm.x() -
                         2 * cov_mm2(0, 1) * moved_mm.x() * moved_mm.y() +
                         cov_mm2(0, 0) * moved_mm.y() * moved_mm.y()) /
                        det;
    check.seen.push_back(now.measured.position);
  }
  PANELCAL_CHECK(sources.targets->finish());
  check.is_accepted = check.chi_square <= check.limit;
  return look;
}

}  // namespace panelcal
