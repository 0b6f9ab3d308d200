// SPDX-License-Identifier: Apache-2.0
// Patterns and vision commands, where structure is kept.
#include <charconv>
#include <cmath>
#include <utility>

#include "calib/base/append_format.h"
#include "program/writers/excellon/writer.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::int64_t kMostRepeats = 9999;  // R#

double scale_of(int n_decimals) {
  return std::pow(10.0, n_decimals);
}

}  // namespace

// --- patterns ----------------------------------------------------------------------------------

/// A pattern runs where it stands, so it has to stand where its first copy is, and that is known
/// only at its end.
void ExcellonWriter::store(const Operation& operation) {
  if (std::holds_alternative<PatternBegin>(operation.what)) ++n_open_patterns_;
  if (std::holds_alternative<PatternEnd>(operation.what)) --n_open_patterns_;
  stored_.add(operation);
  if (n_open_patterns_ > 0) return;
  put_stored(0, stored_.size(), WorkMap());
  stored_.clear();
}

/// Writes a part of what is stored, carried by `map`.
void ExcellonWriter::put_stored(std::size_t begin, std::size_t end, const WorkMap& map) {
  std::vector<Position<frame::Nominal>> targets;
  std::vector<Placement> moved;
  for (std::size_t i = begin; i < end; ++i) {
    if (!std::holds_alternative<PatternBegin>(stored_[i].what)) {
      note_place(stored_[i]);
      if (is_superseded(i, end)) {
        lose_looking();
      } else {
        put_now(carried(stored_[i], map, targets, moved));
      }
      continue;
    }
    const std::size_t inner = i + 1;
    for (int depth = 1; depth > 0;) {
      ++i;
      if (std::holds_alternative<PatternBegin>(stored_[i].what)) ++depth;
      if (std::holds_alternative<PatternEnd>(stored_[i].what)) --depth;
    }
    std::vector<WorkMap> copies;
    for (const Placement& copy : std::get<PatternEnd>(stored_[i].what).copies) {
      copies.push_back(map * work_map(copy));
    }
    if (copies.empty()) copies.push_back(map);
    note_place(stored_[i]);
    put_pattern(inner, i, copies);
  }
}

/// As a section where Excellon can repeat it; else every copy is written.
void ExcellonWriter::put_pattern(std::size_t begin,
                                 std::size_t end,
                                 const std::vector<WorkMap>& copies) {
  const PatternSets sets = sets_of(begin, end);
  // A control stores and uses corrections in a pattern, be it one of a single copy.
  bool can_repeat = copies.size() > 1 || sets.keep != nullptr || sets.use != nullptr;
  for (std::size_t i = begin; i < end && can_repeat; ++i) {
    can_repeat = !std::holds_alternative<PatternBegin>(stored_[i].what) &&
                 !std::holds_alternative<ZeroSet>(stored_[i].what);
  }
  for (const WorkMap& copy : copies) can_repeat &= copy_run(copy.linear()).has_value();
  can_repeat = can_repeat && may_repeat_sets(sets, begin, end, copies.size());
  if (sets.keep != nullptr) {
    if (!can_repeat) {
      return refuse("corrections that the copies of such a pattern save (G39,SAVE)",
                    "a pattern with offsets by M50 to M90 alone, no pattern in it, and G30 ahead "
                    "of it where a correction was loaded");
    }
    end_replay();
    n_kept_copies_[sets.keep->label] = static_cast<int>(copies.size());
    put_now({.what = StoredCorrection{StoredCorrectionKind::RecordNext, sets.keep->label, {}, 0}});
  }
  if (!can_repeat) {
    for (const WorkMap& copy : copies) {
      ++executed_copy_;
      put_stored(begin, end, copy);
    }
    executed_copy_ = 0;
    return;
  }
  if (sets.use != nullptr) {
    end_replay();
    put_now({.what = StoredCorrection{StoredCorrectionKind::RewindNext, sets.use->label, {}, 0}});
  }
  // The second copy looks under what the first has left.
  has_base_ |= copies.size() > 1 && leaves_base(begin, end);
  put_now({.what = PatternBegin()});
  put_stored(begin, end, copies.front());
  const WorkMap back = copies.front().inverse();
  std::vector<WorkMap> others;
  for (std::size_t i = 1; i < copies.size(); ++i) others.push_back(copies[i] * back);
  close_pattern(others);
}

void ExcellonWriter::write(const PatternBegin&) {
  go_to_drill_mode();
  line("M25");
  series_size_.reset();  // a copy may begin with another one
}

/// The first copy is the pattern itself.
void ExcellonWriter::write(const PatternEnd& end) {
  std::vector<WorkMap> others;
  for (std::size_t i = 1; i < end.copies.size(); ++i) others.push_back(work_map(end.copies[i]));
  close_pattern(others);
}

/// Offsets add up, so their sum is rounded.
/// Source CNC-7 manual, Step and Repeat Commands, Repeat Pattern Offset
void ExcellonWriter::close_pattern(const std::vector<WorkMap>& copies) {
  go_to_drill_mode();
  line("M01");
  const double steps_per_mm = scale_of(n_decimals_) / written_unit_mm_;
  const Eigen::Matrix2d back = written_from_work().transpose();
  std::vector<SteppedCopy> stepped;
  for (const WorkMap& copy : copies) {
    const Eigen::Matrix2d linear = written_from_work() * copy.linear() * back;
    const Eigen::Vector2d offset = written_from_work() * copy.translation() * steps_per_mm;
    stepped.push_back(
        {copy_run(linear).value_or(CopyRun()), std::llround(offset.x()), std::llround(offset.y())});
  }
  const Eigen::Matrix2d to_work = written_from_work().transpose();
  for (const EqualCopies& copy : rows_of(stepped, kMostRepeats)) {
    if (copy.count > 1) internal::append_format(text(), "R{}", copy.count);
    text() += "M02";
    const Eigen::Vector2d step(static_cast<double>(copy.step_x), static_cast<double>(copy.step_y));
    append_point(to_work * step / steps_per_mm);
    // In the order of the manual's sample program.
    if (copy.orientation.mirror_x) text() += "M80";
    if (copy.orientation.mirror_y) text() += "M90";
    if (copy.orientation.swap_axes) text() += "M70";
    text() += '\n';
  }
  // "After the last M02 repeat command, an extra M02 command": a control counts on without it.
  if (!copies.empty()) line("M02");
  line("M08");
  table_feed_.reset();
  series_size_.reset();
}

// --- vision ------------------------------------------------------------------------------------

/// A vision order that is passed on as written; it may change what this writer has to say.
void ExcellonWriter::note_vision(std::string_view order) {
  line(order);
  if (order.starts_with("G34")) has_vision_tool_ = true;
  constexpr std::string_view kAlgorithm = "$uvis,alg,";
  if (!order.starts_with(kAlgorithm)) return;
  order.remove_prefix(kAlgorithm.size());
  int size = 0;
  const auto comma = order.find(',');
  if (comma == std::string_view::npos) return;
  std::from_chars(order.data(), order.data() + comma, algorithm_);
  const std::string_view number = order.substr(comma + 1);
  const auto read = std::from_chars(number.data(), number.data() + number.size(), size);
  if (read.ec == std::errc()) series_size_ = size;
}

/// The other control measures with a tool of its configuration unless told otherwise; this one
/// wants a G34.
void ExcellonWriter::say_vision_tool() {
  if (!std::exchange(has_vision_tool_, true)) {
    line(fmt::format("G34,{}", options().default_vision_tool));
  }
}

/// Source CNC-7 manual, Vision Assist Commands
void ExcellonWriter::write(const VisionSeries& series) {
  const bool is_nested = series.level == CorrectionLevel::Nested;
  const auto n = static_cast<int>(series.targets.size());
  if (is_foreign() && is_nested && (n > 1 || has_nested_)) {
    return refuse("one offset of a pattern from several targets (CAMA)", "one G36 in each copy");
  }
  if (is_foreign()) {
    has_nested_ = is_nested;
    if (!is_nested) note_base_series();
  }
  say_vision_tool();
  if (n > 1 && series_size_ != n) {
    line(fmt::format("$uvis,alg,{},{}", algorithm_, n));
    series_size_ = n;
  }
  for (const Position<frame::Nominal>& target : series.targets) {
    text() += n == 1 ? (is_nested ? "G45" : "G35") : (is_nested ? "G46" : "G36");
    append_point(target.in_mm());
    text() += '\n';
  }
}

void ExcellonWriter::write(const TargetHole& hole) {
  check_cut(hole.cut);
  say_vision_tool();
  go_to_drill_mode();
  text() += hole.level == CorrectionLevel::Nested ? "G48" : "G38";
  append_point(hole.nominal.in_mm());
  text() += '\n';
}

void ExcellonWriter::write(const CancelCorrection& cancel) {
  has_nested_ = false;
  if (cancel.level == CorrectionLevel::Base) {
    has_base_ = false;
    end_replay();
  }
  line(cancel.level == CorrectionLevel::Nested ? "G47" : "G37");
}

/// A series is stored by itself under M50; M52 counts its targets.
/// Source CNC-7 manual, Vision Step and Repeat
void ExcellonWriter::write(const StoredCorrection& stored) {
  switch (stored.kind) {
    case StoredCorrectionKind::RecordNext:
      return line(fmt::format("M50,{}", stored.label));
    case StoredCorrectionKind::RewindNext:
      return line(fmt::format("M51,{}", stored.label));
    case StoredCorrectionKind::NestNext:
    case StoredCorrectionKind::Keep:
      return;
    case StoredCorrectionKind::Use:
      if (is_foreign()) return use_stored(stored);
      return line(fmt::format("M52,{}", stored.n_passed));
  }
}

void ExcellonWriter::write(const VisionTool& tool) {
  if (tool.number < 1) return refuse("vision tool 0 (G35,0)", "a vision tool from 1");
  has_vision_tool_ = true;
  line(fmt::format("G34,{}", tool.number));
}

}  // namespace panelcal
