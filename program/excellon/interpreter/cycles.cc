// SPDX-License-Identifier: Apache-2.0
// Canned cycles, engraved text, stored patterns, and P# that repeats them.
#include <string>
#include <utility>

#include "program/excellon/interpreter/parts.h"
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

/// Says that the rows of a package are not as far apart as its block says.
void check_rows(Walk& walk, const Pending& pending) {
  const Eigen::Vector2d& corner_mm = *pending.first_mm;
  if (has_row_spacing(corner_mm, walk.modal.at_mm, pending.row_mm, rounding_mm(walk))) return;
  const Eigen::Vector2d size_mm = (walk.modal.at_mm - corner_mm).cwiseAbs();
  walk.reporter.report(Code::RowsContradicted,
                       pending.line,
                       fmt::format("{}: rows {:.6g} mm apart, corners {:.6g} by {:.6g} mm",
                                   quoted(pending.text),
                                   pending.row_mm,
                                   size_mm.x(),
                                   size_mm.y()),
                       "corners as far apart as the rows, in x or in y");
}

void drill_holes(Walk& walk, int line, const CannedCycle& cycle) {
  const std::int64_t n = cycle.holes->size();
  if (cycle.command == Command::CannedSlot && walk.options.slots == Cycles::Kept &&
      !walk.emitter.follows_map()) {
    return walk.emitter.slot(line, cycle.at_mm + cycle.shift_mm, cycle.end_mm + cycle.shift_mm, n);
  }
  if (walk.is_first_walk()) {
    walk.emitter.count_operations(n, line);
    return;
  }
  for (std::int64_t i = 0; i < n && !walk.has_ended(); ++i) {
    walk.emitter.drill(line, (*cycle.holes)[i] + cycle.shift_mm);
  }
}

/// A pattern's file has no mark at its end, so that only its last line can show that it is cut off.
void refuse_cut_off(Walk& walk, const SourceText& pattern) {
  const std::string file = walk.reporter.file();
  walk.reporter.set_file(pattern.file);
  walk.reporter.report_end_missing(pattern.bytes, "complete lines");
  walk.reporter.set_file(file);
  walk.ended = true;
}

/// Runs the blocks of the pattern's file with a temporary zero at the coordinate behind M99.
/// Source CNC-7 manual, Using a User Defined Stored Pattern
void run_stored_pattern(Walk& walk, const Block& block, const CannedCycle& cycle) {
  const auto pattern = walk.program.patterns.find(cycle.name);
  if (pattern == walk.program.patterns.end()) {
    std::string folders;
    for (const auto& folder : walk.program.reading.pattern_folders) {
      folders += (folders.empty() ? "" : ", ") + quoted(folder.empty() ? "." : folder.string());
    }
    walk.reporter.report(Code::PatternMissing,
                         cycle.line,
                         quoted(cycle.name),
                         folders.empty() ? "a folder to look in" : "a file in " + folders);
    walk.ended = true;
    return;
  }
  if (!ends_in_line_end(pattern->second.bytes)) return refuse_cut_off(walk, pattern->second);
  walk.last_cycle.reset();
  const Eigen::Vector2d zero_mm = cycle.at_mm + cycle.shift_mm;
  const LineCursor cursor = std::exchange(walk.cursor, LineCursor(pattern->second.bytes));
  const WalkPlace place = walk.place;
  const Placement outer_frame = walk.frame;
  const Modal modal = walk.modal;
  const bool was_in_pattern = std::exchange(walk.in_pattern, false);
  const std::string file = walk.reporter.file();
  walk.reporter.set_file(pattern->second.file);
  walk.frame = walk.place.placement * Transform<frame::Programmed, frame::Programmed>(
                                          Eigen::Matrix2d::Identity(), zero_mm);
  walk.place.placement = walk.frame;
  walk.place.pattern = {pattern->second.file, pattern->second.sha256};
  walk.modal.at_mm.setZero();
  walk.modal.user = {AxisUser::None, AxisUser::None};
  walk.modal.has_hole = false;
  walk.in_stored_pattern = true;
  walk.pattern_depth = place.path.size();
  walk.emitter.count_idle_line(block.line);
  while (!walk.cursor.at_end() && !walk.has_ended()) {
    const int number = walk.cursor.line_number();
    const std::int64_t n_before = walk.emitter.n_operations();
    if (!run_plain_lines(walk, walk.cursor.text().size())) run_line(walk, walk.cursor.next());
    if (walk.emitter.n_operations() == n_before) walk.emitter.count_idle_line(number);
  }
  if (!walk.has_ended())
    refuse_pending(walk, walk.cursor.line_number(), "the end of the stored pattern");
  if (std::exchange(walk.is_plunged, false) && !walk.has_ended()) {
    walk.reporter.report(Code::ToolPlunged,
                         walk.cursor.line_number(),
                         "the stored pattern ends while the router is down",
                         "M16 or M17 at its end");
  }
  walk.vision.end_instance(walk.cursor.line_number());
  walk.in_stored_pattern = false;
  walk.in_pattern = was_in_pattern;
  walk.reporter.set_file(file);
  walk.frame = outer_frame;
  walk.place.placement = place.placement;
  walk.place.pattern = place.pattern;
  walk.cursor = cursor;
  walk.modal.at_mm = modal.at_mm;
  walk.modal.user = {AxisUser::Lost, AxisUser::Lost};
  walk.modal.incremental = modal.incremental;
  walk.modal.has_hole = false;
  walk.modal.has_start = false;
}

void run_cycle(Walk& walk, const Block& block, const CannedCycle& cycle) {
  if (cycle.command == Command::StoredPattern) return run_stored_pattern(walk, block, cycle);
  if (!walk.vision.is_ready_to_drill(block.line) || !has_tool(walk, block.line)) return;
  drill_holes(walk, block.line, cycle);
}

/// M97,text and M98,text: along x, or along y with the letters' tops to the left.
void engrave(Walk& walk, const Block& block, const Pending& pending) {
  walk.last_cycle.reset();
  if (!walk.vision.is_ready_to_drill(block.line) || !has_tool(walk, block.line)) return;
  if (pending.argument.empty()) {
    return walk.reporter.report(
        Code::ArgumentInvalid, pending.line, quoted(pending.text), "a text behind the comma");
  }
  const auto text = prepare_text(pending.argument, walk.program.reading.operator_id);
  if (!text) {
    return walk.reporter.report(
        Code::ArgumentInvalid,
        pending.line,
        quoted(std::string(1, pending.argument[text.error()])) + " in " + quoted(pending.text),
        "A to Z, 0 to 9, + - / * and commas for spaces");
  }
  constexpr CharacterSet kFont = CharacterSet::Excellon4x7;
  const double pitch_mm = text_pitch_mm(tool_diameter(walk));
  Eigen::Matrix2d turn = Eigen::Matrix2d::Identity();
  if (pending.command == Command::TextY) turn << 0, -1, 1, 0;
  const Eigen::Vector2d start_mm = walk.modal.at_mm + walk.modal.text_offset.in_mm();
  for (std::size_t i = 0; i < text->size() && !walk.has_ended(); ++i) {
    const auto letter = glyph(kFont, (*text)[i]);
    if (!letter) continue;
    const auto column = static_cast<double>(i) * advance_columns(kFont);
    for (const GlyphHole& hole : letter->holes()) {
      const Eigen::Vector2d grid(column + hole.column, hole.row);
      walk.emitter.drill(block.line, start_mm + pitch_mm * (turn * grid));
    }
  }
}

void finish_cycle(Walk& walk, const Block& block, const Pending& pending) {
  walk.modal.has_hole = false;
  if (pending.command == Command::TextX || pending.command == Command::TextY) {
    return engrave(walk, block, pending);
  }
  CannedCycle cycle{.command = pending.command,
                    .line = pending.line,
                    .holes = std::nullopt,
                    .name = pending.argument,
                    .at_mm = walk.modal.at_mm};
  if (pending.command != Command::StoredPattern) {
    auto holes = pending.command == Command::EightPin
                     ? eight_pin(*pending.first_mm, walk.modal.at_mm, rounding_mm(walk))
                     : dual_in_line(*pending.first_mm,
                                    walk.modal.at_mm,
                                    pending.pitch_mm,
                                    pending.row_mm,
                                    rounding_mm(walk));
    if (!holes) return refuse_cycle(walk, block, block.words[0], holes.error());
    cycle.holes = *std::move(holes);
    if (pending.command != Command::EightPin) check_rows(walk, pending);
  }
  run_cycle(walk, block, cycle);
  walk.last_cycle = std::move(cycle);
}

/// The holes of a circle or slot depend on the tool, which may be another one at a P#.
bool make_holes(Walk& walk, const Block& block, const Word& word, CannedCycle& cycle) {
  const bool is_slot = cycle.command == Command::CannedSlot;
  if (!is_slot && cycle.command != Command::CannedCircle) return true;
  if (is_slot && !tool_diameter(walk)) {
    walk.reporter.report(Code::DiameterMissing, block.in(word), "C# of the tool");
    return false;
  }
  const double tool_mm = tool_diameter(walk).value_or(kDefaultCircleTool).in_mm();
  auto holes = is_slot ? canned_slot(cycle.at_mm, cycle.end_mm, tool_mm)
                       : canned_circle(cycle.at_mm, cycle.diameter_mm, tool_mm);
  if (!holes) {
    refuse_cycle(walk, block, word, holes.error());
    return false;
  }
  cycle.holes = *std::move(holes);
  return true;
}

}  // namespace

/// Says that the coordinates of a cycle are missing, if one waits for them.
bool refuse_pending(Walk& walk, int line, std::string_view what) {
  if (!walk.pending) return false;
  const Pending pending = *std::exchange(walk.pending, std::nullopt);
  walk.reporter.report(
      Code::CycleUnfinished,
      line,
      quoted(what) + " comes before the coordinates of " + quoted(pending.text) + " in line " +
          std::to_string(pending.line),
      wants_two_corners(pending.command) ? "X#Y# of both corners, a block each" : "X#Y#");
  return true;
}

/// `why` says what does not fit and what was expected.
void refuse_cycle(Walk& walk, const Block& block, const Word& word, const std::string& why) {
  walk.reporter.report(Code::CycleInvalid, block.in(word), ": " + why, "");
}

void begin_cycle(Walk& walk, const Block& block, Command command) {
  if (refuse_while_plunged(walk, block)) return;
  MotionWords read;
  const bool has_spacing = command == Command::DualInLine || command == Command::DualInLine1;
  if (has_spacing ? !read_words(walk, block, block.all().subspan(1), "XY", read)
                  : !is_alone(walk, block)) {
    return;
  }
  Pending pending{.command = command,
                  .line = block.line,
                  .text = std::string(block.text),
                  .argument = std::string(block.argument),
                  .pitch_mm = read.xy_mm[0].value_or(kDefaultCyclePitch.in_mm()),
                  .row_mm = read.xy_mm[1].value_or(kDefaultRow.in_mm()),
                  .first_mm = std::nullopt};
  if (command == Command::StoredPattern) {
    if (walk.in_stored_pattern) {
      return walk.reporter.report(Code::PatternNested, block.first(), "blocks without M99");
    }
    if (!is_pattern_name(pending.argument)) {
      return walk.reporter.report(Code::ArgumentInvalid, block.first(), "M99,name of a file");
    }
  } else {
    walk.modal.motion = Motion::Drill;
    walk.modal.side = CompensationSide::Off;
  }
  walk.pending = std::move(pending);
}

void take_corner(Walk& walk, const Block& block) {
  MotionWords read;
  if (!read_words(walk, block, block.all(), "XY", read) ||
      !move_to(walk, block, read.xy_mm, AxisUser::Work)) {
    walk.pending.reset();
    return;
  }
  if (wants_two_corners(walk.pending->command) && !walk.pending->first_mm) {
    walk.pending->first_mm = walk.modal.at_mm;
    return;
  }
  finish_cycle(walk, block, *std::exchange(walk.pending, std::nullopt));
}

/// X#Y#G84X#, X#Y#G85X#Y# and X#Y#G87X#Y#Z-#U#; `i_code` is the code's word.
void inline_cycle(Walk& walk, const Block& block, std::size_t i_code, Command command) {
  if (refuse_while_plunged(walk, block)) return;
  const bool is_rout = command == Command::RoutedStepSlot;
  walk.last_cycle.reset();
  walk.modal.motion = is_rout ? Motion::Rapid : Motion::Drill;
  walk.modal.side = CompensationSide::Off;
  walk.modal.has_hole = false;
  walk.modal.has_start = false;
  MotionWords first;
  MotionWords second;
  if (!read_words(walk, block, block.all().subspan(0, i_code), "XY", first) ||
      !move_to(walk, block, first.xy_mm, AxisUser::Work)) {
    return;
  }
  const Eigen::Vector2d start_mm = walk.modal.at_mm;
  const std::string_view letters = command == Command::CannedCircle ? "X" : is_rout ? "XYZU" : "XY";
  if (!read_words(walk, block, block.all().subspan(i_code + 1), letters, second)) return;
  if (!second.xy_mm[0] && !second.xy_mm[1]) {
    return walk.reporter.report(Code::CoordinateMissing,
                                block.in(block.words[i_code]),
                                std::string(info(command).operands));
  }
  CannedCycle cycle{
      .command = command, .line = block.line, .holes = std::nullopt, .name = {}, .at_mm = start_mm};
  if (command == Command::CannedCircle) {
    cycle.diameter_mm = *second.xy_mm[0];
  } else if (!move_to(walk, block, second.xy_mm, AxisUser::Work)) {
    return;
  }
  cycle.end_mm = walk.modal.at_mm;
  if (!walk.vision.is_ready_to_drill(block.line) || !has_tool(walk, block.line)) return;
  if (is_rout) return step_slot(walk, block, start_mm, walk.modal.at_mm, second);
  if (!make_holes(walk, block, block.words[i_code], cycle)) return;
  walk.last_cycle = cycle;
  drill_holes(walk, block.line, cycle);
}

/// P#X#Y#: more copies of the last pattern, each from the start of the one before.
void repeat_pattern(Walk& walk, const Block& block) {
  const Word& repeat = block.words[0];
  const auto count = parse_count(repeat.number);
  if (!count || *count < 1 || *count > 999) {
    return walk.reporter.report(Code::ArgumentInvalid, block.in(repeat), "P1 to P999");
  }
  if (refuse_while_plunged(walk, block)) return;
  MotionWords read;
  if (!read_words(walk, block, block.all().subspan(1), "XY", read)) return;
  if (!read.xy_mm[0] && !read.xy_mm[1]) {
    return walk.reporter.report(Code::CoordinateMissing, block.in(repeat), "P#X#Y#");
  }
  if (!walk.last_cycle) {
    return walk.reporter.report(
        Code::RepeatWithoutPattern, block.in(repeat), "G81 to G85, or M99, before it");
  }
  const Eigen::Vector2d step_mm(read.xy_mm[0].value_or(0), read.xy_mm[1].value_or(0));
  CannedCycle cycle = *std::exchange(walk.last_cycle, std::nullopt);
  if (!make_holes(walk, block, repeat, cycle)) return;
  for (int i = 0; i < *count && !walk.has_ended(); ++i) {
    cycle.shift_mm += step_mm;
    run_cycle(walk, block, cycle);
  }
  walk.modal.user = {AxisUser::Lost, AxisUser::Lost};
  walk.last_cycle = std::move(cycle);
}

}  // namespace panelcal::excellon
