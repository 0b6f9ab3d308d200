// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/excellon/vision.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>
#include <utility>

#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

bool is_nested(Command command) {
  return command == Command::NestedOffset || command == Command::NestedSeries ||
         command == Command::NestedHoleAtTarget;
}

bool is_single(Command command) {
  return command == Command::BaseOffset || command == Command::NestedOffset;
}

std::string code_text(Command command) {
  return fmt::format("{}{:02}", info(command).letter, info(command).number);
}

std::vector<std::string_view> split_at_commas(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto comma = text.find(',');
    parts.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    text.remove_prefix(comma + 1);
  }
}

/// Both are sums of the same program's numbers, but not always in the same order.
bool is_same_place(const Placement& a, const Placement& b) {
  constexpr double kRounding_mm = 1e-6;
  return a.linear() == b.linear() && (a.translation() - b.translation()).norm() < kRounding_mm;
}

bool is_mirrored(const Eigen::Matrix2d& linear) {
  return linear(0, 0) * linear(1, 1) - linear(0, 1) * linear(1, 0) <= 0;
}

Code lost_code(MeasurementStatus status) {
  switch (status) {
    case MeasurementStatus::Ambiguous:
      return Code::TargetAmbiguous;
    case MeasurementStatus::Rejected:
      return Code::TargetRejected;
    default:
      return Code::TargetNotFound;
  }
}

}  // namespace

VisionSession::VisionSession(const WalkOptions& options,
                             Survey& survey,
                             MeasurementSource* source,
                             const Reporter& reporter,
                             DiagnosticLog& log)
    : options_(options),
      survey_(survey),
      source_(source),
      reporter_(reporter),
      log_(log),
      series_size_(options.series_size) {
}

void VisionSession::bad_argument(int line,
                                 int column,
                                 std::string_view text,
                                 std::string expected) {
  reporter_.report(Code::ArgumentInvalid, line, column, quoted(text), std::move(expected));
}

void VisionSession::select_tool(const Block& block, const NumberFormat& format) {
  const std::vector<std::string_view> parts = split_at_commas(block.arguments);
  const std::size_t n = parts.size();
  const bool has_delta = n == 2 || n == 5;
  if (block.arguments_column == 0 || (n != 1 && !has_delta)) {
    return bad_argument(
        block.line, block.column, block.text, "G34,v1 or G34,v1,delta or G34,v1,v2,v3,v4,delta");
  }
  const auto column_of = [&](std::string_view part) {
    return block.arguments_column + static_cast<int>(part.data() - block.arguments.data());
  };
  VisionSettings chosen = settings_;
  chosen.tools.clear();
  chosen.delta.reset();
  for (std::size_t i = 0; i < n - (has_delta ? 1 : 0); ++i) {
    const auto tool = parse_count(parts[i]);
    if (!tool || *tool < 1) {
      return bad_argument(block.line, column_of(parts[i]), parts[i], "a vision tool from 1");
    }
    chosen.tools.push_back(*tool);
  }
  if (has_delta) {
    const ParsedLength delta = parse_length(parts.back(), format);
    if (delta.fault != NumberFault::None || !(delta.value > Length())) {
      return bad_argument(block.line,
                          column_of(parts.back()),
                          parts.back(),
                          "the distance of the four views, above zero");
    }
    chosen.delta = delta.value;
  }
  settings_ = std::move(chosen);
}

template <class Number>
bool VisionSession::read_number(std::string_view text,
                                Number least,
                                const SourceLine& line,
                                std::optional<Number>& out) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !(value >= least) ||
      !std::isfinite(static_cast<double>(value))) {
    bad_argument(line.number,
                 static_cast<int>(text.data() - line.text.data()) + 1,
                 text,
                 fmt::format("a number from {}", least));
    return false;
  }
  out = value;
  return true;
}

void VisionSession::keyboard_order(const SourceLine& line, const NumberFormat& format) {
  const auto begin = line.text.find('$');
  const std::string_view text =
      line.text.substr(begin, line.text.find_last_not_of(" \t") + 1 - begin);
  const int column = static_cast<int>(begin) + 1;
  constexpr std::string_view kPrefix = "$uvis,";
  if (!text.starts_with(kPrefix)) {
    reporter_.report(Code::CommandUnknown, line.number, column, quoted(text), "$uvis,...");
    return;
  }
  const std::string_view rest = text.substr(kPrefix.size());
  const auto comma = rest.find(',');
  const std::string_view key = rest.substr(0, comma);
  const std::string_view value =
      comma == std::string_view::npos ? rest.substr(rest.size()) : rest.substr(comma + 1);
  set_uvis(key, value, line, format);
}

void VisionSession::set_uvis(std::string_view key,
                             std::string_view value,
                             const SourceLine& line,
                             const NumberFormat& format) {
  const int value_column = static_cast<int>(value.data() - line.text.data()) + 1;
  const auto is_switch = [&] {
    if (value == "on" || value == "off") return true;
    bad_argument(line.number, value_column, value, "on or off");
    return false;
  };
  if (key == "search") {
    if (is_switch()) settings_.search = value == "on";
  } else if (key == "auto" || key == "box" || key == "entry") {
    is_switch();
  } else if (key == "searcharea") {
    read_number(value, 0.0, line, settings_.search_area);
  } else if (key == "lamp") {
    read_number(value, 0.0, line, settings_.lamp);
  } else if (key == "zoom") {
    read_number(value, 0.0, line, settings_.zoom);
  } else if (key == "insp") {
    std::optional<int> n;
    if (read_number(value, 1, line, n)) settings_.inspections = *n;
  } else if (key == "alg") {
    const auto comma = value.find(',');
    std::optional<int> algorithm;
    std::optional<int> n;
    if (comma == std::string_view::npos) {
      bad_argument(line.number, value_column, value, "$uvis,alg,algorithm,fiducials");
    } else if (read_number(value.substr(0, comma), 0, line, algorithm) &&
               read_number(value.substr(comma + 1), 1, line, n)) {
      settings_.algorithm = algorithm;
      series_size_ = *n;
    }
  } else {
    check_order_for_machine(key, value, line, format);
  }
}

/// The orders that set nothing here: focus and calib; anything else is none.
void VisionSession::check_order_for_machine(std::string_view key,
                                            std::string_view value,
                                            const SourceLine& line,
                                            const NumberFormat& format) {
  const auto column_of = [&](std::string_view part) {
    return static_cast<int>(part.data() - line.text.data()) + 1;
  };
  if (key == "calib" || key == "focus") {
    // `xy`, `x1.5y2`: lower case, otherwise a coordinate like any other.
    const auto y = value.find('y');
    const bool is_place = value.starts_with('x') && y != std::string_view::npos &&
                          parse_length(value.substr(1, y - 1), format).fault == NumberFault::None &&
                          parse_length(value.substr(y + 1), format).fault == NumberFault::None;
    if (key == "calib" ? !value.empty() : !is_place) {
      bad_argument(line.number,
                   column_of(value),
                   value,
                   key == "calib" ? "$uvis,calib alone" : "$uvis,focus,x#y#");
    } else if (source_ != nullptr) {
      reporter_.report(Code::CalibrationNotPerformed,
                       line.number,
                       column_of(key) - 6,
                       quoted(line.text) + " is passed on, not performed");
    }
    return;
  }
  constexpr std::array<std::string_view, 11> kKeys = {"auto",
                                                      "box",
                                                      "search",
                                                      "searcharea",
                                                      "entry",
                                                      "insp",
                                                      "focus",
                                                      "lamp",
                                                      "zoom",
                                                      "calib",
                                                      "alg"};
  const std::string_view near = nearest_word(key, kKeys);
  reporter_.report(Code::CommandUnknown,
                   line.number,
                   column_of(key),
                   quoted(key) + " is no $uvis command",
                   near.empty() ? "auto, box, search, searcharea, entry, insp, focus, lamp, zoom, "
                                  "calib or alg"
                                : "perhaps " + std::string(near));
}

bool VisionSession::refuse_unfinished(int line, std::string_view command) {
  if (!open_) return false;
  reporter_.report(Code::SeriesUnfinished,
                   line,
                   1,
                   fmt::format("{} comes after {} of {} targets of the {} series begun in line {}",
                               command,
                               open_->measurements.size(),
                               open_->n_wanted,
                               open_->command,
                               open_->line),
                   fmt::format("{} more {}",
                               open_->n_wanted - static_cast<int>(open_->measurements.size()),
                               open_->command));
  open_.reset();
  return true;
}

std::optional<std::size_t> VisionSession::measure(const TargetPlace& target,
                                                  CorrectionLevel level) {
  const std::size_t index = n_measured_++;
  if (source_ == nullptr) return index;

  if (settings_.tools.empty()) {
    reporter_.report(Code::VisionToolMissing,
                     target.line,
                     1,
                     code_text(target.command) + " measures before any G34",
                     "G34,# with the number of a vision tool");
    must_stop_ = true;
    return std::nullopt;
  }
  MeasurementRequest request;
  request.seq = static_cast<std::int64_t>(index);
  request.line = target.line;
  request.command = code_text(target.command);
  request.settings = settings_;
  request.nominal = target.nominal;
  request.work_zero = target.work_zero;
  request.path = target.path;
  const Eigen::Vector2d expected_mm = level == CorrectionLevel::Nested
                                          ? stack_.base_from_nominal()(target.nominal).in_mm()
                                          : target.nominal.in_mm();
  request.expected = position_mm<frame::Actual>(expected_mm);

  Expected<Measurement> measurement = source_->measure(request);
  // Files keep three numbers of a covariance; with the same three here a replay is exact.
  if (measurement) measurement->measured.cov(1, 0) = measurement->measured.cov(0, 1);
  if (!measurement) {
    log_.add(std::move(measurement).error());
    must_stop_ = true;
    return std::nullopt;
  }
  if (measurement->status != MeasurementStatus::Found) report_lost(*measurement);
  survey_.measurements.push_back(*std::move(measurement));
  return index;
}

void VisionSession::report_lost(const Measurement& measurement) {
  const MeasurementRequest& request = measurement.request;
  reporter_.report(lost_code(measurement.status),
                   request.line,
                   1,
                   fmt::format("{} target {} at nominal ({:.4f}, {:.4f}) mm is {}{}{}",
                               request.command,
                               request.seq,
                               request.nominal.in_mm().x(),
                               request.nominal.in_mm().y(),
                               name(measurement.status),
                               measurement.reason.empty() ? "" : ": ",
                               measurement.reason));
}

void VisionSession::measure_target(const TargetPlace& target) {
  const CorrectionLevel level =
      is_nested(target.command) ? CorrectionLevel::Nested : CorrectionLevel::Base;
  const std::string command = code_text(target.command);
  if (refuse_inside_stored(target.line)) return;
  if (open_ && open_->command != command) refuse_unfinished(target.line, command);
  if (!open_) {
    open_ = OpenSeries{.level = level,
                       .line = target.line,
                       .n_wanted = is_single(target.command) ? 1 : series_size_,
                       .command = command,
                       .measurements = {}};
  }
  const std::optional<std::size_t> index = measure(target, level);
  if (!index) return;
  open_->measurements.push_back(*index);
  if (static_cast<int>(open_->measurements.size()) == open_->n_wanted) complete(target);
}

std::optional<PositionEstimate<frame::Actual>> VisionSession::measure_hole(
    const TargetPlace& target) {
  refuse_unfinished(target.line, code_text(target.command));
  const CorrectionLevel level =
      is_nested(target.command) ? CorrectionLevel::Nested : CorrectionLevel::Base;
  const auto index = measure(target, level);
  if (!index) return std::nullopt;
  const Measurement& measurement = survey_.measurements[*index];
  if (measurement.status != MeasurementStatus::Found) return std::nullopt;
  if (source_ != nullptr) gate_hole(measurement, level);
  return measurement.measured;
}

/// A hole at its own target has no fit to hold against limits, but it may not be farther from its
/// expected place than a panel may be.
void VisionSession::gate_hole(const Measurement& measurement, CorrectionLevel level) {
  const GateLimits& limits =
      level == CorrectionLevel::Base ? options_.base_limits : options_.nested_limits;
  const MeasurementRequest& request = measurement.request;
  const Length offset = mm((measurement.measured.position - request.expected).in_mm().norm());
  if (!limits.offset || offset <= *limits.offset) return;
  reporter_.report(Code::GateFailed,
                   request.line,
                   1,
                   fmt::format("{} target at nominal ({:.4f}, {:.4f}) mm is {:.3f} mm from its "
                               "expected place, limit {:.3f} mm",
                               request.command,
                               request.nominal.in_mm().x(),
                               request.nominal.in_mm().y(),
                               offset.in_mm(),
                               limits.offset->in_mm()));
}

void VisionSession::complete(const TargetPlace& target) {
  const OpenSeries open = *std::exchange(open_, std::nullopt);
  const std::size_t i_series = n_fitted_++;
  if (source_ != nullptr) survey_.series.push_back(fit(open, target));
  memory_.store({i_series, open.n_wanted});
  activate(i_series, target.line);
}

SeriesResult VisionSession::fit(const OpenSeries& open, const TargetPlace& target) {
  SeriesResult series;
  series.level = open.level;
  series.line = open.line;
  series.path = target.path;
  series.placement = target.placement;
  series.measurements = open.measurements;
  series.model = open.n_wanted == 1 ? PanelModel::Offset
                                    : options_.model.value_or(default_model(open.n_wanted));
  const bool all_found = std::ranges::all_of(open.measurements, [&](std::size_t i) {
    return survey_.measurements[i].status == MeasurementStatus::Found;
  });
  if (!all_found) return series;
  if (open.level == CorrectionLevel::Base) {
    fit_base(open, series);
  } else {
    series.base_series = base_series_;
    fit_nested(open, series);
  }
  report_gates(series);
  return series;
}

void VisionSession::fit_base(const OpenSeries& open, SeriesResult& series) {
  std::vector<TargetPair<frame::Base, frame::Nominal>> pairs;
  for (const std::size_t i : open.measurements) {
    const Measurement& m = survey_.measurements[i];
    // Without a nested correction the base frame is the actual one.
    pairs.push_back({m.request.nominal,
                     {position_mm<frame::Base>(m.measured.position.in_mm()), m.measured.cov}});
  }
  auto result = fit_panel<frame::Base, frame::Nominal>(pairs, series.model);
  if (!result.fit) return report_fit_failure(series, result.failure);
  if (is_mirrored(result.fit->map.map.linear())) return report_mirrored(series);
  series.gates = check_gates(*result.fit, options_.base_limits);
  series.base = std::make_shared<const BaseFit>(*std::move(result.fit));
}

void VisionSession::fit_nested(const OpenSeries& open, SeriesResult& series) {
  std::vector<TargetPair<frame::Actual, frame::Base>> pairs;
  for (const std::size_t i : open.measurements) {
    const Measurement& m = survey_.measurements[i];
    pairs.push_back({stack_.base_from_nominal()(m.request.nominal), m.measured});
  }
  auto result = fit_panel<frame::Actual, frame::Base>(pairs, series.model);
  if (!result.fit) return report_fit_failure(series, result.failure);
  if (is_mirrored(result.fit->map.map.linear())) return report_mirrored(series);
  series.gates = check_gates(*result.fit, options_.nested_limits);
  series.nested = std::make_shared<const NestedFit>(*std::move(result.fit));
}

void VisionSession::report_fit_failure(const SeriesResult& series, FitFailure failure) {
  const std::string what = fmt::format("{} targets from line {} do not determine the model \"{}\"",
                                       series.measurements.size(),
                                       series.line,
                                       name(series.model));
  switch (failure) {
    case FitFailure::TooFewTargets:
      reporter_.report(Code::TargetsTooFew,
                       series.line,
                       1,
                       what,
                       fmt::format("at least {} coordinates", parameter_count(series.model)));
      return;
    case FitFailure::Degenerate:
      reporter_.report(Code::SeriesDegenerate,
                       series.line,
                       1,
                       what,
                       "targets that neither coincide nor lie in one line");
      return;
    case FitFailure::BadCovariance:
      reporter_.report(Code::MeasurementInvalid,
                       series.line,
                       1,
                       "a measurement of the series has no usable covariance",
                       "a positive definite matrix");
      return;
  }
}

void VisionSession::report_mirrored(const SeriesResult& series) {
  reporter_.report(Code::PanelMirrored,
                   series.line,
                   1,
                   fmt::format("the {} targets of the series are seen as in a mirror",
                               series.measurements.size()),
                   "the panel the right way up");
}

void VisionSession::report_gates(const SeriesResult& series) {
  for (const GateVerdict& gate : series.gates) {
    if (gate.accepted) continue;
    const Measurement& worst = survey_.measurements[series.measurements[gate.i_target.value_or(0)]];
    const MeasurementRequest& request = worst.request;
    const std::string what = fmt::format("{} ({} {} at nominal ({:.4f}, {:.4f}) mm)",
                                         gate.text(),
                                         request.command,
                                         gate.i_target ? "target" : "series that begins",
                                         request.nominal.in_mm().x(),
                                         request.nominal.in_mm().y());
    reporter_.report(Code::GateFailed, gate.i_target ? request.line : series.line, 1, what);
  }
}

void VisionSession::activate(std::size_t i_series, int line) {
  const SeriesResult& series = survey_.series[i_series];
  if (series.level == CorrectionLevel::Base) {
    if (!series.base) {
      must_stop_ = true;
      return;
    }
    stack_.set_base(series.base);
    base_series_ = i_series;
    return;
  }
  if (!series.nested) return stack_.clear_nested();
  if (series.base_series != base_series_) {
    reporter_.report(
        Code::NestedBaseChanged,
        line,
        1,
        fmt::format("the nested correction measured in line {} was relative to another "
                    "base correction than the one in force",
                    series.line),
        "the base correction it was measured under");
    must_stop_ = true;
    return;
  }
  stack_.set_nested(series.nested);
}

void VisionSession::cancel_base(int line) {
  refuse_unfinished(line, "G37");
  stack_.clear_base();
  base_series_.reset();
}

void VisionSession::cancel_nested(int line) {
  refuse_unfinished(line, "G47");
  stack_.clear_nested();
}

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
                   fmt::format("{}: nothing was stored under label {}", quoted(block.text), label),
                   fmt::format("M50,{} earlier in the program", label));
  must_stop_ = true;
}

void VisionSession::advance(const Block& block, int n_points, const Placement& placement) {
  refuse_unfinished(block.line, block.text);
  if (!memory_.is_rewound()) {
    reporter_.report(Code::RewindMissing,
                     block.line,
                     block.column,
                     quoted(block.text) + " has no pointer to advance",
                     "M51,# before it");
    must_stop_ = true;
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
    must_stop_ = true;
    return;
  }
  advance_line_ = block.line;
  has_advanced_ = true;
  for (const std::size_t i_series : step.passed) {
    const SeriesResult& series = survey_.series[i_series];
    if (!is_same_place(series.placement, placement)) {
      reporter_.report(Code::StoredElsewhere,
                       block.line,
                       block.column,
                       fmt::format("{} comes to the correction of path [{}], which was measured in "
                                   "line {} on another board than this one",
                                   quoted(block.text),
                                   fmt::join(series.path, ","),
                                   series.line),
                       "copies in the same order as under M50");
      must_stop_ = true;
      return;
    }
    activate(i_series, block.line);
  }
}

void VisionSession::end_instance(int line) {
  refuse_unfinished(line, "the end of the pattern");
}

void VisionSession::end_section(int line) {
  refuse_unfinished(line, "M08");
  memory_.stop_recording();
  const int rewind_line = std::exchange(rewind_line_, 0);
  if (rewind_line == 0 || memory_.points_left() == 0 || must_stop_) return;
  reporter_.report(Code::PointsLeft,
                   line,
                   1,
                   fmt::format("{} stored points of the M51 in line {} were not used",
                               memory_.points_left(),
                               rewind_line),
                   "as many points advanced by M52 as were measured under M50");
  must_stop_ = true;
}

bool VisionSession::refuse_without_advance(int line) {
  if (rewind_line_ == 0 || has_advanced_) return false;
  reporter_.report(
      Code::AdvanceMissing,
      line,
      1,
      fmt::format("a coordinate comes after the M51 in line {} without an M52 for this "
                  "board",
                  rewind_line_),
      "M52,# at the beginning of the pattern");
  must_stop_ = true;
  return true;
}

bool VisionSession::is_ready_to_drill(int line) {
  if (refuse_unfinished(line, "a coordinate")) return false;
  return !refuse_inside_stored(line) && !refuse_without_advance(line);
}

bool VisionSession::refuse_inside_stored(int line) {
  if (!memory_.is_inside_series()) return false;
  reporter_.report(Code::PointerInsideSeries,
                   line,
                   1,
                   fmt::format("a coordinate comes while the M52 in line {} has stopped inside a "
                               "stored series",
                               advance_line_),
                   "an M52 count that ends where a stored series ends");
  must_stop_ = true;
  return true;
}

void VisionSession::end_program(int line) {
  refuse_unfinished(line, "the end of the program");
}

bool VisionSession::is_unused() const {
  return !open_ && stack_.base() == nullptr && stack_.nested() == nullptr && memory_.empty();
}

}  // namespace panelcal::excellon
