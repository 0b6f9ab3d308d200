// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/work/job_rows.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "calib/base/json/facts.h"
#include "calib/base/statistics/chi_square.h"
#include "machine/job/facts/survey_facts.h"
#include "tools/cli/process/exit_code.h"

namespace panelcal::batch {
namespace {

using facts::TargetFact;
using facts::TargetState;

std::int64_t whole(auto n) {
  return static_cast<std::int64_t>(n);
}

StoredValue maybe(const std::optional<double>& value) {
  return value ? StoredValue(*value) : StoredValue();
}

/// Of a target that shows one coordinate only the other one is no measurement.
std::optional<Eigen::Vector2d> error_um(const Measurement& measurement, const Truth* truth) {
  if (truth == nullptr || measurement.request.axes != ObservedAxes::Both) return std::nullopt;
  const auto target =
      std::ranges::find(truth->targets, measurement.request.seq, &Truth::Target::seq);
  if (target == truth->targets.end()) return std::nullopt;
  return (measurement.measured.position - target->actual).in_mm() * 1e3;
}

StoredRow target_row(std::int64_t job, const TargetFact& fact, const Truth* truth) {
  const Measurement& m = *fact.measurement;
  const MeasurementRequest& request = m.request;
  const Eigen::Vector2d nominal_mm = request.nominal.in_mm();
  StoredRow row = {job,
                   request.seq,
                   whole(request.line),
                   request.command,
                   std::string(name(fact.state)),
                   std::string(name(m.status)),
                   m.reason,
                   nominal_mm.x(),
                   nominal_mm.y()};
  const auto put = [&](const std::optional<Eigen::Vector2d>& pair) {
    row.push_back(pair ? StoredValue(pair->x()) : StoredValue());
    row.push_back(pair ? StoredValue(pair->y()) : StoredValue());
  };
  const bool is_found = m.status == MeasurementStatus::Found;
  put(is_found ? std::optional<Eigen::Vector2d>(m.measured.position.in_mm()) : std::nullopt);
  for (const auto& [i, k] : {std::pair(0, 0), std::pair(0, 1), std::pair(1, 1)}) {
    row.push_back(is_found ? StoredValue(m.measured.cov(i, k) * 1e6) : StoredValue());
  }
  put(fact.residual_mm ? std::optional<Eigen::Vector2d>(*fact.residual_mm * 1e3) : std::nullopt);
  put(is_found ? error_um(m, truth) : std::nullopt);
  row.push_back(maybe(m.score));
  row.emplace_back(m.image);
  return row;
}

StoredRow fit_row(std::int64_t job, std::int64_t i, const SeriesResult& series) {
  StoredRow row = {job,
                   i,
                   std::string(series.level == CorrectionLevel::Base ? "base" : "nested"),
                   whole(series.line),
                   std::string(name(series.model)),
                   whole(series.points.size())};
  if (series.is_fitted()) {
    const int n_spare = series.degrees_of_freedom;
    row.insert(row.end(),
               {series.chi_square,
                whole(n_spare),
                n_spare > 0 ? StoredValue(chi_square_exceedance(series.chi_square, n_spare))
                            : StoredValue(),
                series.worst_residual_um(),
                series.shift_x_mm.value,
                series.shift_y_mm.value,
                series.rotation_rad.value,
                series.stretch_x_ppm.value,
                series.stretch_y_ppm.value,
                series.shear_ppm.value});
  } else {
    row.insert(row.end(), {StoredValue(), std::int64_t{0}});
    row.resize(row.size() + 8);
  }
  row.emplace_back(whole(series.is_accepted()));
  return row;
}

StoredRow holes_row(std::int64_t job, const JobResult& result) {
  const Tally& tally = result.tally;
  StoredRow row = {job,
                   tally.n_holes(),
                   tally.n_slots(),
                   tally.n_routs(),
                   tally.max_shift().in_um(),
                   tally.max_sigma().in_um(),
                   result.verdict ? StoredValue(result.verdict->expected_broken()) : StoredValue()};
  if (result.truth == nullptr) {
    row.resize(row.size() + 5);
    return row;
  }
  const TruthComparison::Errors& errors = result.truth->all();
  row.insert(row.end(),
             {errors.corrected.rms().in_um(),
              errors.corrected.max().in_um(),
              errors.uncorrected.rms().in_um(),
              errors.uncorrected.max().in_um(),
              result.truth->mean_normalized_square()});
  return row;
}

std::string factors_text(const ManifestJob& job) {
  facts::Json factors = facts::Json::object();
  for (const auto& [name, value] : job.factors) factors[name] = value;
  return factors.dump(-1, ' ', false, facts::Json::error_handler_t::replace);
}

/// Bytes that are no UTF-8 are replaced, as in facts.
std::string clean(const std::string& text) {
  return facts::Json::parse(
             facts::Json(text).dump(-1, ' ', false, facts::Json::error_handler_t::replace))
      .get<std::string>();
}

StoredValue text_or_none(const std::string& text) {
  return text.empty() ? StoredValue() : StoredValue(clean(text));
}

}  // namespace

StoredRow picture_row(std::int64_t job, std::int64_t i, const SeenView& seen) {
  const Detection& detection = seen.detection;
  StoredRow row = {job,
                   i,
                   seen.request.seq,
                   whole(seen.view.i_view),
                   seen.picture.name,
                   std::string(name(detection.status))};
  if (const auto& best = detection.best) {
    row.insert(row.end(),
               {best->score,
                best->contrast,
                best->noise,
                best->blur_px,
                best->excluded,
                best->visible,
                std::sqrt(best->center.cov.trace() / 2)});
  } else {
    row.resize(row.size() + 7);
  }
  row.emplace_back(whole(detection.n_candidates));
  return row;
}

void put_result(const JobResult& result, const Truth* truth, JobOutcome& outcome) {
  const Survey& survey = *result.survey;
  for (const TargetFact& fact : facts::target_facts(survey)) {
    outcome.of(JobTable::Target).push_back(target_row(outcome.number, fact, truth));
  }
  for (std::size_t i = 0; i < survey.series.size(); ++i) {
    outcome.of(JobTable::Fit).push_back(fit_row(outcome.number, whole(i), survey.series[i]));
  }
  if (result.is_executed) {
    outcome.of(JobTable::HoleSummary).push_back(holes_row(outcome.number, result));
  }
}

void put_head(const ManifestJob& job,
              const JobHead& head,
              const JobResult* result,
              const DiagnosticLog& log,
              JobOutcome& outcome) {
  const ExitCode code = exit_code(log);
  outcome.exit_code = static_cast<int>(code);
  outcome.state = code == ExitCode::Done         ? JobState::Drilled
                  : code == ExitCode::GateFailed ? JobState::Held
                                                 : JobState::Failed;
  std::int64_t number = 0;
  const Diagnostic* reason = nullptr;
  for (const Diagnostic& diagnostic : log.kept()) {
    const bool is_error = diagnostic.severity() == Severity::Error;
    outcome.of(JobTable::Diagnostic)
        .push_back({outcome.number,
                    number++,
                    std::string(is_error ? "error" : "warning"),
                    std::string(info(diagnostic.code).slug),
                    clean(diagnostic.text())});
    // The gravest, and of those the first.
    if (is_error && (reason == nullptr || exit_code(*reason) < exit_code(diagnostic))) {
      reason = &diagnostic;
    }
  }
  StoredRow row = {outcome.number,
                   job.id,
                   std::string(name(outcome.state)),
                   whole(outcome.exit_code),
                   clean(job.program),
                   clean(job.machine),
                   clean(head.machine_name),
                   text_or_none(job.images),
                   text_or_none(job.measurements),
                   result == nullptr ? StoredValue() : StoredValue(clean(result->source)),
                   head.clock,
                   text_or_none(head.output)};
  if (result == nullptr) {
    row.resize(row.size() + 2);
  } else {
    row.emplace_back(whole(result->survey->measurements.size()));
    row.emplace_back(whole(facts::n_found(*result->survey)));
  }
  row.emplace_back(outcome.n_pictures);
  if (reason == nullptr) {
    row.resize(row.size() + 2);
  } else {
    row.emplace_back(std::string(info(reason->code).slug));
    row.emplace_back(clean(reason->message()));
  }
  row.emplace_back(factors_text(job));
  outcome.of(JobTable::Job).push_back(std::move(row));
}

}  // namespace panelcal::batch
