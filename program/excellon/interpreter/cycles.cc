// SPDX-License-Identifier: Apache-2.0
// Canned cycles, engraved text, stored patterns, and P# that repeats them.
#include <string>
#include <utility>

#include "program/excellon/interpreter/interpreter.h"
#include "program/excellon/patterns/stored_patterns.h"
#include "program/excellon/patterns/text_engraving.h"
#include "program/geometry/dot_font.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

// CNC-7 manual, Dual In Line Package.
constexpr Length kDefaultCyclePitch = inch(0.1);
constexpr Length kDefaultRow = inch(0.3);
// CNC-7 manual, Canned Circle.
constexpr Length kDefaultCircleTool = inch(0.125);

bool wants_two_corners(Command command) {
  return command == Command::DualInLine || command == Command::DualInLine1 ||
         command == Command::EightPin;
}

}  // namespace

/// Says that the coordinates of a cycle are missing, if one waits for them.
bool Interpreter::refuse_pending(int line, std::string_view what) {
  if (!pending_) return false;
  const Pending pending = *std::exchange(pending_, std::nullopt);
  reporter_.report(
      Code::CycleUnfinished,
      line,
      1,
      quoted(what) + " comes before the coordinates of " + quoted(pending.text) + " in line " +
          std::to_string(pending.line),
      wants_two_corners(pending.command) ? "X#Y# of both corners, a block each" : "X#Y#");
  return true;
}

/// `why` says what does not fit and what was expected.
void Interpreter::refuse_cycle(const Block& block, const Word& word, const std::string& why) {
  reporter_.report(Code::CycleInvalid,
                   block.line,
                   word.column,
                   quoted(word.text()) + " in " + quoted(block.text) + ": " + why);
}

void Interpreter::begin_cycle(const Block& block, Command command) {
  if (refuse_while_plunged(block)) return;
  MotionWords read;
  const bool has_spacing = command == Command::DualInLine || command == Command::DualInLine1;
  if (has_spacing ? !read_words(block, block.all().subspan(1), "XY", read) : !is_alone(block)) {
    return;
  }
  Pending pending{.command = command,
                  .line = block.line,
                  .text = std::string(block.text),
                  .argument = std::string(block.arguments),
                  .pitch_mm = read.xy_mm[0].value_or(kDefaultCyclePitch.in_mm()),
                  .row_mm = read.xy_mm[1].value_or(kDefaultRow.in_mm()),
                  .first_mm = std::nullopt};
  if (command == Command::StoredPattern) {
    if (in_stored_pattern_) {
      return report(Code::PatternNested, block, block.words[0], "blocks without M99");
    }
    if (!is_pattern_name(pending.argument)) {
      return report(Code::ArgumentInvalid, block, block.words[0], "M99,name of a file");
    }
  } else {
    modal_.motion = Motion::Drill;
    modal_.side = CompensationSide::Off;
  }
  pending_ = std::move(pending);
}

void Interpreter::take_corner(const Block& block) {
  MotionWords read;
  if (!read_words(block, block.all(), "XY", read) || !move_to(block, read.xy_mm, AxisUser::Work)) {
    pending_.reset();
    return;
  }
  if (wants_two_corners(pending_->command) && !pending_->first_mm) {
    pending_->first_mm = modal_.at_mm;
    return;
  }
  finish_cycle(block, *std::exchange(pending_, std::nullopt));
}

void Interpreter::finish_cycle(const Block& block, const Pending& pending) {
  modal_.has_hole = false;
  if (pending.command == Command::TextX || pending.command == Command::TextY) {
    return engrave(block, pending);
  }
  Cycle cycle{.command = pending.command,
              .line = pending.line,
              .holes = std::nullopt,
              .name = pending.argument,
              .at_mm = modal_.at_mm};
  if (pending.command != Command::StoredPattern) {
    auto holes =
        pending.command == Command::EightPin
            ? eight_pin(*pending.first_mm, modal_.at_mm, rounding_mm())
            : dual_in_line(
                  *pending.first_mm, modal_.at_mm, pending.pitch_mm, pending.row_mm, rounding_mm());
    if (!holes) return refuse_cycle(block, block.words[0], holes.error());
    cycle.holes = *std::move(holes);
    if (pending.command != Command::EightPin) check_rows(pending);
  }
  run_cycle(block, cycle);
  last_cycle_ = std::move(cycle);
}

/// Says that the rows of a package are not as far apart as its block says.
void Interpreter::check_rows(const Pending& pending) {
  const Eigen::Vector2d& corner_mm = *pending.first_mm;
  if (has_row_spacing(corner_mm, modal_.at_mm, pending.row_mm, rounding_mm())) return;
  const Eigen::Vector2d size_mm = (modal_.at_mm - corner_mm).cwiseAbs();
  reporter_.report(Code::RowsContradicted,
                   pending.line,
                   1,
                   fmt::format("{}: rows {:.6g} mm apart, corners {:.6g} by {:.6g} mm",
                               quoted(pending.text),
                               pending.row_mm,
                               size_mm.x(),
                               size_mm.y()),
                   "corners as far apart as the rows, in x or in y");
}

/// X#Y#G84X#, X#Y#G85X#Y# and X#Y#G87X#Y#Z-#U#; `i_code` is the code's word.
void Interpreter::inline_cycle(const Block& block, std::size_t i_code, Command command) {
  if (refuse_while_plunged(block)) return;
  const bool is_rout = command == Command::RoutedStepSlot;
  last_cycle_.reset();
  modal_.motion = is_rout ? Motion::Rapid : Motion::Drill;
  modal_.side = CompensationSide::Off;
  modal_.has_hole = false;
  modal_.has_start = false;
  MotionWords first;
  MotionWords second;
  if (!read_words(block, block.all().subspan(0, i_code), "XY", first) ||
      !move_to(block, first.xy_mm, AxisUser::Work)) {
    return;
  }
  const Eigen::Vector2d start_mm = modal_.at_mm;
  const std::string_view letters = command == Command::CannedCircle ? "X" : is_rout ? "XYZU" : "XY";
  if (!read_words(block, block.all().subspan(i_code + 1), letters, second)) return;
  if (!second.xy_mm[0] && !second.xy_mm[1]) {
    return report(
        Code::CoordinateMissing, block, block.words[i_code], std::string(info(command).operands));
  }
  Cycle cycle{
      .command = command, .line = block.line, .holes = std::nullopt, .name = {}, .at_mm = start_mm};
  if (command == Command::CannedCircle) {
    cycle.diameter_mm = *second.xy_mm[0];
  } else if (!move_to(block, second.xy_mm, AxisUser::Work)) {
    return;
  }
  cycle.end_mm = modal_.at_mm;
  if (!vision_.is_ready_to_drill(block.line) || !has_tool(block.line)) return;
  if (is_rout) return step_slot(block, start_mm, modal_.at_mm, second);
  if (!make_holes(block, block.words[i_code], cycle)) return;
  last_cycle_ = cycle;
  drill_holes(block.line, cycle);
}

/// The holes of a circle or slot depend on the tool, which may be another one at a P#.
bool Interpreter::make_holes(const Block& block, const Word& word, Cycle& cycle) {
  const bool is_slot = cycle.command == Command::CannedSlot;
  if (!is_slot && cycle.command != Command::CannedCircle) return true;
  if (is_slot && !tool_diameter()) {
    report(Code::DiameterMissing, block, word, "C# of the tool");
    return false;
  }
  const double tool_mm = tool_diameter().value_or(kDefaultCircleTool).in_mm();
  auto holes = is_slot ? canned_slot(cycle.at_mm, cycle.end_mm, tool_mm)
                       : canned_circle(cycle.at_mm, cycle.diameter_mm, tool_mm);
  if (!holes) {
    refuse_cycle(block, word, holes.error());
    return false;
  }
  cycle.holes = *std::move(holes);
  return true;
}

void Interpreter::run_cycle(const Block& block, const Cycle& cycle) {
  if (cycle.command == Command::StoredPattern) return run_stored_pattern(block, cycle);
  if (!vision_.is_ready_to_drill(block.line) || !has_tool(block.line)) return;
  drill_holes(block.line, cycle);
}

void Interpreter::drill_holes(int line, const Cycle& cycle) {
  const std::int64_t n = cycle.holes->size();
  if (cycle.command == Command::CannedSlot && options_.slots == Cycles::Kept &&
      !emitter_.follows_map()) {
    return emitter_.slot(line, cycle.at_mm + cycle.shift_mm, cycle.end_mm + cycle.shift_mm, n);
  }
  if (is_first_walk()) {
    emitter_.count_operations(n, line);
    return;
  }
  for (std::int64_t i = 0; i < n && !has_ended(); ++i) {
    emitter_.drill(line, (*cycle.holes)[i] + cycle.shift_mm);
  }
}

/// P#X#Y#: more copies of the last pattern, each from the start of the one before.
void Interpreter::repeat_pattern(const Block& block) {
  const Word& repeat = block.words[0];
  const auto count = parse_count(repeat.number);
  if (!count || *count < 1 || *count > 999) {
    return report(Code::ArgumentInvalid, block, repeat, "P1 to P999");
  }
  if (refuse_while_plunged(block)) return;
  MotionWords read;
  if (!read_words(block, block.all().subspan(1), "XY", read)) return;
  if (!read.xy_mm[0] && !read.xy_mm[1]) {
    return report(Code::CoordinateMissing, block, repeat, "P#X#Y#");
  }
  if (!last_cycle_) {
    return report(Code::RepeatWithoutPattern, block, repeat, "G81 to G85, or M99, before it");
  }
  const Eigen::Vector2d step_mm(read.xy_mm[0].value_or(0), read.xy_mm[1].value_or(0));
  Cycle cycle = *std::exchange(last_cycle_, std::nullopt);
  if (!make_holes(block, repeat, cycle)) return;
  for (int i = 0; i < *count && !has_ended(); ++i) {
    cycle.shift_mm += step_mm;
    run_cycle(block, cycle);
  }
  modal_.user = {AxisUser::Lost, AxisUser::Lost};
  last_cycle_ = std::move(cycle);
}

/// M97,text and M98,text: along x, or along y with the letters' tops to the left.
void Interpreter::engrave(const Block& block, const Pending& pending) {
  last_cycle_.reset();
  if (!vision_.is_ready_to_drill(block.line) || !has_tool(block.line)) return;
  if (pending.argument.empty()) {
    return reporter_.report(
        Code::ArgumentInvalid, pending.line, 1, quoted(pending.text), "a text behind the comma");
  }
  const auto text = prepare_text(pending.argument, program_.reading.operator_id);
  if (!text) {
    return reporter_.report(
        Code::ArgumentInvalid,
        pending.line,
        1,
        quoted(std::string(1, pending.argument[text.error()])) + " in " + quoted(pending.text),
        "A to Z, 0 to 9, + - / * and commas for spaces");
  }
  constexpr CharacterSet kFont = CharacterSet::Excellon4x7;
  const double pitch_mm = text_pitch_mm(tool_diameter());
  Eigen::Matrix2d turn = Eigen::Matrix2d::Identity();
  if (pending.command == Command::TextY) turn << 0, -1, 1, 0;
  const Eigen::Vector2d start_mm = modal_.at_mm + modal_.text_offset.in_mm();
  for (std::size_t i = 0; i < text->size() && !has_ended(); ++i) {
    const auto letter = glyph(kFont, (*text)[i]);
    if (!letter) continue;
    const auto column = static_cast<double>(i) * advance_columns(kFont);
    for (const GlyphHole& hole : letter->holes()) {
      const Eigen::Vector2d grid(column + hole.column, hole.row);
      emitter_.drill(block.line, start_mm + pitch_mm * (turn * grid));
    }
  }
}

/// A pattern's file has no mark at its end, so that only its last line can show that it is cut off.
void Interpreter::refuse_cut_off(const SourceText& pattern) {
  const std::string file = reporter_.file();
  reporter_.set_file(pattern.file);
  reporter_.report_end_missing(pattern.bytes, "complete lines");
  reporter_.set_file(file);
  ended_ = true;
}

/// Runs the blocks of the pattern's file with a temporary zero at the coordinate behind M99.
/// Source CNC-7 manual, Using a User Defined Stored Pattern
void Interpreter::run_stored_pattern(const Block& block, const Cycle& cycle) {
  const auto pattern = program_.patterns.find(cycle.name);
  if (pattern == program_.patterns.end()) {
    std::string folders;
    for (const auto& folder : program_.reading.pattern_folders) {
      folders += (folders.empty() ? "" : ", ") + quoted(folder.empty() ? "." : folder.string());
    }
    reporter_.report(Code::PatternMissing,
                     cycle.line,
                     1,
                     quoted(cycle.name),
                     folders.empty() ? "a folder to look in" : "a file in " + folders);
    ended_ = true;
    return;
  }
  if (!ends_in_line_end(pattern->second.bytes)) return refuse_cut_off(pattern->second);
  last_cycle_.reset();
  const Eigen::Vector2d zero_mm = cycle.at_mm + cycle.shift_mm;
  const LineCursor cursor = std::exchange(cursor_, LineCursor(pattern->second.bytes));
  const WalkPlace place = place_;
  const Placement outer_frame = frame_;
  const Modal modal = modal_;
  const bool was_in_pattern = std::exchange(in_pattern_, false);
  const std::string file = reporter_.file();
  reporter_.set_file(pattern->second.file);
  frame_ = place_.placement *
           Transform<frame::Programmed, frame::Programmed>(Eigen::Matrix2d::Identity(), zero_mm);
  place_.placement = frame_;
  place_.pattern = {pattern->second.file, pattern->second.sha256};
  modal_.at_mm.setZero();
  modal_.user = {AxisUser::None, AxisUser::None};
  modal_.has_hole = false;
  in_stored_pattern_ = true;
  pattern_depth_ = place.path.size();
  emitter_.count_idle_line(block.line);
  while (!cursor_.at_end() && !has_ended()) {
    const int number = cursor_.line_number();
    const std::int64_t n_before = emitter_.n_operations();
    if (!run_plain_lines(cursor_.text().size())) run_line(cursor_.next());
    if (emitter_.n_operations() == n_before) emitter_.count_idle_line(number);
  }
  if (!has_ended()) refuse_pending(cursor_.line_number(), "the end of the stored pattern");
  if (std::exchange(is_plunged_, false) && !has_ended()) {
    reporter_.report(Code::ToolPlunged,
                     cursor_.line_number(),
                     1,
                     "the stored pattern ends while the router is down",
                     "M16 or M17 at its end");
  }
  vision_.end_instance(cursor_.line_number());
  in_stored_pattern_ = false;
  in_pattern_ = was_in_pattern;
  reporter_.set_file(file);
  frame_ = outer_frame;
  place_.placement = place.placement;
  place_.pattern = place.pattern;
  cursor_ = cursor;
  modal_.at_mm = modal.at_mm;
  modal_.user = {AxisUser::Lost, AxisUser::Lost};
  modal_.incremental = modal.incremental;
  modal_.has_hole = false;
  modal_.has_start = false;
}

}  // namespace panelcal::excellon
