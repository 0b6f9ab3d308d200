// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/measuring/optical.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "program/sieb_meyer/measuring/offset_deviation.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

/// Sound holes are refused once in this number of orders to store their offset.
constexpr double kScatterChance = 0.001;

}  // namespace

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
                     1,
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
                         1,
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
                     1,
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

void OpticalSession::calculate(const TargetPlace& place) {
  if (!layers_.empty()) {
    reporter_.report(Code::SeriesUnfinished,
                     place.line,
                     1,
                     fmt::format("G31 comes after {} layers of a target", layers_.size()),
                     "G33 for its last layer");
    measuring_.stop();
    return;
  }
  if (points_.empty() && !base_) {
    reporter_.report(
        Code::CorrectionMissing, place.line, 1, "G31 without measurements", "G32 before it");
    measuring_.stop();
    return;
  }
  if (!points_.empty()) {
    SeriesResult series = new_series(CorrectionLevel::Base, place);
    series.assignment = settle_points();
    series.measurements = std::exchange(measurements_, {});
    const bool has_lost = !std::ranges::all_of(
        series.measurements, [this](std::size_t i) { return measuring_.is_found(i); });
    note_measured(series.measurements);
    const int n = n_equations();
    const PanelModel usual = default_model_of_equations(n, options_.sieb_meyer.fits_scale);
    series.model = n <= 2 ? PanelModel::Offset : options_.model.value_or(usual);
    if (spread_mm_ > 0) series.layer_spread = mm(std::exchange(spread_mm_, 0));
    const std::vector<FitPoint> points = std::exchange(points_, {});
    base_ = measuring_.fit(std::move(series),
                           has_lost ? std::span<const FitPoint>() : std::span(points));
  }
  pattern_.nested.reset();
  is_on_ = true;
  measuring_.activate(*base_, place.line);
}

void OpticalSession::turn_off(std::int64_t i_block) {
  const bool is_second = turned_off_in_ && *turned_off_in_ + 1 == i_block;
  turned_off_in_ = i_block;
  ++n_turned_off_;
  if (is_second) return clear();
  is_on_ = false;
  measuring_.corrections().clear_base();
}

void OpticalSession::clear() {
  settle_points();
  is_on_ = false;
  base_.reset();
  pattern_.nested.reset();
  points_.clear();
  measurements_.clear();
  note_measured({});
  layers_.clear();
  spread_mm_ = 0;
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
  reporter_.report(Code::SeriesUnfinished,
                   line,
                   1,
                   fmt::format("no command uses the measurements since line {}", first_line_),
                   "G31 behind the last target");
}

// --- saved sets --------------------------------------------------------------------------------

bool OpticalSession::organize(const Block& block, int step, const TargetPlace& place) {
  const std::string_view text = block.argument;
  const auto is_word = [&](std::string_view word) { return text.starts_with(word); };
  const auto slot_behind = [&](std::string_view word) -> std::optional<int> {
    const std::string_view number = text.substr(word.size());
    return number.empty() ? std::optional(step) : parse_count(number);
  };
  const auto refuse = [&](std::string expected) {
    reporter_.report(Code::ArgumentInvalid,
                     block.line,
                     block.argument_column,
                     quoted(text),
                     std::move(expected));
    measuring_.stop();
    return false;
  };
  if (text == "DELALL") {
    saved_.clear();
    return false;
  }
  for (const std::string_view word : {"SAVE", "LOAD", "CLEAR"}) {
    if (!is_word(word)) continue;
    const auto slot = slot_behind(word);
    if (!slot) return refuse(std::string(word) + " or " + std::string(word) + "# with a number");
    if (*slot < 1 || *slot > static_cast<int>(kMostSets)) {
      reporter_.report(Code::CorrectionSetsFull,
                       block.line,
                       block.argument_column,
                       fmt::format("{} asks for storage location {}", quoted(block.text), *slot),
                       fmt::format("1 to {}", kMostSets));
      measuring_.stop();
      return false;
    }
    if (word == "SAVE") save(block, *slot, text.size() > word.size(), place);
    if (word == "LOAD") load(block, *slot, place);
    if (word == "CLEAR") saved_.erase(*slot);
    return false;
  }
  if (const auto order = offset_order(text)) return move_offset(block, *order, place);
  if (is_word("SPOF") && parse_count(text.substr(4))) {
    return refuse(fmt::format("SPOF# with a spindle from 1 to {}", kMostSpindles));
  }
  if (text == "REQCOMP") {
    reporter_.report(Code::NotSupported,
                     block.line,
                     block.argument_column,
                     quoted(block.text) + " takes a correction that only the camera computer knows",
                     "G32 and G31");
    measuring_.stop();
    return false;
  }
  return refuse("SAVE, LOAD, CLEAR, DELALL, SPOP, SPOP1, SPOP2, SPISPI, SPOF# or REQCOMP");
}

void OpticalSession::note_measured(std::vector<std::size_t> measurements) {
  last_measurements_ = std::move(measurements);
  last_deviation_.reset();
}

/// True if the deviation that an order stores is one of the offset in force, and is used only once.
bool OpticalSession::may_move_offset(const Block& block) {
  const auto refuse = [&](std::string_view what, std::string expected) {
    reporter_.report(Code::CommandMisplaced,
                     block.line,
                     block.column,
                     fmt::format("{} {}", quoted(block.text), what),
                     std::move(expected));
    measuring_.stop();
    return false;
  };
  const auto has_points = [](const PatternState& pattern) { return !pattern.points.empty(); };
  if (has_points(pattern_) || std::ranges::any_of(outer_patterns_, has_points)) {
    return refuse(
        "comes in the middle of a pattern, whose points would be measured with two offsets",
        "it behind the pattern's copy, or before its first G36");
  }
  const CorrectionState& on = measuring_.corrections();
  if ((on.base_series && is_made_of_last(*on.base_series)) ||
      (on.nested_series && is_made_of_last(*on.nested_series))) {
    return refuse(
        "takes over the measurements of the correction that is on; with both, holes would be "
        "moved by it twice",
        "G30 or G34 before it");
  }
  if (last_deviation_ && n_looks_ != n_looks_at_order_) {
    return refuse("stores a second time the measurement with the offset before that",
                  "all orders for one measurement before the next is made");
  }
  return true;
}

bool OpticalSession::is_made_of_last(std::size_t i_series) const {
  return std::ranges::any_of(measuring_.series(i_series).measurements, [&](std::size_t i) {
    return std::ranges::find(last_measurements_, i) != last_measurements_.end();
  });
}

/// Neither G31 nor G39,LOAD may bring back a correction by what has become the offset's.
void OpticalSession::forget_corrections_of_last() {
  if (base_ && is_made_of_last(*base_)) base_.reset();
  std::erase_if(saved_, [&](const auto& numbered) {
    const SavedSet& set = numbered.second;
    return (set.base && is_made_of_last(*set.base)) || (set.nested && is_made_of_last(*set.nested));
  });
}

/// The mean of what was measured last; absent if nothing was, or if that is no one offset. Sets
/// `is_lost` if a target was not found: that was said, and nothing is drilled.
std::optional<OffsetCorrection> OpticalSession::deviation_of_last(const Block& block,
                                                                  bool& is_lost) {
  std::vector<Measurement> measured;
  for (const std::size_t i : last_measurements_) {
    is_lost |= !measuring_.is_found(i);
    measured.push_back(measuring_.measurement(i));
  }
  if (is_lost) return std::nullopt;
  auto deviation = offset_deviation(measured, options_.uncertainty);
  if (!deviation) {
    reporter_.report(Code::CorrectionMissing,
                     block.line,
                     block.column,
                     quoted(block.text) + " has no measured offset to store",
                     "G32 at a hole that this spindle drilled, before it");
    return std::nullopt;
  }
  const double chance = scatter_chance(measured, options_.uncertainty);
  if (!(chance < kScatterChance)) return deviation;
  reporter_.report(Code::CalibrationRefused,
                   block.line,
                   block.column,
                   fmt::format("{}: the holes measured for it lie farther apart than [uncertainty] "
                               "allows (chance {:.1e}, limit {})",
                               quoted(block.text),
                               chance,
                               kScatterChance),
                   "sound holes that this spindle drilled");
  return std::nullopt;
}

/// The measured target is for the spindle's offset, and no target of the board's any more. The
/// order goes through as well, for the machine's own use.
bool OpticalSession::move_offset(const Block& block,
                                 const OffsetOrder& order,
                                 const TargetPlace& place) {
  settle_points();
  if (!measurements_.empty()) note_measured(std::exchange(measurements_, {}));
  points_.clear();
  layers_.clear();
  spread_mm_ = 0;
  if (!options_.moves_offset) {
    measuring_.report_not_calibrated(block.line, block.column, block.text);
    return true;
  }
  if (!may_move_offset(block)) return false;
  forget_corrections_of_last();
  if (!measuring_.is_first_pass()) return true;
  if (!last_deviation_) {
    bool is_lost = false;
    last_deviation_ = deviation_of_last(block, is_lost);
    n_looks_at_order_ = n_looks_;
    if (is_lost) return true;
  }
  if (!last_deviation_) {
    measuring_.stop();
    return false;
  }
  CalibrationOrder calibration;
  calibration.line = block.line;
  calibration.file = place.file;
  calibration.command = "G39," + std::string(block.argument);
  calibration.path = place.path;
  calibration.correction = *last_deviation_;
  calibration.correction->order = order;
  measuring_.calibrate(std::move(calibration), block.column, block.text);
  return true;
}

void OpticalSession::save(const Block& block, int slot, bool has_number, const TargetPlace& place) {
  if (!base_ && !pattern_.nested) {
    reporter_.report(Code::CorrectionMissing,
                     block.line,
                     block.column,
                     quoted(block.text) + " without a correction to save",
                     "G32 and G31 before it");
    measuring_.stop();
    return;
  }
  saved_[slot] = {base_, pattern_.nested, place.placement, place.copies, has_number, block.line};
}

/// Without a number of its own a set belongs to the copy it was measured on: another structure of
/// sections counts its copies in another order.
void OpticalSession::load(const Block& block, int slot, const TargetPlace& place) {
  const auto found = saved_.find(slot);
  if (found == saved_.end()) {
    reporter_.report(Code::CorrectionMissing,
                     block.line,
                     block.column,
                     fmt::format("{}: location {} is empty", quoted(block.text), slot),
                     "G39,SAVE earlier in the program");
    measuring_.stop();
    return;
  }
  const SavedSet& set = found->second;
  const bool asks_by_step = block.argument == "LOAD";
  const bool is_same = set.copies == place.copies && is_same_place(set.placement, place.placement);
  if (asks_by_step && !set.has_number && !is_same) {
    reporter_.report(
        Code::StoredElsewhere,
        block.line,
        block.column,
        fmt::format("{} takes a set that line {} saved in other sections or at another "
                    "zero",
                    quoted(block.text),
                    set.line),
        "the same sections and offsets as where it was saved");
    measuring_.stop();
    return;
  }
  base_ = set.base;
  pattern_.nested = set.nested;
  is_on_ = true;
  measuring_.corrections().clear_base();
  if (base_) measuring_.activate(*base_, block.line);
  if (pattern_.nested) measuring_.activate(*pattern_.nested, block.line);
}

}  // namespace panelcal::sieb_meyer
