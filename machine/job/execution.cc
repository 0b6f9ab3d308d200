// SPDX-License-Identifier: Apache-2.0
#include "machine/job/execution.h"

#include <utility>
#include <variant>

#include "program/judge/probed_surface.h"
#include "program/judge/stated_risk.h"
#include "program/writers/program_writer.h"

namespace panelcal::internal {

JobExecution::JobExecution(const Job& job,
                           const MachineConfig& machine,
                           const Survey& survey,
                           const JobSinks& sinks,
                           Aim aim)
    : job_(job),
      machine_(machine),
      survey_(survey),
      sinks_(sinks),
      aim_(aim),
      job_check_(machine.travel) {
}

WalkOptions JobExecution::counting_walk() const {
  WalkOptions walk = machine_.walk;
  walk.slots = walk.step_slots = Cycles::Expanded;
  return walk;
}

WalkOptions JobExecution::walk() const {
  return aim_ == Aim::Operations ? machine_.walk : counting_walk();
}

/// Errors of depths, by a map that was given, or by what the job's probes show.
const DepthErrors& JobExecution::depth_errors() {
  if (!depth_errors_) {
    const BoardDepths& board = machine_.walk.board;
    std::vector<Expected<ZonedMap>> maps;
    if (board.map != nullptr) {
      maps.emplace_back(*board.map);
    } else {
      maps = probed_surfaces(survey_, machine_.walk.sieb_meyer.grid_hold);
    }
    depth_errors_.emplace(
        machine_.walk.uncertainty.depth, std::move(maps), job_.format != OutputFormat::Gcode);
  }
  return *depth_errors_;
}

/// Empty if nothing is asked of depths.
std::optional<DepthJudge> JobExecution::depth_judge() {
  const Tolerances& tolerances = machine_.walk.tolerances;
  if (!tolerances.asks_depths()) return std::nullopt;
  return DepthJudge(tolerances, depth_errors());
}

Explainer JobExecution::make_explainer() {
  return {*job_.explain,
          job_.program,
          survey_,
          machine_.walk.uncertainty,
          machine_.walk.tolerances,
          depth_judge()};
}

Expected<void> JobExecution::open() {
  const WalkOptions& walk = machine_.walk;
  if (aim_ == Aim::Operations) {
    if (job_.format && sinks_.output != nullptr) {
      PANELCAL_CHECK(sinks_.output->begin());
      writer_ = make_writer(*job_.format,
                            *sinks_.output,
                            machine_,
                            {.title = job_.program.source.file,
                             .comments = job_.comments,
                             .depths = depth_judge(),
                             .survey = &survey_,
                             .resolution = job_.resolution});
      ends_.push_back(writer_.get());
    }
    if (sinks_.operations != nullptr) ends_.push_back(sinks_.operations);
    ends_.push_back(&tally_);
    ends_.push_back(&job_check_);
    if (walk.board.map != nullptr) ends_.push_back(&surface_use_.emplace());
    if (job_.finds_worst_place) ends_.push_back(&worst_hole_);
    if (job_.keeps_places) {
      places_ = std::make_unique<PlaceTable>();
      ends_.push_back(places_.get());
    }
    if (job_.truth) {
      truth_ = std::make_unique<TruthComparison>(*job_.truth, survey_, walk.uncertainty);
      ends_.push_back(truth_.get());
    }
  }
  if (aim_ != Aim::Explanation && walk.tolerances.asks_positions()) {
    verdict_ = std::make_unique<JobVerdict>(walk.tolerances);
    ends_.push_back(verdict_.get());
  }
  if (aim_ != Aim::Explanation && walk.tolerances.asks_depths()) {
    depth_ = std::make_unique<DepthVerdict>(walk.tolerances, depth_errors());
    ends_.push_back(depth_.get());
  }
  if (job_.explain) {
    ends_.push_back(&explainer_.emplace(make_explainer()));
    watches_slots_ =
        aim_ == Aim::Operations && (walk.slots == Cycles::Kept || walk.step_slots == Cycles::Kept);
  }
  return {};
}

void JobExecution::watch(const Operation& operation) {
  has_slots_ = has_slots_ || std::holds_alternative<Slot>(operation.what) ||
               std::holds_alternative<StepSlot>(operation.what);
}

/// False if there is no such place.
bool JobExecution::explain(const Explainer* explainer, JobResult& result) const {
  if (!job_.explain) return true;
  if (explainer == nullptr) explainer = &*explainer_;
  if (explainer->has_found() || !job_.explain->number) {
    result.explanation = explainer->text();
    return true;
  }
  result.log.add({Code::Usage, {job_.command, 0, 0}, "--explain: " + explainer->text(), ""});
  return false;
}

/// False if [tolerance] holds the job.
bool JobExecution::judge(JobResult& result) {
  const std::string& file = job_.program.source.file;
  bool is_held = false;
  if (verdict_) {
    verdict_->report(file, result.log);
    is_held = verdict_->decision() == JobDecision::Hold;
  }
  if (depth_) {
    depth_->report(file, result.log);
    is_held = is_held || depth_->decision() == JobDecision::Hold;
  }
  result.is_judged = true;
  result.is_held = is_held;
  return !is_held;
}

Expected<void> JobExecution::commit() {
  PANELCAL_CHECK(writer_->finish());
  return sinks_.output->commit();
}

void JobExecution::finish(DiagnosticLog working_log,
                          const Explainer* explainer,
                          JobResult& result) {
  const bool is_explained = explain(explainer, result);
  if (verdict_) verdict_->set_basis(risk_basis(*verdict_, survey_, machine_.walk.uncertainty));
  if (aim_ == Aim::Operations) {
    job_check_.report(job_.program, working_log);
    if (const auto* writer = dynamic_cast<const ProgramWriter*>(writer_.get())) {
      for (const Diagnostic& loss : writer->losses().kept()) working_log.add(loss);
    }
  }
  for (const Diagnostic& diagnostic : working_log.kept()) result.log.add(diagnostic);
  if (aim_ != Aim::Operations && !is_explained) return;
  // All that takes memory comes before the output is committed: a job without an output ends so.
  const MachineUncertainty& uncertainty = machine_.walk.uncertainty;
  // Of a job that is held it is all the more wanted.
  if (job_.finds_worst_place && verdict_) {
    result.worst_hole = likeliest_to_break(*verdict_, survey_, uncertainty);
  }
  if (job_.finds_worst_place && !result.worst_hole) {
    result.worst_hole = worst_hole_.budget(survey_, uncertainty);
  }
  result.unstated = unstated_words(uncertainty);
  result.tally = tally_;
  result.surface_use = surface_use_;
  result.is_executed = !working_log.has_errors();
  if (result.is_executed && aim_ != Aim::Explanation) {
    const bool is_sure_enough = judge(result);
    if (writer_ && (is_sure_enough || job_.force)) {
      if (Expected<void> done = commit(); done) {
        result.is_committed = true;
      } else {
        result.log.add(std::move(done).error());
      }
    }
  }
  result.verdict = std::move(verdict_);
  result.depth = std::move(depth_);
  result.truth = std::move(truth_);
  result.places = std::move(places_);
}

}  // namespace panelcal::internal
