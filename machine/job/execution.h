// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "machine/config/machine_config.h"
#include "machine/job/request.h"
#include "machine/job/result.h"
#include "program/judge/depth_errors.h"
#include "program/judge/job_check.h"

// Not installed: the working walk of a job.
namespace panelcal::internal {

/// All that a job's operations pass through on their one way: the writer, what counts, judges and
/// explains them.
class JobExecution final : public OperationSink {
 public:
  enum class Aim : std::uint8_t {
    Operations,
    Verdict,      ///< and an explanation: nothing is written
    Explanation,  ///< nothing else: the job is refused
  };

  /// Precondition: job, machine, survey and sinks outlive this
  ///
  /// In     machine: aged, with the options of the walk
  ///        survey: what the job is walked with
  JobExecution(const Job& job,
               const MachineConfig& machine,
               const Survey& survey,
               const JobSinks& sinks,
               Aim aim);
  JobExecution(const JobExecution&) = delete;
  JobExecution& operator=(const JobExecution&) = delete;

  /// Options of the walk for this.
  WalkOptions walk() const;
  /// Before the first operation.
  ///
  /// Fails  what the output reports
  Expected<void> open();

  void begin(const ProgramInfo& info) override {
    for (OperationSink* sink : ends_) sink->begin(info);
  }
  void put(const Operation& operation) override {
    if (watches_slots_) watch(operation);
    for (OperationSink* sink : ends_) sink->put(operation);
  }

  /// Slots have passed as a whole, so that places would be counted otherwise than without an
  /// output: the explanation takes a walk of its own.
  bool has_to_explain_anew() const { return watches_slots_ && has_slots_; }
  Explainer make_explainer();
  /// As places are counted for explanations: numbers must not depend on the output's format.
  WalkOptions counting_walk() const;

  /// After the last operation.
  ///
  /// In     working_log: of the walk
  ///        explainer: that has walked anew; null: this one's own
  /// Out    into the result: what came of the job; problems into its log
  void finish(DiagnosticLog working_log, const Explainer* explainer, JobResult& result);

 private:
  const DepthErrors& depth_errors();
  std::optional<DepthJudge> depth_judge();
  void watch(const Operation& operation);
  bool explain(const Explainer* explainer, JobResult& result) const;
  bool judge(JobResult& result);
  Expected<void> commit();

  const Job& job_;
  const MachineConfig& machine_;
  const Survey& survey_;
  const JobSinks& sinks_;
  Aim aim_;
  std::optional<DepthErrors> depth_errors_;
  std::vector<OperationSink*> ends_;

  std::unique_ptr<TextWriter> writer_;
  Tally tally_;
  JobCheck job_check_;
  std::optional<SurfaceUse> surface_use_;
  WorstHole worst_hole_;
  std::unique_ptr<PlaceTable> places_;
  std::unique_ptr<JobVerdict> verdict_;
  std::unique_ptr<DepthVerdict> depth_;
  std::unique_ptr<TruthComparison> truth_;
  std::optional<Explainer> explainer_;
  bool watches_slots_ = false;
  bool has_slots_ = false;
};

}  // namespace panelcal::internal
