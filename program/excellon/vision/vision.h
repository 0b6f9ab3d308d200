// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/correction/memory.h"
#include "program/excellon/text/lexer.h"
#include "program/model/operation.h"
#include "program/walk/measuring/measuring.h"
#include "program/walk/options.h"
#include "program/walk/reporter.h"

namespace panelcal::excellon {

/// G45, G46, G48 and G47: relative to the base correction.
CorrectionLevel level_of(Command command);

/// A target as the program names it.
struct TargetPlace {
  Command command = Command::BaseSeries;
  int line = 0;
  std::string file;  ///< of a stored pattern; empty: the program itself
  std::string file_sha256;
  InstancePath path;
  Position<frame::Nominal> nominal;
  Placement placement;
  Position<frame::Machine> work_zero;
  bool is_worked_before = false;  ///< the copy has drilled or routed ahead of it
};

/// The vision state of one walk: settings, the series being measured, the corrections in force and
/// those stored under labels.
///
/// With a source it measures, fits and gates, and fills the survey (first pass). Without one it
/// takes everything from the survey in the same order (second pass), so that both passes come
/// through the same states.
/// Source CNC-7 manual, Vision Assist Commands
class VisionSession {
 public:
  VisionSession(const WalkOptions& options,
                Survey& survey,
                MeasurementSource* source,
                const Reporter& reporter,
                DiagnosticLog& log);

  void select_tool(const Block& block, const NumberFormat& format);  // G34
  /// The caller passes the order on as well: lamp, zoom and the like are the machine's too.
  void keyboard_order(const SourceLine& line,
                      const NumberFormat& format,
                      const TargetPlace& place);   // $uvis
  void measure_target(const TargetPlace& target);  // G35 G36 G45 G46
  /// True for an order in this line to calibrate or to focus that was not performed.
  bool is_unperformed(int line) const { return measuring_.is_unperformed(line); }
  /// G39, $uvis,calib. The offset must not change in the middle of a series.
  void calibrate(CalibrationOrder order, int column, std::string_view text);
  /// If structure is kept, nothing is measured: gives the targets of the series that this one
  /// completes, none while it is unfinished.
  std::vector<Position<frame::Nominal>> take_target(const TargetPlace& target);
  /// Reports what forbids a hole at its own target here (G38, G48).
  bool may_drill_at_target(const TargetPlace& target);
  std::optional<TargetHolePlace> measure_hole(const TargetPlace& target);
  void cancel_base(int line);                       // G37
  void cancel_nested(int line);                     // G47
  void store_under(const Block& block, int label);  // M50
  void rewind(const Block& block, int label);       // M51
  /// M52. The placement is the copy's or the stored pattern's, where the series must have been
  /// measured; null in the program itself, which places each board by its own coordinates.
  void advance(const Block& block, int n_points, const Placement* placement);
  /// Targets of a series (`$uvis,alg`).
  int series_size() const { return series_size_; }
  /// If structure is kept: the pattern that runs is passed on as one.
  void begin_kept_pattern() {
    is_in_kept_pattern_ = true;
    awaits_pattern_ = false;
  }
  void end_kept_pattern(std::size_t n_copies);
  /// M50, M51 and M52 if structure is kept; what the other control is to do, if anything.
  std::optional<StoredCorrection> keep_stored(const Block& block, Command command, int number);
  /// Behind a series that is complete, if structure is kept: whether it is to be stored.
  std::optional<StoredCorrection> keep_series(const TargetPlace& target, int n_targets);
  /// The other control would fit another model: to two targets a scale as well, or, to a nested
  /// series, one fit for the board's and the copy's, which has both only if they are of the models
  /// that the manuals state.
  bool fits_otherwise(CorrectionLevel level, int n_targets) const;
  void begin_instance(const Placement& placement) {
    // A replay outside of sections that has used all points is over where a section begins.
    if (!is_in_section_ && has_advanced_ && memory_.points_left() == 0) rewind_line_ = 0;
    if (!is_in_section_) n_series_before_ = n_series_;
    is_at_left_out_board_ = std::ranges::any_of(
        left_out_, [&](const Placement& board) { return is_same_place(board, placement); });
    is_in_section_ = true;
    has_advanced_ = false;
    measuring_.corrections().is_withheld = false;
  }
  void end_instance(int line);
  void end_section(int line);  // M08

  /// Nothing forbids a hole, wherever it is.
  bool may_drill() const {
    return !open_ && rewind_line_ == 0 && !memory_.is_inside_series() && !is_uncorrected();
  }
  /// Reports what forbids a hole here; once for each cause.
  bool is_ready_to_drill(int line) { return may_drill() || is_allowed(line); }
  /// Reports a series that the end of the program leaves unfinished.
  void end_program(int line);
  bool is_unused() const;
  bool has_open_series() const { return open_.has_value(); }
  void stop() { measuring_.stop(); }
  bool must_stop() const { return measuring_.must_stop(); }
  std::int64_t n_steps() const { return measuring_.n_steps(); }
  const CorrectionState& corrections() const { return measuring_.corrections(); }

 private:
  struct OpenSeries {
    CorrectionLevel level = CorrectionLevel::Base;
    int line = 0;
    int n_wanted = 0;
    std::string command;
    std::vector<std::size_t> measurements;
    std::vector<Position<frame::Nominal>> targets;  ///< the series' targets if structure is kept

    int n_left() const {
      return n_wanted - static_cast<int>(std::max(measurements.size(), targets.size()));
    }
  };

  void open_series(const TargetPlace& target);
  std::optional<std::size_t> measure(const TargetPlace& target,
                                     CorrectionLevel level,
                                     bool is_of_series);
  void cancel(CorrectionLevel level);
  void complete(const TargetPlace& target);
  std::vector<FitPoint> points_of(const OpenSeries& open) const;
  bool leaves_board_out(const OpenSeries& open, const TargetPlace& target) const;
  /// Reports a board that one section leaves out and another one works.
  bool refuse_left_out_in_part(const SeriesResult& series);
  /// The correction that would be in force is of a board that was left out, or the copy stands
  /// where an earlier section has left one out.
  bool is_uncorrected() const {
    const CorrectionState& state = measuring_.corrections();
    return (state.unknown || is_at_left_out_board_) && !state.is_withheld;
  }
  bool refuse_uncorrected(int line);
  bool refuse_unfinished(int line, std::string_view command);
  bool refuse_inside_stored(int line);
  bool refuse_without_advance(int line);
  std::optional<CorrectionMemory::Advance> pass_points(const Block& block, int n_points);
  std::optional<StoredCorrection> keep_replay(const Block& block, int n_points);
  bool is_rewound(const Block& block);
  void report_exhausted(const Block& block, int n_points, int n_left);
  void refuse_kept(int line, int column, std::string what, std::string expected);
  void refuse_written_out(int line, int column, const std::string& text);
  int n_points_left() const;
  bool refuse_points_left(int line, int column);
  bool refuse_replayed_in_part(int line, int column);
  void end_replay_outside();
  bool is_allowed(int line);
  /// False if `key` is not one of the orders that set how the camera is to look.
  bool set_uvis(std::string_view key,
                std::string_view value,
                const SourceLine& line,
                const NumberFormat& format);
  void focus(std::string_view value,
             const SourceLine& line,
             const NumberFormat& format,
             const Position<frame::Machine>& work_zero);
  void refuse_unknown(std::string_view key, const SourceLine& line);
  template <class Number>
  bool read_number(std::string_view text,
                   Number least,
                   const SourceLine& line,
                   std::optional<Number>& out);
  void bad_argument(int line, int column, std::string_view text, std::string expected);

  const WalkOptions& options_;
  const Reporter& reporter_;
  Measuring measuring_;

  VisionSettings settings_;
  int series_size_;
  std::optional<OpenSeries> open_;
  CorrectionMemory memory_;
  int advance_line_ = 0;
  bool is_in_section_ = false;
  std::size_t n_series_ = 0;           ///< of the survey, as far as the walk has come
  std::size_t n_series_before_ = 0;    ///< and where the section began
  std::vector<Placement> left_out_;    ///< of boards that are left out
  bool is_at_left_out_board_ = false;  ///< an earlier copy at the place of this one was left out
  bool is_in_kept_pattern_ = false;
  bool awaits_pattern_ = false;           ///< M50 came, and no pattern that is kept
  int recorded_label_ = 0;                ///< of the last M50; structure kept
  int rewound_label_ = 0;                 ///< of the last M51; structure kept
  std::map<int, StoredCorrection> kept_;  ///< by label: of every copy; structure kept
  std::map<int, int> kept_copies_;        ///< by label; structure kept
  int kept_pointer_ = 0;          ///< points passed since M51, of all copies; structure kept
  int n_used_ = 0;                ///< of them, up to the last correction that was passed on
  bool is_used_in_part_ = false;  ///< the last copy's corrections
  int rewind_line_ = 0;           ///< of the M51 that is replayed, here or in this section; 0: none
  bool has_advanced_ = false;     ///< an M52 came in this instance, or outside of sections
};

}  // namespace panelcal::excellon
