// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/vision/vision.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::excellon {
namespace {

bool is_single(Command command) {
  return command == Command::BaseOffset || command == Command::NestedOffset;
}

}  // namespace

CorrectionLevel level_of(Command command) {
  const bool is_nested = command == Command::NestedOffset || command == Command::NestedSeries ||
                         command == Command::NestedHoleAtTarget || command == Command::CancelNested;
  return is_nested ? CorrectionLevel::Nested : CorrectionLevel::Base;
}

VisionSession::VisionSession(const WalkOptions& options,
                             Survey& survey,
                             MeasurementSource* source,
                             const Reporter& reporter,
                             DiagnosticLog& log)
    : options_(options),
      reporter_(reporter),
      measuring_(options, survey, source, reporter, log),
      series_size_(options.series_size) {
  settings_.inspections = options.inspections;
}

bool VisionSession::refuse_unfinished(int line, std::string_view command) {
  if (!open_) return false;
  reporter_.report(Code::SeriesUnfinished,
                   line,
                   fmt::format("{} comes after {} of {} targets of the {} series begun in line {}",
                               command,
                               open_->n_wanted - open_->n_left(),
                               open_->n_wanted,
                               open_->command,
                               open_->line),
                   fmt::format("{} more {}, or another [vision] rotate than {}",
                               open_->n_left(),
                               open_->command,
                               open_->n_wanted));
  open_.reset();
  return true;
}

std::optional<std::size_t> VisionSession::measure(const TargetPlace& target,
                                                  CorrectionLevel level,
                                                  bool is_of_series) {
  if (measuring_.is_first_pass() && settings_.tools.empty()) {
    reporter_.report(Code::VisionToolMissing,
                     target.line,
                     code_text(target.command),
                     "G34,# with the number of a vision tool");
    measuring_.stop();
    return std::nullopt;
  }
  MeasurementRequest request;
  request.line = target.line;
  request.file = target.file;
  request.file_sha256 = target.file_sha256;
  request.command = code_text(target.command);
  request.settings = settings_;
  request.nominal = target.nominal;
  request.work_zero = target.work_zero;
  request.path = target.path;
  const Eigen::Vector2d expected_mm =
      level == CorrectionLevel::Nested
          ? measuring_.corrections().stack.base_of(target.nominal).in_mm()
          : target.nominal.in_mm();
  request.expected = position_mm<frame::Actual>(expected_mm);
  return measuring_.measure(std::move(request), is_of_series);
}

void VisionSession::open_series(const TargetPlace& target) {
  const std::string command = code_text(target.command);
  if (open_ && open_->command != command) refuse_unfinished(target.line, command);
  if (open_) return;
  open_ = OpenSeries{.level = level_of(target.command),
                     .line = target.line,
                     .n_wanted = is_single(target.command) ? 1 : series_size_,
                     .command = command,
                     .measurements = {},
                     .targets = {}};
}

void VisionSession::measure_target(const TargetPlace& target) {
  if (refuse_inside_stored(target.line)) return;
  open_series(target);
  const std::optional<std::size_t> index = measure(target, open_->level, true);
  if (!index) return;
  open_->measurements.push_back(*index);
  if (open_->n_left() == 0) complete(target);
}

std::vector<Position<frame::Nominal>> VisionSession::take_target(const TargetPlace& target) {
  open_series(target);
  open_->targets.push_back(target.nominal);
  if (open_->n_left() > 0) return {};
  return std::exchange(open_, std::nullopt)->targets;
}

/// "G38 is not affected by, nor does it affect the current G35 or G36", so it may stand inside of
/// their series; G48 is relative to the correction that an unfinished base series has yet to give.
bool VisionSession::may_drill_at_target(const TargetPlace& target) {
  const bool needs_base = level_of(target.command) == CorrectionLevel::Nested;
  if (!open_ || !needs_base || open_->level == CorrectionLevel::Nested) return true;
  refuse_unfinished(target.line, code_text(target.command));
  return false;
}

std::optional<TargetHolePlace> VisionSession::measure_hole(const TargetPlace& target) {
  if (!may_drill_at_target(target)) return std::nullopt;
  const CorrectionLevel level = level_of(target.command);
  const auto index = measure(target, level, false);
  if (!index) return std::nullopt;
  if (!measuring_.is_found(*index)) return std::nullopt;
  const Measurement& measurement = measuring_.measurement(*index);
  if (measuring_.is_first_pass()) measuring_.gate_hole(measurement, level);
  return measuring_.hole_at_target(*index);
}

std::vector<FitPoint> VisionSession::points_of(const OpenSeries& open) const {
  std::vector<FitPoint> points;
  const auto is_lost = [this](std::size_t i) {
    return measuring_.is_lost(i) || measuring_.is_of_left_out_board(i);
  };
  if (std::ranges::any_of(open.measurements, is_lost)) return points;
  for (const std::size_t i : open.measurements) {
    if (measuring_.is_found(i)) points.push_back(measuring_.fit_point(i));
  }
  return points;
}

/// Only a copy of a pattern has an end behind which its correction is another one.
bool VisionSession::leaves_board_out(const OpenSeries& open, const TargetPlace& target) const {
  if (!is_in_section_ || !target.file.empty() || target.is_worked_before) return false;
  return measuring_.corrections().is_withheld ||
         std::ranges::any_of(open.measurements,
                             [this](std::size_t i) { return measuring_.is_of_left_out_board(i); });
}

/// A section knows a board by its place, or by a target that another one has as well.
bool VisionSession::refuse_left_out_in_part(const SeriesResult& series) {
  if (!series.is_left_out && left_out_.empty()) return false;
  const auto shares_target = [&](const SeriesResult& other) {
    return std::ranges::any_of(other.measurements, [&](std::size_t i) {
      return std::ranges::any_of(series.measurements, [&](std::size_t k) {
        constexpr double kRounding_mm = 1e-6;
        const Eigen::Vector2d apart_mm = measuring_.measurement(i).request.nominal.in_mm() -
                                         measuring_.measurement(k).request.nominal.in_mm();
        return apart_mm.norm() < kRounding_mm;
      });
    });
  };
  for (std::size_t i = 0; is_in_section_ && i < n_series_before_; ++i) {
    const SeriesResult& other = measuring_.series(i);
    if (other.path.empty() || other.is_left_out == series.is_left_out) continue;
    if (!is_same_place(other.placement, series.placement) && !shares_target(other)) continue;
    reporter_.report(Code::CommandMisplaced,
                     series.line,
                     fmt::format("lines {} and {} both work board {}, and only one of them leaves "
                                 "it out",
                                 other.line,
                                 series.line,
                                 fmt::join(series.path, ".")),
                     "a board that no other part of the program works");
    measuring_.stop();
    return true;
  }
  return false;
}

void VisionSession::complete(const TargetPlace& target) {
  const OpenSeries open = *std::exchange(open_, std::nullopt);
  SeriesResult series;
  series.level = open.level;
  series.line = open.line;
  series.path = target.path;
  series.placement = target.placement;
  series.measurements = open.measurements;
  const PanelModel usual = default_model(open.n_wanted);
  series.model = open.n_wanted == 1
                     ? PanelModel::Offset
                     : model_at_most(options_.model.value_or(usual), 2 * open.n_wanted, false);
  series.is_left_out = leaves_board_out(open, target);
  if (!series.is_left_out) {
    series.assignment = measuring_.settle(open.measurements, open.level, open.line);
  }
  std::vector<FitPoint> points;
  do {
    series.is_left_out = leaves_board_out(open, target);
    points = series.is_left_out ? std::vector<FitPoint>() : points_of(open);
  } while (measuring_.reconsider(series, points));
  if (refuse_left_out_in_part(series)) return;
  if (series.is_left_out) left_out_.push_back(series.placement);
  const std::size_t i_series = measuring_.fit(std::move(series), points);
  n_series_ = i_series + 1;
  memory_.store({i_series, open.n_wanted});
  measuring_.activate(i_series, target.line);
  end_replay_outside();
}

void VisionSession::cancel_base(int line) {
  refuse_unfinished(line, "G37");
  end_replay_outside();
  is_used_in_part_ = false;
  cancel(CorrectionLevel::Base);
}

void VisionSession::cancel_nested(int line) {
  refuse_unfinished(line, "G47");
  end_replay_outside();
  cancel(CorrectionLevel::Nested);
}

/// Outside of copies it leaves open which coordinates behind it are a left-out board's.
void VisionSession::cancel(CorrectionLevel level) {
  CorrectionState& state = measuring_.corrections();
  level == CorrectionLevel::Base ? state.clear_base() : state.clear_nested();
  if (!is_in_section_ && std::exchange(state.is_withheld, false)) state.unknown = level;
}

void VisionSession::end_instance(int line) {
  refuse_unfinished(line, "the end of the pattern");
}

bool VisionSession::is_allowed(int line) {
  if (refuse_unfinished(line, "a coordinate")) return false;
  if (is_used_in_part_) {
    refuse_kept(line,
                1,
                "a coordinate stands under a part of a copy's stored corrections",
                "M52 up to the last target of the copy");
    return false;
  }
  return !refuse_inside_stored(line) && !refuse_without_advance(line) && !refuse_uncorrected(line);
}

bool VisionSession::refuse_uncorrected(int line) {
  if (!is_uncorrected()) return false;
  reporter_.report(Code::CommandMisplaced,
                   line,
                   is_at_left_out_board_
                       ? "a coordinate in a copy at the place of a board that is left out"
                       : "a coordinate behind the copy of a board that is left out",
                   is_at_left_out_board_ ? "a board that no other part of the program works"
                                         : "a series (G36, G46), M52 or G47 before it");
  measuring_.stop();
  return true;
}

void VisionSession::end_program(int line) {
  refuse_unfinished(line, "the end of the program");
  refuse_replayed_in_part(line, 1);
}

bool VisionSession::is_unused() const {
  const CorrectionStack& stack = measuring_.corrections().stack;
  return !open_ && stack.base() == nullptr && stack.nested() == nullptr && memory_.empty();
}

}  // namespace panelcal::excellon
