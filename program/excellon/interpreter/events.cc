// SPDX-License-Identifier: Apache-2.0
// Stops, dwells, messages, and events that are the machine's own.
#include <string>

#include "program/excellon/interpreter/parts.h"
#include "program/excellon/text/header_words.h"

namespace panelcal::excellon {
namespace {

/// A text that stops in its last line may have been cut off there: `M0` comes of M08, `M30X1` of
/// M30X10. Only the end by itself needs no line end.
bool is_whole_end(const Walk& walk, const Block& block, std::span<const Word> words) {
  if (walk.cursor.offset() < walk.text.size() || ends_in_line_end(walk.text)) return true;
  return words.empty() && block.words[block.n_words - 1].number.size() == 2;
}

std::string end_codes(const Walk& walk) {
  return walk.set == ProgramSet::FormatOne ? "M30 or M02" : "M30 or M00";
}

}  // namespace

/// M00, M06, M09, M30 with (X#Y#): the place is relative to absolute zero.
void stop(Walk& walk, const Block& block, std::span<const Word> words, StopKind kind) {
  if (refuse_while_plunged(walk, block)) return;
  MotionWords read;
  if (!read_words(walk, block, words, "XY", read)) return;
  Stop stop{.kind = kind};
  if (read.xy_mm[0].has_value() != read.xy_mm[1].has_value()) {
    // The manual does not say where the other axis goes.
    return walk.reporter.report(
        Code::CoordinateMissing, block.in(words.front()), "both X and Y, or neither");
  }
  if (read.xy_mm[0]) {
    const auto place = displacement_mm<frame::Programmed>(*read.xy_mm[0], *read.xy_mm[1]);
    stop.from_absolute_zero = displacement_mm<frame::Machine>(walk.axes(place).in_mm());
    stop.actual = walk.options.absolute_zero + *stop.from_absolute_zero;
    if (walk.options.table != nullptr) {
      // Nothing is made where a machine waits, so that it may be beyond the table's map.
      stop.actual = walk.options.table->nearest_command_for(*stop.actual);
      stop.from_absolute_zero = *stop.actual - walk.options.absolute_zero;
    }
    walk.modal.user = {AxisUser::Lost, AxisUser::Lost};
  }
  walk.emitter.put(block.line, stop);
}

void end_program(Walk& walk, const Block& block, std::span<const Word> words, StopKind kind) {
  if (walk.is_in_copies()) {
    return walk.reporter.report(
        Code::CommandMisplaced,
        block.first(),
        walk.in_pattern ? "M01 and M08 before the end" : "the end in the program itself");
  }
  walk.ended = true;
  walk.has_end = true;
  if (!is_whole_end(walk, block, words)) {
    walk.reporter.report_end_missing(walk.program.source.bytes,
                                     end_codes(walk) + " and a line end");
  }
  if (refuse_while_plunged(walk, block)) return;
  walk.vision.end_program(block.line);
  stop(walk, block, words, kind);
}

/// The text stops and no M30 or M00 came. A header, pattern, cycle or contour that is open then is
/// an error of its own.
void end_without_mark(Walk& walk) {
  const int line = walk.cursor.line_number();
  refuse_pending(walk, line, "the end of the program");
  if (walk.is_plunged) {
    walk.reporter.report(Code::ToolPlunged,
                         line,
                         0,
                         "the program ends while the router is down",
                         "M16 or M17 before it");
  }
  walk.vision.end_program(line);
  if (walk.vision.must_stop()) return;
  const bool is_empty = walk.text.find_first_not_of(" \t\r\n") == walk.text.npos;
  const bool is_complete = ends_in_line_end(walk.text) && !is_empty;
  // As the source has it, unless that is nothing but NUL characters.
  const std::string_view written =
      is_empty ? walk.text : std::string_view(walk.program.source.bytes);
  if (!walk.program.reading.accepts_unterminated || !is_complete) {
    return walk.reporter.report_end_missing(written, end_codes(walk));
  }
  walk.reporter.report(Code::EndAccepted,
                       line,
                       0,
                       quoted(last_line(written).text) + " is the last line",
                       end_codes(walk));
  walk.emitter.put(line - 1, Stop{.kind = StopKind::EndAccepted});
}

/// G04X#: one millisecond per increment of the format; below 1 s, above 10 s or missing is 10 s.
void dwell(Walk& walk, const Block& block) {
  MotionWords words;
  if (!read_words(walk, block, block.all().subspan(1), "X", words)) return;
  constexpr double kLeast_s = 1;
  constexpr double kMost_s = 10;
  const double time_s = words.xy_mm[0].value_or(0) / rounding_mm(walk) / 1000;
  const bool is_usable = time_s >= kLeast_s - 1e-9 && time_s <= kMost_s + 1e-9;
  walk.emitter.put(block.line, Dwell{seconds(is_usable ? time_s : kMost_s)});
}

void message(Walk& walk, const Block& block) {
  constexpr std::size_t kShown = 20;
  if (!is_alone(walk, block)) return;
  if (block.argument.size() > kShown) {
    walk.reporter.report(Code::MessageTooLong,
                         block.line,
                         block.argument_column + static_cast<int>(kShown),
                         quoted(block.argument),
                         "at most 20 characters, or M45");
  }
  walk.emitter.put(block.line, Message{block.argument});
}

/// `M45,text\` goes on in the next lines until one has no backslash at its end.
void long_message(Walk& walk, const SourceLine& line) {
  constexpr std::size_t kShown = 78;
  refuse_pending(walk, line.number, "M45");
  std::string text;
  SourceLine part = line;
  part.text.remove_prefix(part.text.find(',') + 1);
  while (true) {
    const bool more = is_continued(part.text);
    const std::string_view shown =
        more ? part.text.substr(0, part.text.find_last_of('\\')) : part.text;
    if (shown.size() > kShown) {
      walk.reporter.report(
          Code::MessageTooLong, part.number, quoted(shown), "at most 78 characters a line");
    }
    text += shown;
    if (!more) break;
    if (walk.cursor.at_end()) {
      return walk.reporter.report(
          Code::ArgumentInvalid, part, "one more line behind the backslash");
    }
    text += '\n';
    part = walk.cursor.next();
  }
  walk.emitter.put(line.number, Message{text, true});
}

void text_offset(Walk& walk, const SourceLine& line) {
  const auto comma = line.text.find(',');
  if (comma == std::string_view::npos) {
    return walk.pass_on(line.number, line.text);  // only shows the offset
  }
  Eigen::Vector2d offset_mm = walk.modal.text_offset.in_mm();
  const std::string_view value = line.text.substr(comma + 1);
  const auto done = read_text_offset(value, walk.format(), offset_mm);
  if (done) {
    walk.modal.text_offset = displacement_mm<frame::Programmed>(offset_mm);
    walk.has_dimension = true;
    return;
  }
  walk.reporter.report(Code::ArgumentInvalid,
                       line.number,
                       line.column + static_cast<int>(comma) + 1,
                       quoted(value),
                       done.error());
}

void function(Walk& walk, const Block& block, FunctionKind kind) {
  if (!is_alone(walk, block)) return;
  if (kind == FunctionKind::SpindleGroup && block.argument != "OFF" &&
      !parse_count(block.argument)) {
    return walk.reporter.report(Code::ArgumentInvalid, block.first(), "M96,# or M96,OFF");
  }
  walk.emitter.put(block.line, Function{.kind = kind, .text = block.text});
}

/// With [reference_scaling] known the holes come out scaled and the machine must not do it again;
/// without, the order goes to the machine.
void switch_scaling(Walk& walk, const Block& block, bool is_on) {
  walk.place.is_scaled = is_on;
  const bool is_ours = walk.options.scaling.has_value();
  if (!is_ours && is_on) {
    walk.reporter.report(Code::ScalingUnknown,
                         block,
                         " is passed on to the machine",
                         "[reference_scaling] in machine.toml");
  }
  walk.emitter.put(block.line,
                   Function{.kind = is_on ? FunctionKind::ScalingOn : FunctionKind::ScalingOff,
                            .text = is_ours ? std::string_view() : block.text});
}

}  // namespace panelcal::excellon
