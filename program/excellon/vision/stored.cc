// SPDX-License-Identifier: Apache-2.0
// Corrections stored under labels: M50, M51, M52.
#include <utility>

#include "program/excellon/vision/vision.h"
#include <fmt/format.h>

namespace panelcal::excellon {

void VisionSession::store_under(const Block& block, int label) {
  if (refuse_replayed_in_part(block.line, block.column)) return;
  memory_.start_recording(label);
}

void VisionSession::rewind(const Block& block, int label) {
  refuse_unfinished(block.line, block.text);
  if (refuse_replayed_in_part(block.line, block.column)) return;
  if (memory_.rewind(label)) {
    rewind_line_ = block.line;
    has_advanced_ = false;
    return;
  }
  reporter_.report(Code::LabelUnknown, block, fmt::format("M50,{} earlier in the program", label));
  measuring_.stop();
}

bool VisionSession::is_rewound(const Block& block) {
  refuse_unfinished(block.line, block.text);
  if (memory_.is_rewound()) return true;
  reporter_.report(Code::RewindMissing, block, "M51,# before it");
  measuring_.stop();
  return false;
}

void VisionSession::report_exhausted(const Block& block, int n_points, int n_left) {
  reporter_.report(Code::PointsExhausted,
                   block,
                   fmt::format(" asks for {} stored points, {} left", n_points, n_left),
                   "no more points than were measured under M50");
  measuring_.stop();
}

std::optional<CorrectionMemory::Advance> VisionSession::pass_points(const Block& block,
                                                                    int n_points) {
  if (!is_rewound(block)) return std::nullopt;
  const int left = memory_.points_left();
  CorrectionMemory::Advance step = memory_.advance(n_points);
  if (step.beyond_end) {
    report_exhausted(block, n_points, left);
    return std::nullopt;
  }
  advance_line_ = block.line;
  has_advanced_ = true;
  return step;
}

void VisionSession::advance(const Block& block, int n_points, const Placement* placement) {
  const auto step = pass_points(block, n_points);
  if (!step) return;
  for (const std::size_t i_series : step->passed) {
    const SeriesResult& series = measuring_.series(i_series);
    if (placement != nullptr && !is_same_place(series.placement, *placement)) {
      reporter_.report(Code::StoredElsewhere,
                       block,
                       fmt::format(" comes to the correction of path [{}], which was measured in "
                                   "line {} on another board than this one",
                                   fmt::join(series.path, ","),
                                   series.line),
                       "copies in the same order as under M50");
      measuring_.stop();
      return;
    }
    measuring_.activate(i_series, block.line);
  }
}

// --- kept for translation ----------------------------------------------------------------------

void VisionSession::refuse_kept(int line, int column, std::string what, std::string expected) {
  reporter_.report(Code::NotSupported,
                   line,
                   column,
                   std::move(what) + ", which has no form in a translation",
                   std::move(expected));
  measuring_.stop();
}

/// A translation writes the copies out where they begin with different tools.
void VisionSession::refuse_written_out(int line, int column, const std::string& text) {
  refuse_kept(line,
              column,
              text + " belongs to a pattern whose copies are written out",
              "T# ahead of everything else in the pattern, M02 without T#, at most 10,000 copies");
}

/// One pass through a pattern stands for all its copies, so that the memory has the points of one.
std::optional<StoredCorrection> VisionSession::keep_stored(const Block& block,
                                                           Command command,
                                                           int number) {
  const bool is_advance = command == Command::AdvanceCorrections;
  if (is_in_section_ && !is_advance) {
    refuse_kept(block.line,
                block.column,
                quoted(block.text) + " stands in a pattern",
                code_text(command) + " before M25");
    return std::nullopt;
  }
  if (command == Command::StoreCorrections) {
    kept_.erase(number);
    kept_copies_.erase(number);
    recorded_label_ = number;
    awaits_pattern_ = true;
    store_under(block, number);
    return StoredCorrection{StoredCorrectionKind::RecordNext, number, {}, 0};
  }
  if (command == Command::RewindCorrections) {
    rewind(block, number);
    rewound_label_ = number;
    kept_pointer_ = n_used_ = 0;
    is_used_in_part_ = false;
    return StoredCorrection{StoredCorrectionKind::RewindNext, number, {}, 0};
  }
  if (!is_in_kept_pattern_) return keep_replay(block, number);
  const auto step = pass_points(block, number);
  const auto kept = kept_.find(rewound_label_);
  if (!step || kept == kept_.end()) return std::nullopt;
  is_used_in_part_ = memory_.points_left() > 0;
  if (is_used_in_part_) return std::nullopt;
  StoredCorrection use = kept->second;
  use.kind = StoredCorrectionKind::Use;
  use.n_passed = use.n_targets;
  return use;
}

/// M52 where each place has its own line: the points of all copies follow each other.
std::optional<StoredCorrection> VisionSession::keep_replay(const Block& block, int n_points) {
  if (!is_rewound(block)) return std::nullopt;
  const auto kept = kept_.find(rewound_label_);
  if (kept == kept_.end()) return std::nullopt;
  const int n_targets = kept->second.n_targets;
  const int n_left = n_targets * kept_copies_[rewound_label_] - kept_pointer_;
  if (n_points > n_left) {
    report_exhausted(block, n_points, n_left);
    return std::nullopt;
  }
  advance_line_ = block.line;
  has_advanced_ = true;
  kept_pointer_ += n_points;
  // The memory has the points of one copy: they stand for the last one's.
  if (n_points == n_left) memory_.advance(memory_.points_left());
  is_used_in_part_ = kept_pointer_ % n_targets != 0;
  if (is_used_in_part_) return std::nullopt;
  StoredCorrection use = kept->second;
  use.kind = StoredCorrectionKind::Use;
  use.copy = kept_pointer_ / n_targets;
  use.n_passed = kept_pointer_ - std::exchange(n_used_, kept_pointer_);
  return use;
}

void VisionSession::end_kept_pattern(std::size_t n_copies) {
  is_in_kept_pattern_ = false;
  if (memory_.is_recording()) kept_copies_[recorded_label_] = static_cast<int>(n_copies);
}

/// A copy's offset (G45) goes into the same location as its own base correction.
std::optional<StoredCorrection> VisionSession::keep_series(const TargetPlace& target,
                                                           int n_targets) {
  if (!memory_.is_recording()) return std::nullopt;
  const CorrectionLevel level = level_of(target.command);
  const bool is_offset = level == CorrectionLevel::Nested && n_targets == 1;
  const StoredCorrection keep{
      StoredCorrectionKind::Keep, recorded_label_, level, n_targets, is_offset};
  const std::string command = quoted(code_text(target.command));
  if (is_in_section_ && !is_in_kept_pattern_) {
    refuse_written_out(target.line, 1, command);
    return std::nullopt;
  }
  const auto [kept, is_first] = kept_.try_emplace(recorded_label_, keep);
  const bool adds_offset = is_offset && kept->second.level == CorrectionLevel::Base;
  if (!is_in_section_ || (!is_first && !adds_offset)) {
    refuse_kept(target.line,
                1,
                fmt::format("{} completes {} under M50,{}",
                            command,
                            is_in_section_ ? "a second series of one copy"
                                           : "a series outside of a pattern",
                            recorded_label_),
                "one series in each copy of a pattern, and G45 behind it");
    return std::nullopt;
  }
  if (level == CorrectionLevel::Nested && fits_otherwise(level, n_targets)) {
    refuse_kept(target.line,
                1,
                command + " completes a nested series whose model is not the manual's",
                "[vision] model = \"stretch\", scale = false");
    return std::nullopt;
  }
  if (!is_first) {
    kept->second.level = level;
    kept->second.is_offset = true;
    ++kept->second.n_targets;
  }
  memory_.store({0, n_targets});
  return kept->second;
}

bool VisionSession::fits_otherwise(CorrectionLevel level, int n_targets) const {
  if (n_targets == 2 && options_.sieb_meyer.fits_scale) return true;
  return level == CorrectionLevel::Nested && n_targets > 1 && options_.chooses_model;
}

// --- ends and refusals -------------------------------------------------------------------------

void VisionSession::end_section(int line) {
  refuse_unfinished(line, "M08");
  if (std::exchange(awaits_pattern_, false) && !measuring_.must_stop()) {
    refuse_written_out(line, 1, fmt::format("\"M50,{}\"", recorded_label_));
  }
  memory_.stop_recording();
  is_in_section_ = false;
  is_at_left_out_board_ = false;
  measuring_.corrections().is_withheld = false;
  refuse_points_left(line, 1);
  rewind_line_ = 0;
}

/// Of all copies, also if structure is kept and the memory has the points of one.
int VisionSession::n_points_left() const {
  const auto copies = kept_copies_.find(rewound_label_);
  const auto kept = kept_.find(rewound_label_);
  if (copies == kept_copies_.end() || kept == kept_.end()) return memory_.points_left();
  if (kept_pointer_ == 0) return memory_.points_left() * copies->second;
  return kept->second.n_targets * copies->second - kept_pointer_;
}

bool VisionSession::refuse_points_left(int line, int column) {
  if (rewind_line_ == 0 || memory_.points_left() == 0 || measuring_.must_stop()) return false;
  reporter_.report(Code::PointsLeft,
                   line,
                   column,
                   fmt::format("{} of the M51 in line {}", n_points_left(), rewind_line_),
                   "as many points advanced by M52 as were measured under M50");
  measuring_.stop();
  return true;
}

/// A replay outside of sections ends at the next M50 or M51, or with the program.
/// "There must be as many M52 commands after an M51 as G36/G46".
bool VisionSession::refuse_replayed_in_part(int line, int column) {
  return !is_in_section_ && has_advanced_ && refuse_points_left(line, column);
}

/// Another correction takes over. Before the last board of a replay M52 goes on behind it.
void VisionSession::end_replay_outside() {
  if (!is_in_section_ && has_advanced_ && memory_.points_left() == 0) rewind_line_ = 0;
}

bool VisionSession::refuse_without_advance(int line) {
  if (rewind_line_ == 0 || has_advanced_) return false;
  reporter_.report(Code::AdvanceMissing,
                   line,
                   fmt::format("coordinate after the M51 in line {}", rewind_line_),
                   "M52,# at the beginning of the pattern");
  measuring_.stop();
  return true;
}

bool VisionSession::refuse_inside_stored(int line) {
  if (!memory_.is_inside_series()) return false;
  reporter_.report(Code::PointerInsideSeries,
                   line,
                   fmt::format("coordinate after the M52 in line {}", advance_line_),
                   "an M52 count that ends where a stored series ends");
  measuring_.stop();
  return true;
}

}  // namespace panelcal::excellon
