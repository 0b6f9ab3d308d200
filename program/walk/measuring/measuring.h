// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/correction/stack.h"
#include "program/walk/measuring/fit_point.h"
#include "program/walk/options.h"
#include "program/walk/reporter.h"
#include "program/walk/survey.h"

namespace panelcal {

/// The corrections in force and which series they came from, as indices into Survey::series.
struct CorrectionState {
  CorrectionStack stack;
  std::optional<std::size_t> base_series;
  std::optional<std::size_t> nested_series;
  /// The copy that is walked is of a board that is left out: nothing of it is worked.
  bool is_withheld = false;
  /// The level whose correction would be in force, had its board not been left out.
  std::optional<CorrectionLevel> unknown;
  /// Of those series; null: no correction.
  std::shared_ptr<const Reliability> base_reliability;
  std::shared_ptr<const Reliability> nested_reliability;

  CorrectionState() = default;
  explicit CorrectionState(const MachineUncertainty& machine) : stack(machine) {}
  void clear_base();
  void clear_nested();
};

/// Two placements carry to the same place, but for rounding: both are sums of the same program's
/// numbers, not always in the same order.
bool is_same_place(const Placement& a, const Placement& b);

/// A hole that is drilled where its own target was seen.
struct TargetHolePlace {
  PositionEstimate<frame::Actual> place;  ///< with the covariance of what is drilled there
  std::size_t i_measurement = 0;
};

/// Several looks at one target, each a point of its own: their mean.
///
/// Precondition: at least one; all by the same camera
FitPoint mean_of_layers(std::span<const FitPoint> layers, const MachineUncertainty& machine);

/// Measures, fits, gates and activates, whatever the language that asks for it.
///
/// With a source it fills the survey (first pass). Without one it takes everything from the survey
/// in the same order (second pass), so that both passes come through the same states.
/// measuring_reports.cc has the diagnostics.
class Measuring {
 public:
  Measuring(const WalkOptions& options,
            Survey& survey,
            MeasurementSource* source,
            const Reporter& reporter,
            DiagnosticLog& log);

  bool is_first_pass() const { return source_ != nullptr; }
  /// Counts all that depends on what the source answers.
  std::int64_t n_steps() const { return n_steps_; }

  /// Looks for one target; `request` lacks its number. Index into Survey::measurements; nothing if
  /// the source failed, which stops the walk. A target of a series that has candidates is not
  /// reported as lost: settle() does, when it knows all of them; fit() reports what a person has
  /// skipped.
  std::optional<std::size_t> measure(MeasurementRequest request, bool is_of_series = false);
  /// Chooses among the candidates of a series' targets, in the first pass; reports those that stay
  /// lost.
  std::optional<SeriesAssignment> settle(std::span<const std::size_t> measurements,
                                         CorrectionLevel level,
                                         int line);
  /// Has the source focus, in the first pass.
  void focus(const MeasurementRequest& request);
  /// Has the source calibrate, in the first pass; the walk stops if that fails. `text` is the
  /// block, for the warning that the source could not.
  ///
  /// In     order: lacks its number
  void calibrate(CalibrationOrder order, int column, std::string_view text);
  /// Warns that an order is not performed, in the first pass.
  void report_not_calibrated(int line, int column, std::string_view text);
  /// True for a line of the file in hand whose order report_not_calibrated has warned of.
  bool is_unperformed(int line) const {
    return survey_.unperformed.contains({reporter_.file(), line});
  }
  /// Asks the source about a series that gates refuse because of a target, in the first pass. True
  /// if that target has another answer now, so that the series has other points.
  ///
  /// In     series, points: as fit() takes them
  bool reconsider(SeriesResult series, std::span<const FitPoint> points);
  const Measurement& measurement(std::size_t i) const { return survey_.measurements[i]; }
  bool is_found(std::size_t i) const { return measurement(i).status == MeasurementStatus::Found; }
  /// Neither found nor left out by a person.
  bool is_lost(std::size_t i) const {
    return !is_found(i) && !panelcal::is_left_out(measurement(i));
  }
  /// The board of a target is left out.
  bool is_of_left_out_board(std::size_t i) const {
    return measurement(i).status == MeasurementStatus::BoardLeftOut;
  }
  FitPoint fit_point(std::size_t i_measurement) const;
  /// Precondition: is_found(i_measurement)
  TargetHolePlace hole_at_target(std::size_t i_measurement) const;

  /// Fits `points` to the model of `series`, whose level, line, path, placement and measurements
  /// are set; without points (a target is missing) there is no fit. Index into Survey::series.
  std::size_t fit(SeriesResult series, std::span<const FitPoint> points);
  const SeriesResult& series(std::size_t i) const { return survey_.series[i]; }
  /// Puts a series' correction in force; stops the walk where there is none to go on with.
  void activate(std::size_t i_series, int line);

  const GateLimits& limits_of(CorrectionLevel level) const {
    return level == CorrectionLevel::Base ? options_.base_limits : options_.nested_limits;
  }
  /// A hole at its own target has no fit to hold against limits, but it may not be farther from its
  /// expected place than a panel may be.
  void gate_hole(const Measurement& measurement, CorrectionLevel level);

  CorrectionState& corrections() { return corrections_; }
  const CorrectionState& corrections() const { return corrections_; }
  /// The next place to look at is unknown, or the source failed.
  bool must_stop() const { return must_stop_; }
  void stop() { must_stop_ = true; }

 private:
  /// Puts WalkOptions::aligned in force.
  void begin_aligned();
  void prepare(SeriesResult& series) const;
  void report_lost(const Measurement& measurement);
  void report_left_out(const SeriesResult& series);
  /// A warning where the others of its series make the fit, else an error.
  void report_skipped(const Measurement& measurement, const SeriesResult& series);
  OffsetUncertainty offset_of(const SeriesResult& series) const;
  void fit_base(std::span<const FitPoint> points, SeriesResult& series);
  void fit_nested(std::span<const FitPoint> points, SeriesResult& series);
  void report_fit_failure(const SeriesResult& series, bool bends);
  void report_nested_on_smooth(const SeriesResult& series);
  static void note_reliability(SeriesResult& series);
  /// Fits and gates; leaves out what the gates allow to, and finds the cause of what does not fit.
  void fit_points(std::span<const FitPoint> points, SeriesResult& series);
  void examine(std::vector<FitPoint> points, SeriesResult& series);
  void report_fault(const SeriesResult& series, std::span<const FitPoint> points);
  void report_dropped(const SeriesResult& series, std::span<const std::string> reasons);
  void report_dropped(const MeasurementRequest& request,
                      const SeriesResult& series,
                      const std::string& reason);
  void report_gates(const SeriesResult& series, std::span<const FitPoint> points);

  const WalkOptions& options_;
  Survey& survey_;
  MeasurementSource* source_;
  const Reporter& reporter_;
  DiagnosticLog& log_;
  CorrectionState corrections_;
  std::size_t n_measured_ = 0;
  std::int64_t n_calibrations_ = 0;
  std::size_t n_fitted_ = 0;
  std::int64_t n_steps_ = 0;
  bool must_stop_ = false;
};

}  // namespace panelcal
