// SPDX-License-Identifier: Apache-2.0
// Corrections stored under labels: M50, M51, M52.
#include <utility>

#include "program/excellon/vision/vision.h"
#include <fmt/format.h>

namespace panelcal::excellon {

void VisionSession::store_under(int label) {
  memory_.start_recording(label);
}

void VisionSession::rewind(const Block& block, int label) {
  refuse_unfinished(block.line, block.text);
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

void VisionSession::advance(const Block& block, int n_points, const Placement& placement) {
  refuse_unfinished(block.line, block.text);
  if (!memory_.is_rewound()) {
    reporter_.report(
        Code::RewindMissing, block.line, block.column, quoted(block.text), "M51,# before it");
    measuring_.stop();
    return;
  }
  const int left = memory_.points_left();
  const CorrectionMemory::Advance step = memory_.advance(n_points);
  if (step.beyond_end) {
    reporter_.report(
        Code::PointsExhausted,
        block.line,
        block.column,
        fmt::format("{} asks for {} stored points, {} left", quoted(block.text), n_points, left),
        "no more points than were measured under M50");
    measuring_.stop();
    return;
  }
  advance_line_ = block.line;
  has_advanced_ = true;
  for (const std::size_t i_series : step.passed) {
    const SeriesResult& series = measuring_.series(i_series);
    // Outside of a section the program places each board by its own coordinates.
    if (is_in_section_ && !is_same_place(series.placement, placement)) {
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

void VisionSession::end_section(int line) {
  refuse_unfinished(line, "M08");
  memory_.stop_recording();
  is_in_section_ = false;
  const int rewind_line = std::exchange(rewind_line_, 0);
  if (rewind_line == 0 || memory_.points_left() == 0 || measuring_.must_stop()) return;
  reporter_.report(Code::PointsLeft,
                   line,
                   1,
                   fmt::format("{} of the M51 in line {}", memory_.points_left(), rewind_line),
                   "as many points advanced by M52 as were measured under M50");
  measuring_.stop();
}

/// A replay outside of sections has no M08 at its end: it ends where another correction takes over.
void VisionSession::end_replay_outside() {
  if (!is_in_section_ && has_advanced_) rewind_line_ = 0;
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
