// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/job/output.h"
#include "machine/job/output_format.h"
#include "machine/job/sources.h"
#include "machine/job/truth_comparison.h"
#include "machine/job/worst_hole.h"
#include "machine/sim/truth.h"
#include "program/judge/depth_verdict.h"
#include "program/judge/explain.h"
#include "program/judge/job_verdict.h"
#include "program/judge/surface_use.h"
#include "program/judge/tally.h"
#include "program/walk/walk.h"
#include "surface/map/zoned_map.h"

namespace panelcal {

/// A program that is to be corrected, and how.
struct Job {
  Program program;        ///< as read_job() or load_program() reads it
  DiagnosticLog reading;  ///< what was found on the way
  /// When: the spindle-camera offset has drifted until now.
  std::chrono::sys_seconds now;
  /// The time on the wall that texts name, as wall_time() takes it; empty: `now`, where this
  /// computer stands.
  std::string clock;

  /// What JobSinks::output gets; absent: nothing is written.
  std::optional<OutputFormat> format;
  std::vector<std::string> comments;  ///< for the output: what made it, one line each
  /// Slots stay cycles that the control expands; absent: what suits the format.
  std::optional<bool> keeps_slots;
  std::optional<ExplainChoice> explain;
  std::string command = "panelcal";  ///< as diagnostics about Job::explain name who asks
  /// A map of the board's surface that was made before; null: none.
  std::shared_ptr<const ZonedMap> surface;
  std::optional<Truth> truth;  ///< to compare the holes with, where it is known
  /// A job that gates or tolerances refuse is written all the same.
  bool force = false;
  bool compares_models = false;    ///< the report shows the models that were not taken
  bool finds_worst_place = false;  ///< JobResult::worst_hole and worst_number are wanted
  std::int64_t max_operations = 1'000'000'000;
};

/// Reads a program and the stored patterns that it names, which are looked for beside it and where
/// the machine says. What is wrong in it stands in Job::reading.
///
/// In     path: `-` is standard input
/// Fails  file-unreadable
Expected<Job> read_job(const std::string& path,
                       const MachineConfig& machine,
                       std::chrono::sys_seconds now);

/// Who is told of a job while it runs. All may be empty; all outlive the job.
struct JobSinks {
  /// Gets the corrected program, in Job::format; it is committed only if the job may be drilled.
  JobOutput* output = nullptr;
  /// Gets every corrected operation. They may be used only if JobResult::may_be_drilled().
  OperationSink* operations = nullptr;
  /// Where the measuring is: one line that takes the place of the last one.
  std::function<void(std::string_view)> progress = {};
  /// The measuring has ended, whatever came of it; `remark` is the source's, often empty.
  std::function<void(std::string_view remark)> end_progress = {};
  /// What was measured and fitted, before anything is worked out from it. A failure ends the job.
  std::function<Expected<void>(const Survey&)> measured = {};
  /// Becomes the log of the job, also of one that fails: all problems, stage by stage.
  DiagnosticLog* log = nullptr;
};

/// What has become of a job that was measured.
///
/// See    tests/machine/job/correct_test.cc
struct JobResult {
  std::shared_ptr<const Survey> survey;  ///< never null
  std::string source;                    ///< where the measurements came from, in words
  DiagnosticLog log;                     ///< as JobSinks::log

  Tally tally;                            ///< of the corrected job
  std::unique_ptr<JobVerdict> verdict;    ///< null if [tolerance] asks for no positions
  std::unique_ptr<DepthVerdict> depth;    ///< null if it asks for no depths
  bool is_judged = false;                 ///< the verdicts are of the whole job
  std::optional<SurfaceUse> surface_use;  ///< what depths took from Job::surface
  /// Null without Job::truth, which has to outlive it.
  std::unique_ptr<TruthComparison> truth;
  std::string explanation;  ///< what Job::explain asks for; empty if there is no such place
  std::optional<HoleBudget> worst_hole;  ///< likeliest to break its tolerance, or least certain
  /// Of the worst place that a warning names, by which Job::explain knows it, where its line does
  /// not lead to it.
  std::optional<std::int64_t> worst_number;

  bool is_executed = false;   ///< the whole job has passed without an error
  bool is_held = false;       ///< by [tolerance]
  bool is_committed = false;  ///< the output is there
  int n_walks = 0;            ///< over the program's text, from its beginning

  /// Every series is inside its limits, nothing is wrong in the program and no tolerance holds it.
  bool may_be_drilled() const { return is_executed && !is_held && !log.has_errors(); }
  /// Why not: the first error that is no limit's, or else the first one.
  ///
  /// Precondition: !may_be_drilled()
  Diagnostic refusal() const;
};

}  // namespace panelcal
