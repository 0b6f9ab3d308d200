// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include "machine/job/output/output.h"
#include "machine/job/output/output_format.h"
#include "machine/sim/truth.h"
#include "program/judge/explain.h"
#include "program/model/operation.h"
#include "program/walk/program.h"
#include "program/walk/reading_terms.h"
#include "program/walk/survey.h"
#include "surface/map/zoned_map.h"

namespace panelcal {

/// A program that is to be corrected, and how.
struct Job {
  Program program;        ///< as read_job() or load_program() reads it
  DiagnosticLog reading;  ///< diagnostics of the reading
  /// Time of the job: the spindle-camera offset has drifted until now.
  std::chrono::sys_seconds now;
  /// The time on the wall that texts name, as wall_time() takes it; empty: `now`, where this
  /// computer stands.
  std::string clock;

  /// The format of JobSinks::output; present if and only if that is.
  std::optional<OutputFormat> format;
  std::vector<std::string> comments;  ///< for the output: what made it, one line each
  /// Slots stay cycles that the control expands; absent: what suits the format.
  std::optional<bool> keeps_slots;
  /// Of coordinates in a program; absent: the digits that the control reads (output_digits.h). The
  /// rounding counts in sigma and in [tolerance].
  std::optional<Length> resolution;
  std::optional<ExplainChoice> explain;
  std::string command = "panelcal";  ///< as diagnostics about Job::explain name who asks
  /// A map of the board's surface that was made before; null: none.
  std::shared_ptr<const ZonedMap> surface;
  /// The panel was measured before (machine/align/measure.h): the program is corrected by that, and
  /// may measure no target of its own. Null: it was not.
  std::shared_ptr<const Survey> aligned;
  std::optional<Truth> truth;  ///< to compare the holes with, where it is known
  /// A job that gates or tolerances refuse is written all the same.
  bool force = false;
  bool compares_models = false;    ///< the report shows the models that were not taken
  bool keeps_places = false;       ///< JobResult::places is wanted: memory grows with the job
  bool finds_worst_place = false;  ///< JobResult::worst_hole and worst_number are wanted
  std::int64_t max_operations = kUsualMaxOperations;
  /// Z axis of the probes that `surface` is made of, from 0; the spindle that drills has to have
  /// it. Empty: unknown (StoredMap).
  std::optional<int> surface_axis;
};

/// Receivers of a job's results while it runs. All may be empty; all outlive the job.
struct JobSinks {
  /// Gets the corrected program, in Job::format; it is committed only if the job may be drilled.
  JobOutput* output = nullptr;
  /// Gets every corrected operation. They may be used only if JobResult::may_be_drilled().
  OperationSink* operations = nullptr;
  /// Progress of the measuring: one line that takes the place of the last one.
  std::function<void(std::string_view)> progress = {};
  /// The measuring has ended, whatever came of it; `remark` is the source's, often empty.
  std::function<void(std::string_view remark)> end_progress = {};
  /// Told after each series of targets; its fit is the last of the survey, as far as there is one.
  std::function<void(const Survey&)> fitted = {};
  /// The measurements and fits, before anything is computed from them. A failure ends the job.
  std::function<Expected<void>(const Survey&)> measured = {};
  /// Becomes the log of the job, also of one that fails: all problems, stage by stage.
  DiagnosticLog* log = nullptr;
};

}  // namespace panelcal
