// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "calib/correction/hole_shift.h"
#include "calib/correction/spindle_camera.h"
#include "calib/correction/table_correction.h"
#include "calib/ledger/entry/entry.h"
#include "program/walk/walk.h"
#include "tools/plan/design/places.h"

// Effect of a change of calibration on a job: `panelcal history diff A B --program P`.
namespace panelcal::history {

/// By how much a target is measured elsewhere if one calibration takes the place of another; the
/// target and the panel stay where they are.
using TargetShift = std::function<Expected<Displacement<frame::Actual>>(const Measurement&)>;

/// Two calibrations of one thing.
struct CalibrationChange {
  TargetShift target_shift;
  /// Of two calibrations of the table, which place holes by themselves; otherwise null, and the
  /// machine's own holds with either.
  std::shared_ptr<const TableCorrection> table_before;
  std::shared_ptr<const TableCorrection> table_after;
  std::vector<std::string> notes;  ///< the assumptions, a sentence each
};

/// An entry with its calibration's own bytes.
struct CalibrationEntry {
  const LedgerEntry& entry;
  const std::string& result;
};

/// The facts about a machine that decide where its stage stands when it looks.
struct LookingMachine {
  SpindleCameraOffset offset;
  Length table_hold;  ///< [table] hold_mm
};

/// The part of a target's place from a spindle-camera offset, a camera or a table calibration.
///
///   spindle-camera  shift = d_after - d_before, the same for every target
///   camera          shift = K_after(u) - K_before(u), u where the target was seen in the picture:
///                   measured - expected, which slots and views that a search has moved do not say
///   table           shift = E_after(c) - E_before(c), c the command by which it was seen; a hole
///                   moves once more, since another command brings the spindle to it
///
/// In     machine: asked of tables alone
/// Fails  ledger-entry-invalid (of another kind; not both of one machine and subject; without an
///        offset in mm); what reading the calibrations reports. `file` is the ledger's.
Expected<CalibrationChange> change_between(const CalibrationEntry& before,
                                           const CalibrationEntry& after,
                                           const std::string& file,
                                           const LookingMachine& machine = {});

/// A place of the job and how far it would move.
struct MovedPlace {
  plan::PlannedPlace place;
  Displacement<frame::Actual> shift;
};

/// The fate of a job.
struct JobShift {
  HoleShiftSummary summary;  ///< over all places: holes, ends of slots and of rout moves
  std::size_t n_drilled = 0;
  bool has_routs = true;  ///< false: rout moves are left out, since they are cut differently
  /// Places that no target corrects; they count, with a shift of zero. A table moves these too, so
  /// that there are none.
  std::size_t n_still = 0;
  MovedPlace worst;
  std::vector<MovedPlace> sample;  ///< all of them, or one in each cell of a grid
  std::vector<Position<frame::Nominal>> hull;
  std::vector<Position<frame::Nominal>> targets;

  /// Every place moves alike, to a nanometre.
  bool is_uniform() const;
};

/// Measures the job once more with every target moved by `change`, fits again, and compares where
/// each place comes to lie, by what the machine is told. So nested corrections, layers and models
/// are what they are in a run.
///
/// In     before: a complete survey of `program` with `options`
/// Out    empty if the program works nowhere
/// Fails  usage (the program calibrates the offset itself); what the change or a fit reports
/// Cost   two walks for every four million places; 128 MB at most
/// See    tests/tools/history/diff_test.cc
Expected<std::optional<JobShift>> job_shift(const Program& program,
                                            const WalkOptions& options,
                                            const Survey& before,
                                            const CalibrationChange& change);

/// The frame of the figures.
struct JobShiftWords {
  std::string program_file;
  std::vector<std::string> notes;
};

std::string job_shift_text(const JobShift& shift, const JobShiftWords& words);

}  // namespace panelcal::history
