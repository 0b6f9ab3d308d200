// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "calib/base/diagnostic.h"
#include "machine/job/summary/place_table.h"
#include "machine/job/summary/truth_comparison.h"
#include "machine/job/summary/worst_hole.h"
#include "program/judge/depth_verdict.h"
#include "program/judge/job_verdict.h"
#include "program/judge/surface_use.h"
#include "program/judge/tally.h"
#include "program/walk/survey.h"

namespace panelcal {

/// The result of a job that was measured.
///
/// See    tests/machine/job/correct_test.cc
struct JobResult {
  std::shared_ptr<const Survey> survey;  ///< never null
  std::string source;                    ///< source of the measurements, in words
  DiagnosticLog log;                     ///< as JobSinks::log

  Tally tally;                            ///< of the corrected job
  std::unique_ptr<JobVerdict> verdict;    ///< null if [tolerance] asks for no positions
  std::unique_ptr<DepthVerdict> depth;    ///< null if it asks for no depths
  bool is_judged = false;                 ///< the verdicts are of the whole job
  std::optional<SurfaceUse> surface_use;  ///< the part of Job::surface in the depths
  /// Null without Job::truth, which has to outlive it.
  std::unique_ptr<TruthComparison> truth;
  std::unique_ptr<PlaceTable> places;    ///< of the corrected job; null without Job::keeps_places
  std::string explanation;               ///< of Job::explain; empty if there is no such place
  std::optional<HoleBudget> worst_hole;  ///< likeliest to break its tolerance, or least certain
  /// Of the worst place that a warning names, by which Job::explain knows it, where its line does
  /// not lead to it.
  std::optional<std::int64_t> worst_number;

  /// The machine's largest terms that its file leaves out ("drill wander not stated"), without
  /// which sigma is of the fit only; empty if they are.
  std::string unstated;

  bool is_executed = false;   ///< the whole job has passed without an error
  bool is_held = false;       ///< by [tolerance]
  bool is_committed = false;  ///< the output is there
  int n_walks = 0;            ///< over the program's text, from its beginning

  /// Every series is inside its limits, nothing is wrong in the program and no tolerance holds it.
  bool may_be_drilled() const { return is_executed && !is_held && !log.has_errors(); }
  /// The reason why not: the first error that is no limit's, or else the first one.
  ///
  /// Precondition: !may_be_drilled()
  Diagnostic refusal() const;
};

}  // namespace panelcal
