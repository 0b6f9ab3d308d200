// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/measuring/optical.h"

#include <algorithm>
#include <span>
#include <utility>

#include <fmt/format.h>

namespace panelcal::sieb_meyer {

OpticalSession::OpticalSession(Measuring& measuring,
                               const WalkOptions& options,
                               const Reporter& reporter)
    : measuring_(measuring),
      options_(options),
      reporter_(reporter),
      mode_(options.sieb_meyer.measurement_mode),
      pattern_mode_(options.sieb_meyer.pattern_mode),
      tool_(options.sieb_meyer.vision_tool) {
}

// --- measuring ---------------------------------------------------------------------------------

/// A correction that is on says better than the drawing where to look.
Position<frame::Actual> OpticalSession::corrected(const Position<frame::Nominal>& nominal) const {
  return measuring_.corrections().stack.actual_of(nominal);
}

std::optional<std::size_t> OpticalSession::look(const TargetPlace& target,
                                                const Position<frame::Actual>& expected,
                                                ObservedAxes axes,
                                                bool is_of_series) {
  MeasurementRequest request;
  request.line = target.line;
  request.file = target.file;
  request.file_sha256 = target.file_sha256;
  request.command = code_text(target.command);
  request.settings.tools = {tool_};
  request.settings.inspections = options_.inspections;
  request.nominal = target.nominal;
  request.expected = expected;
  request.work_zero = target.work_zero;
  request.path = target.path;
  request.axes = axes;
  ++n_looks_;
  return measuring_.measure(std::move(request), is_of_series);
}

void OpticalSession::measure(const TargetPlace& target) {
  if (requested_) {
    reporter_.report(Code::CommandMisplaced,
                     target.line,
                     fmt::format("{} measures a target behind {}, whose targets may count again",
                                 code_text(target.command),
                                 request_text()),
                     "G31 or G34 before it");
    measuring_.stop();
    return;
  }
  ObservedAxes axes = ObservedAxes::Both;
  if (mode_ == 5) {
    axes = seen_axis(target, target.command == Command::FinishMeasure);
    if (measuring_.must_stop()) return;
  }
  const auto index = look(target, corrected(target.nominal), axes, mode_ == 1);
  if (!index) return;
  if (measurements_.empty()) first_line_ = target.line;
  measurements_.push_back(*index);
  add_point(target, axes, *index);
}

/// A slot shows the program's x or y; where the program is turned, that is another axis of the
/// board.
ObservedAxes OpticalSession::seen_axis(const TargetPlace& target, bool is_x) {
  constexpr double kRounding = 1e-9;
  const Eigen::Vector2d axis = target.placement.linear().col(is_x ? 0 : 1).cwiseAbs();
  if (axis.x() > kRounding && axis.y() > kRounding) {
    reporter_.report(Code::NotSupported,
                     target.line,
                     "a slot is measured in a program that is turned by less than a quarter",
                     "slots along the board's axes (measurement mode 5)");
    measuring_.stop();
  }
  return axis.x() > axis.y() ? ObservedAxes::X : ObservedAxes::Y;
}

void OpticalSession::add_point(const TargetPlace& target,
                               ObservedAxes axes,
                               std::size_t i_measurement) {
  FitPoint point = measuring_.fit_point(i_measurement);
  point.axes = axes;
  const bool finishes = target.command == Command::FinishMeasure;
  switch (mode_) {
    case 2:
    case 3:
      if (layers_.size() == kMostLayers) {
        reporter_.report(Code::SeriesUnfinished,
                         target.line,
                         fmt::format("a target of more than {} layers", kMostLayers),
                         "G33 for its last layer");
        measuring_.stop();
        return;
      }
      layers_.push_back(point);
      if (finishes) close_layers();
      return;
    case 1:
      unsettled_.push_back(points_.size());
      break;
    default:
      break;
  }
  points_.push_back(point);
}

/// Chooses among the candidates of the points that wait.
std::optional<SeriesAssignment> OpticalSession::settle_points() {
  std::vector<std::size_t> measurements;
  for (const std::size_t k : unsettled_) measurements.push_back(points_[k].i_measurement);
  auto assignment = measuring_.settle(measurements, CorrectionLevel::Base, first_line_);
  for (const std::size_t k : std::exchange(unsettled_, {})) {
    points_[k] = measuring_.fit_point(points_[k].i_measurement);
  }
  return assignment;
}

/// One point of all layers: their mean, and how far they are apart.
void OpticalSession::close_layers() {
  for (const FitPoint& layer : layers_) {
    for (const FitPoint& other : layers_) {
      const Eigen::Vector2d apart_mm = (layer.measured.position.in_mm() - layer.nominal.in_mm()) -
                                       (other.measured.position.in_mm() - other.nominal.in_mm());
      spread_mm_ = std::max(spread_mm_, apart_mm.norm());
    }
  }
  points_.push_back(mean_of_layers(layers_, options_.uncertainty));
  layers_.clear();
}

std::optional<TargetHolePlace> OpticalSession::measure_hole(const TargetPlace& target) {
  const auto index = look(target, corrected(target.nominal));
  if (!index || !measuring_.is_found(*index)) return std::nullopt;
  const Measurement& measurement = measuring_.measurement(*index);
  if (measuring_.is_first_pass()) {
    measuring_.gate_hole(measurement, is_on_ ? CorrectionLevel::Nested : CorrectionLevel::Base);
  }
  return measuring_.hole_at_target(*index);
}

/// The pattern's points are looked for where the board's correction puts them, and give one offset
/// on top of it.
void OpticalSession::measure_pattern(const TargetPlace& target) {
  constexpr std::size_t kMostPoints = 2;
  if (pattern_.points.size() == kMostPoints) {
    reporter_.report(Code::CommandMisplaced,
                     target.line,
                     "a third G36 in one pattern",
                     "at most two measuring points in a pattern under CAMA");
    measuring_.stop();
    return;
  }
  const Eigen::Vector2d expected_mm =
      measuring_.corrections().stack.base_of(target.nominal).in_mm();
  const auto index = look(target, position_mm<frame::Actual>(expected_mm));
  if (!index) return;
  pattern_.has_lost |= !measuring_.is_found(*index);
  pattern_.measurements.push_back(*index);
  note_measured(pattern_.measurements);
  pattern_.points.push_back(measuring_.fit_point(*index));
  SeriesResult series = new_series(CorrectionLevel::Nested, target);
  series.measurements = pattern_.measurements;
  series.model = PanelModel::Offset;
  std::vector<FitPoint> points;
  if (!pattern_.has_lost) points = pattern_.points;
  pattern_.nested = measuring_.fit(std::move(series), points);
  measuring_.activate(*pattern_.nested, target.line);
}

// --- corrections -------------------------------------------------------------------------------

SeriesResult OpticalSession::new_series(CorrectionLevel level, const TargetPlace& place) const {
  SeriesResult series;
  series.level = level;
  series.line = level == CorrectionLevel::Base ? first_line_ : place.line;
  series.path = place.path;
  series.placement = place.placement;
  return series;
}

int OpticalSession::n_equations() const {
  int n = 0;
  for (const FitPoint& point : points_) n += point.axes == ObservedAxes::Both ? 2 : 1;
  return n;
}

/// True and an error while G33 has not finished a target.
bool OpticalSession::has_open_layers(std::string_view order, int line) {
  if (layers_.empty()) return false;
  reporter_.report(Code::SeriesUnfinished,
                   line,
                   fmt::format("{} comes after {} layers of a target", order, layers_.size()),
                   "G33 for its last layer");
  measuring_.stop();
  return true;
}

/// Fits the points that wait, and uses them up.
std::size_t OpticalSession::fit_waiting(const TargetPlace& place) {
  SeriesResult series = new_series(CorrectionLevel::Base, place);
  series.assignment = settle_points();
  series.measurements = measurements_;
  const bool has_lost = !std::ranges::all_of(
      series.measurements, [this](std::size_t i) { return measuring_.is_found(i); });
  note_measured(series.measurements);
  const int n = n_equations();
  const PanelModel usual = default_model_of_equations(n, options_.sieb_meyer.fits_scale);
  series.model =
      n <= 2 ? PanelModel::Offset
             : model_at_most(options_.model.value_or(usual), n, options_.sieb_meyer.fits_scale);
  if (spread_mm_ > 0) series.layer_spread = mm(spread_mm_);
  const std::vector<FitPoint> points = std::exchange(points_, {});
  forget_waiting();
  return measuring_.fit(std::move(series),
                        has_lost ? std::span<const FitPoint>() : std::span(points));
}

/// Precondition: base_ is set
void OpticalSession::put_in_force(int line) {
  pattern_.nested.reset();
  is_on_ = true;
  measuring_.activate(*base_, line);
}

/// No later fit counts what was measured until now.
void OpticalSession::forget_waiting() {
  points_.clear();
  measurements_.clear();
  layers_.clear();
  spread_mm_ = 0;
}

void OpticalSession::calculate(const TargetPlace& place) {
  if (has_open_layers("G31", place.line)) return;
  if (points_.empty() && !base_) {
    reporter_.report(
        Code::CorrectionMissing, place.line, "G31 without measurements", "G32 before it");
    measuring_.stop();
    return;
  }
  if (requested_ && base_ != requested_->i_series) {
    reporter_.report(Code::CommandMisplaced,
                     place.line,
                     fmt::format("G31 comes behind {} and a G39,LOAD of other values, of which it "
                                 "may mean either",
                                 request_text()),
                     "G31 or G34 before G39,LOAD");
    measuring_.stop();
    return;
  }
  if (!points_.empty()) base_ = fit_waiting(place);
  requested_.reset();
  put_in_force(place.line);
}

void OpticalSession::turn_off(std::int64_t i_block) {
  const bool is_second = turned_off_in_ && *turned_off_in_ + 1 == i_block;
  turned_off_in_ = i_block;
  ++n_turned_off_;
  if (is_second) return clear();
  is_on_ = false;
  if (requested_) requested_->is_assumed_on = false;
  measuring_.corrections().clear_base();
}

void OpticalSession::clear() {
  settle_points();
  is_on_ = false;
  base_.reset();
  requested_.reset();
  forget_waiting();
  note_measured({});
  pattern_ = {};
  ++n_turned_off_;
  measuring_.corrections().clear_base();
}

void OpticalSession::begin_copy() {
  outer_patterns_.push_back(pattern_);
  outer_patterns_.back().n_turned_off = n_turned_off_;
  pattern_.points.clear();
  pattern_.measurements.clear();
  pattern_.has_lost = false;
}

void OpticalSession::end_copy(int line) {
  const PatternState inner = std::exchange(pattern_, outer_patterns_.back());
  outer_patterns_.pop_back();
  const bool was_turned_off = pattern_.n_turned_off != n_turned_off_;
  if (inner.nested == pattern_.nested && !was_turned_off) return;
  measuring_.corrections().clear_nested();
  const bool is_of_this_base = pattern_.nested && measuring_.series(*pattern_.nested).base_series ==
                                                      measuring_.corrections().base_series;
  if (!is_of_this_base || was_turned_off) {
    pattern_.nested.reset();
    return;
  }
  measuring_.activate(*pattern_.nested, line);
}

void OpticalSession::end_program(int line) {
  if (measurements_.empty() || measuring_.must_stop()) return;
  const MeasurementRequest& first = measuring_.measurement(measurements_.front()).request;
  reporter_.report(Code::SeriesUnfinished,
                   line,
                   fmt::format("no command uses the measurements since line {}{}",
                               first.line,
                               first.file.empty() ? "" : " of " + first.file),
                   "G31 behind the last target");
}

}  // namespace panelcal::sieb_meyer
