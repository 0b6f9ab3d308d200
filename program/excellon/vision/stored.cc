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
  reporter_.report(Code::LabelUnknown,
                   block.line,
                   block.column,
                   quoted(block.text),
                   fmt::format("M50,{} earlier in the program", label));
  measuring_.stop();
}

std::optional<CorrectionMemory::Advance> VisionSession::pass_points(const Block& block,
                                                                    int n_points) {
  refuse_unfinished(block.line, block.text);
  if (!memory_.is_rewound()) {
    reporter_.report(
        Code::RewindMissing, block.line, block.column, quoted(block.text), "M51,# before it");
    measuring_.stop();
    return std::nullopt;
  }
  const int left = memory_.points_left();
  CorrectionMemory::Advance step = memory_.advance(n_points);
  if (step.beyond_end) {
    reporter_.report(
        Code::PointsExhausted,
        block.line,
        block.column,
        fmt::format("{} asks for {} stored points, {} left", quoted(block.text), n_points, left),
        "no more points than were measured under M50");
    measuring_.stop();
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
                       block.line,
                       block.column,
                       fmt::format("{} comes to the correction of path [{}], which was measured in "
                                   "line {} on another board than this one",
                                   quoted(block.text),
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
  if (is_in_section_ != is_advance) {
    refuse_kept(block.line,
                block.column,
                quoted(block.text) + " stands " + (is_advance ? "outside of" : "in") + " a pattern",
                is_advance ? "M51 before a pattern with the copies of M50, and M52 in it"
                           : code_text(command) + " before M25");
    return std::nullopt;
  }
  if (is_advance && !is_in_kept_pattern_) {
    refuse_written_out(block.line, block.column, quoted(block.text));
    return std::nullopt;
  }
  if (command == Command::StoreCorrections) {
    kept_.erase(number);
    recorded_label_ = number;
    awaits_pattern_ = true;
    store_under(block, number);
    return StoredCorrection{StoredCorrectionKind::RecordNext, number, {}, 0};
  }
  if (command == Command::RewindCorrections) {
    rewind(block, number);
    rewound_label_ = number;
    return StoredCorrection{StoredCorrectionKind::RewindNext, number, {}, 0};
  }
  const auto step = pass_points(block, number);
  const auto kept = kept_.find(rewound_label_);
  if (!step || step->passed.empty() || kept == kept_.end()) return std::nullopt;
  StoredCorrection use = kept->second;
  use.kind = StoredCorrectionKind::Use;
  return use;
}

std::optional<StoredCorrection> VisionSession::keep_series(const TargetPlace& target,
                                                           int n_targets) {
  if (!memory_.is_recording()) return std::nullopt;
  const StoredCorrection keep{
      StoredCorrectionKind::Keep, recorded_label_, level_of(target.command), n_targets};
  const std::string command = quoted(code_text(target.command));
  if (is_in_section_ && !is_in_kept_pattern_) {
    refuse_written_out(target.line, 1, command);
    return std::nullopt;
  }
  if (!is_in_section_ || !kept_.try_emplace(recorded_label_, keep).second) {
    refuse_kept(target.line,
                1,
                fmt::format("{} completes {} under M50,{}",
                            command,
                            is_in_section_ ? "a second series of one copy"
                                           : "a series outside of a pattern",
                            recorded_label_),
                "one series in each copy of a pattern");
    return std::nullopt;
  }
  if (keep.level == CorrectionLevel::Nested && n_targets > 1 && fits_otherwise(n_targets)) {
    refuse_kept(target.line,
                1,
                command + " completes a nested series whose model is not the manual's",
                "[vision] model = \"stretch\", scale = false");
    return std::nullopt;
  }
  memory_.store({0, n_targets});
  return keep;
}

/// The one fit that stands for the board's and the copy's in another language has both only if they
/// are of the models that the manuals state.
bool VisionSession::fits_otherwise(int n_targets) const {
  return options_.chooses_model || (n_targets == 2 && options_.sieb_meyer.fits_scale);
}

// --- ends and refusals -------------------------------------------------------------------------

void VisionSession::end_section(int line) {
  refuse_unfinished(line, "M08");
  if (std::exchange(awaits_pattern_, false) && !measuring_.must_stop()) {
    refuse_written_out(line, 1, fmt::format("\"M50,{}\"", recorded_label_));
  }
  memory_.stop_recording();
  is_in_section_ = false;
  refuse_points_left(line, 1);
  rewind_line_ = 0;
}

bool VisionSession::refuse_points_left(int line, int column) {
  if (rewind_line_ == 0 || memory_.points_left() == 0 || measuring_.must_stop()) return false;
  reporter_.report(Code::PointsLeft,
                   line,
                   column,
                   fmt::format("{} of the M51 in line {}", memory_.points_left(), rewind_line_),
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
                   1,
                   fmt::format("coordinate after the M51 in line {}", rewind_line_),
                   "M52,# at the beginning of the pattern");
  measuring_.stop();
  return true;
}

bool VisionSession::refuse_inside_stored(int line) {
  if (!memory_.is_inside_series()) return false;
  reporter_.report(Code::PointerInsideSeries,
                   line,
                   1,
                   fmt::format("coordinate after the M52 in line {}", advance_line_),
                   "an M52 count that ends where a stored series ends");
  measuring_.stop();
  return true;
}

}  // namespace panelcal::excellon
