// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include "calib/correction/stack.h"
#include "machine/align/alignment.h"
#include "machine/align/pads.h"
#include "machine/job/job.h"

namespace panelcal {

/// Measures pads as the one series of a job, by the same code: sources, choice among candidates,
/// fit, gates.
///
/// In     open: its survey has the pads with the lines of their file
/// Out    a result also if gates refuse the fit; lines are those of the pads' file
/// Fails  as correct()
/// See    tests/machine/align/measure_test.cc
Expected<JobResult> measure_pads(const PadList& pads,
                                 const OpenJobSources& open,
                                 MachineConfig machine,
                                 std::chrono::sys_seconds now,
                                 const JobSinks& sinks = {});

/// The files of a machine that measurements depend on: its own, and the calibrations it names.
///
/// Fails  file-unreadable
Expected<std::vector<AlignmentInput>> alignment_inputs(const MachineConfig& machine);

/// The parts of an alignment that a result states: measurements, fit, gates and the reason if it is
/// held.
void put_result(const JobResult& result, Alignment& alignment);

/// A panel as an alignment knows it: carries any nominal place to where the machine finds it.
class AlignedPanel {
 public:
  /// Precondition: the survey has one base series, and it is fitted
  AlignedPanel(std::shared_ptr<const Survey> survey, const MachineUncertainty& machine);

  /// For Job::aligned.
  const std::shared_ptr<const Survey>& survey() const { return survey_; }
  /// Place relative to work zero, with the covariance of what is drilled there: fit, camera,
  /// spindle-camera offset, stage, table and drill.
  PositionEstimate<frame::Actual> place_of(const Position<frame::Nominal>& nominal) const {
    return stack_.drilled(nominal);
  }
  /// The map itself, or the affine one nearest to it: see is_bent().
  const Transform<frame::Actual, frame::Nominal>& actual_from_nominal() const {
    return stack_.actual_from_nominal().map;
  }
  bool is_bent() const { return stack_.is_bent(); }

 private:
  std::shared_ptr<const Survey> survey_;
  CorrectionStack stack_;
};

/// Fits an alignment's measurements anew, and checks that the machine is the one that measured them
/// and that the fit is the file's.
///
/// In     machine: as read_machine_config() reads it; its spindle-camera offset has drifted until
///        `now` in the panel's uncertainty
/// Fails  usage (another machine file or calibration); gate-failed (held, not found, moved);
///        calibration-invalid (the fit is not the file's)
/// See    tests/machine/align/measure_test.cc
Expected<AlignedPanel> restore_panel(const Alignment& alignment,
                                     const MachineConfig& machine,
                                     std::chrono::sys_seconds now);

/// Checks that the panel was seen to lie there not too long ago.
///
/// Fails  gate-failed; usage (it was seen after `now`)
Expected<void> check_age(const Alignment& alignment,
                         std::chrono::sys_seconds now,
                         std::chrono::seconds valid);

struct SecondLook {
  AlignmentCheck check;
  /// The reason if a pad was not found, which is a failed check: target-not-found,
  /// target-ambiguous or target-rejected.
  std::optional<Diagnostic> lost;
};

/// Looks again at the two pads of the fit that lie farthest apart, and compares them with where
/// they were:
///
///   chi square = sum over pads d' (C_now + C_then)^-1 d,   d = seen now - seen then
///
/// with the stage and the table in either covariance; the camera and the spindle-camera offset are
/// the same both times.
///
/// Out    is_accepted if a panel that lies still exceeds it in at most 1 of 1,000 checks, and both
///        pads are to be seen; without time and name
/// Fails  what the sources report
/// See    tests/tools/align_test.py
Expected<SecondLook> look_again(const AlignedPanel& panel,
                                const MachineConfig& machine,
                                const OpenJobSources& open);

}  // namespace panelcal
