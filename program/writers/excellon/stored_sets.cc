// SPDX-License-Identifier: Apache-2.0
// Corrections that a SIEB & MEYER program saves and loads (G39), as M50, M51 and M52.
#include <utility>

#include "program/writers/excellon/writer.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

bool is_work(const Operation& operation) {
  const auto& what = operation.what;
  return std::holds_alternative<Drill>(what) || std::holds_alternative<Slot>(what) ||
         std::holds_alternative<StepSlot>(what) || std::holds_alternative<Rout>(what) ||
         std::holds_alternative<RapidMove>(what) || std::holds_alternative<TargetHole>(what);
}

const StoredCorrection* stored_of(const Operation& operation, StoredCorrectionKind kind) {
  const auto* stored = std::get_if<StoredCorrection>(&operation.what);
  return stored != nullptr && stored->kind == kind ? stored : nullptr;
}

}  // namespace

// --- outside of patterns -----------------------------------------------------------------------

/// M50 stands ahead of a series, G39,SAVE behind it: a base series waits for what comes. True: the
/// operation is done with, or waits too.
bool ExcellonWriter::hold(const Operation& operation) {
  const auto* const series = std::get_if<VisionSeries>(&operation.what);
  const auto* const stored = std::get_if<StoredCorrection>(&operation.what);
  const bool begins = series != nullptr && series->level == CorrectionLevel::Base;
  if (stored != nullptr && stored->kind == StoredCorrectionKind::Keep) {
    put_held(stored);
    return true;
  }
  if (held_.size() == 0 && !begins) return false;
  if (series != nullptr || stored != nullptr || is_work(operation)) {
    put_held(nullptr);
    note_place(operation);
    if (!begins) return false;
  }
  held_.add(operation);
  return true;
}

/// Writes what waits; with `keep` the series is one that is stored, in a pattern of its own.
void ExcellonWriter::put_held(const StoredCorrection* keep) {
  if (held_.size() == 0) return;
  const StoredOperations held = std::exchange(held_, {});
  note_place(held[0]);
  if (keep != nullptr) {
    end_replay();
    n_kept_copies_[keep->label] = 1;
    put_now({.what = StoredCorrection{StoredCorrectionKind::RecordNext, keep->label, {}, 0}});
    put_now({.what = PatternBegin()});
  }
  put_now(held[0]);
  if (keep != nullptr) close_pattern({});
  for (std::size_t i = 1; i < held.size(); ++i) {
    note_place(held[i]);
    put_now(held[i]);
  }
}

/// M51 goes back to the first copy's points, M52 passes those up to the copy's.
/// Source CNC-7 manual, Vision Step and Repeat Offset Counter Control
void ExcellonWriter::use_stored(const StoredCorrection& stored) {
  const auto kept = n_kept_copies_.find(stored.label);
  const int copy = stored.copy > 0 ? stored.copy : executed_copy_;
  if (kept == n_kept_copies_.end() || copy > kept->second) {
    return refuse("a correction that is saved behind other work (G39,SAVE)",
                  "G39,SAVE right behind its G31");
  }
  if (copy == 0) {
    line(fmt::format("M52,{}", stored.n_targets));
  } else {
    pass_points(stored, copy * stored.n_targets, kept->second * stored.n_targets);
  }
  // An offset alone stands on the correction in force.
  const bool is_offset_alone = stored.is_offset && stored.n_targets == 1;
  if (!is_offset_alone) has_base_ = true;
  has_nested_ = false;
}

void ExcellonWriter::pass_points(const StoredCorrection& stored, int n_points, int n_all) {
  const bool goes_on = replay_ && replay_->label == stored.label && replay_->n_passed < n_points;
  if (!goes_on) {
    end_replay();
    line(fmt::format("M51,{}", stored.label));
    replay_ = Replay{stored.label, 0, n_all};
  }
  line(fmt::format("M52,{}", n_points - std::exchange(replay_->n_passed, n_points)));
}

/// "There must be as many M52 commands after an M51 as G36/G46": passes the rest, whose correction
/// another one, or none, replaces at once.
void ExcellonWriter::end_replay() {
  if (is_replaying()) line(fmt::format("M52,{}", replay_->n_points - replay_->n_passed));
  replay_.reset();
}

/// The other control looks where the correction in force puts the targets; G35 and G36 are
/// "relative to the current work zero" (CNC-7 manual).
void ExcellonWriter::lose_looking() {
  lose_once("looking for targets where the correction in force puts them");
}

void ExcellonWriter::note_base_series() {
  if (std::exchange(has_base_, true)) lose_looking();
  end_replay();
}

// --- in patterns -------------------------------------------------------------------------------

ExcellonWriter::PatternSets ExcellonWriter::sets_of(std::size_t begin, std::size_t end) const {
  PatternSets sets;
  for (std::size_t i = begin; i < end; ++i) {
    if (const auto* keep = stored_of(stored_[i], StoredCorrectionKind::Keep)) sets.keep = keep;
    const auto* const use = stored_of(stored_[i], StoredCorrectionKind::Use);
    if (use == nullptr) continue;
    if (use->copy == 0) {
      sets.use = use;
    } else {
      sets.uses_others |= !is_superseded(i, end);
    }
  }
  return sets;
}

/// M25 to M08 serves what its copies store and use: each uses the next one, from the first on and
/// ahead of its work, until all are used.
bool ExcellonWriter::may_repeat_sets(const PatternSets& sets,
                                     std::size_t begin,
                                     std::size_t end,
                                     std::size_t n_copies) const {
  if (sets.uses_others) return false;
  if (sets.keep != nullptr) return !is_replaying() || measures_first(begin, end);
  if (sets.use == nullptr) return !is_replaying();
  const auto kept = n_kept_copies_.find(sets.use->label);
  const bool uses_all = kept != n_kept_copies_.end() && kept->second == static_cast<int>(n_copies);
  return uses_all && !works_before_use(begin);
}

/// A pattern that uses its copies' corrections, from `begin` on, works ahead of that.
bool ExcellonWriter::works_before_use(std::size_t begin) const {
  for (std::size_t i = begin; true; ++i) {
    const auto* const use = stored_of(stored_[i], StoredCorrectionKind::Use);
    if (use != nullptr && use->copy == 0) return false;
    if (is_work(stored_[i])) return true;
  }
}

/// A pattern that keeps its copies' corrections measures before it works.
bool ExcellonWriter::measures_first(std::size_t begin, std::size_t end) const {
  for (std::size_t i = begin; i < end && !is_work(stored_[i]); ++i) {
    const auto* const series = std::get_if<VisionSeries>(&stored_[i].what);
    if (series != nullptr) return series->level == CorrectionLevel::Base;
  }
  return false;
}

/// What a pattern does last to the base correction puts one in force.
bool ExcellonWriter::leaves_base(std::size_t begin, std::size_t end) const {
  bool leaves = false;
  for (std::size_t i = begin; i < end; ++i) {
    const auto* const series = std::get_if<VisionSeries>(&stored_[i].what);
    const auto* const cancel = std::get_if<CancelCorrection>(&stored_[i].what);
    if (series != nullptr) leaves |= series->level == CorrectionLevel::Base;
    if (cancel != nullptr) leaves &= cancel->level != CorrectionLevel::Base;
  }
  return leaves;
}

/// A correction that is loaded by the number of its location, and replaced before anything is done
/// under it: it only says where to look.
bool ExcellonWriter::is_superseded(std::size_t i, std::size_t end) const {
  const auto* const use = stored_of(stored_[i], StoredCorrectionKind::Use);
  if (use == nullptr || use->copy == 0) return false;
  for (++i; i < end && !is_work(stored_[i]); ++i) {
    const Operation& next = stored_[i];
    const auto* const series = std::get_if<VisionSeries>(&next.what);
    const auto* const cancel = std::get_if<CancelCorrection>(&next.what);
    if (series != nullptr) return series->level == CorrectionLevel::Base;
    if (cancel != nullptr && cancel->level == CorrectionLevel::Base) return true;
    if (std::holds_alternative<StoredCorrection>(next.what)) {
      return stored_of(next, StoredCorrectionKind::Use) != nullptr;
    }
  }
  return false;
}

}  // namespace panelcal
