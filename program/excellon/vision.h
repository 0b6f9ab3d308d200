// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "panelcal/calib/correction_memory.h"
#include "panelcal/calib/correction_stack.h"
#include "panelcal/program/excellon/lexer.h"
#include "panelcal/program/excellon/reporter.h"
#include "panelcal/program/survey.h"
#include "panelcal/program/walk.h"

namespace panelcal::excellon {

/// A target as the program names it.
struct TargetPlace {
  Command command = Command::BaseSeries;
  int line = 0;
  std::string file;  ///< of a stored pattern; empty: the program itself
  InstancePath path;
  Position<frame::Nominal> nominal;
  Placement placement;
  Position<frame::Machine> work_zero;
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
  void keyboard_order(const SourceLine& line, const NumberFormat& format);  // $uvis
  void measure_target(const TargetPlace& target);                           // G35 G36 G45 G46
  std::optional<PositionEstimate<frame::Actual>> measure_hole(const TargetPlace& target);
  void cancel_base(int line);                                                  // G37
  void cancel_nested(int line);                                                // G47
  void store_under(int label);                                                 // M50
  void rewind(const Block& block, int label);                                  // M51
  void advance(const Block& block, int n_points, const Placement& placement);  // M52
  void begin_instance() { has_advanced_ = false; }
  void end_instance(int line);
  void end_section(int line);  // M08

  /// Reports what forbids a hole here; once for each cause.
  bool is_ready_to_drill(int line) {
    return (!open_ && rewind_line_ == 0 && !memory_.is_inside_series()) || is_allowed(line);
  }
  /// Reports a series that the end of the program leaves unfinished.
  void end_program(int line);
  bool is_unused() const;
  bool must_stop() const { return must_stop_; }
  const CorrectionStack& corrections() const { return stack_; }
  /// Which series the corrections in force came from, as indices into Survey::series.
  const std::optional<std::size_t>& base_series() const { return base_series_; }
  const std::optional<std::size_t>& nested_series() const { return nested_series_; }

 private:
  struct OpenSeries {
    CorrectionLevel level = CorrectionLevel::Base;
    int line = 0;
    int n_wanted = 0;
    std::string command;
    std::vector<std::size_t> measurements;
  };

  std::optional<std::size_t> measure(const TargetPlace& target, CorrectionLevel level);
  void report_lost(const Measurement& measurement);
  void complete(const TargetPlace& target);
  SeriesResult fit(const OpenSeries& open, const TargetPlace& target);
  void fit_base(const OpenSeries& open, SeriesResult& series);
  void fit_nested(const OpenSeries& open, SeriesResult& series);
  void report_fit_failure(const SeriesResult& series, FitFailure failure);
  void report_mirrored(const SeriesResult& series);
  void report_gates(const SeriesResult& series);
  void activate(std::size_t i_series, int line);
  bool refuse_unfinished(int line, std::string_view command);
  bool refuse_inside_stored(int line);
  bool refuse_without_advance(int line);
  bool is_allowed(int line);
  void gate_hole(const Measurement& measurement, CorrectionLevel level);
  void set_uvis(std::string_view key,
                std::string_view value,
                const SourceLine& line,
                const NumberFormat& format);
  void check_order_for_machine(std::string_view key,
                               std::string_view value,
                               const SourceLine& line,
                               const NumberFormat& format);
  template <class Number>
  bool read_number(std::string_view text,
                   Number least,
                   const SourceLine& line,
                   std::optional<Number>& out);
  void bad_argument(int line, int column, std::string_view text, std::string expected);

  const WalkOptions& options_;
  Survey& survey_;
  MeasurementSource* source_;
  const Reporter& reporter_;
  DiagnosticLog& log_;

  VisionSettings settings_;
  int series_size_;
  std::optional<OpenSeries> open_;
  CorrectionStack stack_;
  CorrectionMemory memory_;
  std::optional<std::size_t> base_series_;
  std::optional<std::size_t> nested_series_;
  int advance_line_ = 0;
  int rewind_line_ = 0;        ///< of the M51 that this section replays; 0: none
  bool has_advanced_ = false;  ///< an M52 came in this instance
  std::size_t n_measured_ = 0;
  std::size_t n_fitted_ = 0;
  bool must_stop_ = false;
};

}  // namespace panelcal::excellon
