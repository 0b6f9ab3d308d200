// SPDX-License-Identifier: Apache-2.0
// Stops, dwells, messages, and events that are the machine's own.
#include <string>
#include <utility>

#include "program/excellon/interpreter/interpreter.h"
#include "program/excellon/text/header_words.h"

namespace panelcal::excellon {

/// M00, M06, M09, M30 with (X#Y#): the place is relative to absolute zero.
void Interpreter::stop(const Block& block, std::span<const Word> words, StopKind kind) {
  if (refuse_while_plunged(block)) return;
  MotionWords read;
  if (!read_words(block, words, "XY", read)) return;
  Stop stop{.kind = kind};
  if (read.xy_mm[0].has_value() != read.xy_mm[1].has_value()) {
    // The manual does not say where the other axis goes.
    return report(Code::CoordinateMissing, block, words.front(), "both X and Y, or neither");
  }
  if (read.xy_mm[0]) {
    const auto place = displacement_mm<frame::Programmed>(*read.xy_mm[0], *read.xy_mm[1]);
    stop.from_absolute_zero = displacement_mm<frame::Machine>(axes_(place).in_mm());
    stop.actual = options_.absolute_zero + *stop.from_absolute_zero;
    if (options_.table != nullptr) {
      // Nothing is made where a machine waits, so that it may be beyond the table's map.
      stop.actual = options_.table->nearest_command_for(*stop.actual);
      stop.from_absolute_zero = *stop.actual - options_.absolute_zero;
    }
    modal_.user = {AxisUser::Lost, AxisUser::Lost};
  }
  emitter_.put(block.line, stop);
}

void Interpreter::end_program(const Block& block, std::span<const Word> words, StopKind kind) {
  if (in_pattern_ || in_stored_pattern_) {
    return report(Code::CommandMisplaced,
                  block,
                  block.words[0],
                  in_pattern_ ? "M01 and M08 before the end" : "the end in the program itself");
  }
  ended_ = true;
  has_end_ = true;
  if (!is_whole_end(block, words)) {
    reporter_.report_end_missing(program_.source.bytes, end_codes() + " and a line end");
  }
  if (refuse_while_plunged(block)) return;
  vision_.end_program(block.line);
  stop(block, words, kind);
}

/// A text that stops in its last line may have been cut off there: `M0` comes of M08, `M30X1` of
/// M30X10. Only the end by itself needs no line end.
bool Interpreter::is_whole_end(const Block& block, std::span<const Word> words) const {
  if (cursor_.offset() < text_.size() || ends_in_line_end(text_)) return true;
  return words.empty() && block.words[block.n_words - 1].number.size() == 2;
}

std::string Interpreter::end_codes() const {
  return set_ == ProgramSet::FormatOne ? "M30 or M02" : "M30 or M00";
}

/// The text stops and no M30 or M00 came. A header, pattern, cycle or contour that is open then is
/// an error of its own.
void Interpreter::end_without_mark() {
  const int line = cursor_.line_number();
  refuse_pending(line, "the end of the program");
  if (is_plunged_) {
    reporter_.report(Code::ToolPlunged,
                     line,
                     0,
                     "the program ends while the router is down",
                     "M16 or M17 before it");
  }
  vision_.end_program(line);
  if (vision_.must_stop()) return;
  const bool is_empty = text_.find_first_not_of(" \t\r\n") == text_.npos;
  const bool is_complete = ends_in_line_end(text_) && !is_empty;
  // As the source has it, unless that is nothing but NUL characters.
  const std::string_view written = is_empty ? text_ : std::string_view(program_.source.bytes);
  if (!program_.reading.accepts_unterminated || !is_complete) {
    return reporter_.report_end_missing(written, end_codes());
  }
  reporter_.report(Code::EndAccepted,
                   line,
                   0,
                   quoted(last_line(written).text) + " is the last line",
                   end_codes());
  emitter_.put(line - 1, Stop{.kind = StopKind::EndAccepted});
}

/// G04X#: one millisecond per increment of the format; below 1 s, above 10 s or missing is 10 s.
void Interpreter::dwell(const Block& block) {
  MotionWords words;
  if (!read_words(block, block.all().subspan(1), "X", words)) return;
  constexpr double kLeast_s = 1;
  constexpr double kMost_s = 10;
  const double time_s = words.xy_mm[0].value_or(0) / rounding_mm() / 1000;
  const bool is_usable = time_s >= kLeast_s - 1e-9 && time_s <= kMost_s + 1e-9;
  emitter_.put(block.line, Dwell{seconds(is_usable ? time_s : kMost_s)});
}

void Interpreter::message(const Block& block) {
  constexpr std::size_t kShown = 20;
  if (!is_alone(block)) return;
  if (block.arguments.size() > kShown) {
    reporter_.report(Code::MessageTooLong,
                     block.line,
                     block.arguments_column + static_cast<int>(kShown),
                     quoted(block.arguments),
                     "at most 20 characters, or M45");
  }
  emitter_.put(block.line, Message{block.arguments});
}

/// `M45,text\` goes on in the next lines until one has no backslash at its end.
void Interpreter::long_message(const SourceLine& line) {
  constexpr std::size_t kShown = 78;
  refuse_pending(line.number, "M45");
  std::string text;
  SourceLine part = line;
  part.text.remove_prefix(part.text.find(',') + 1);
  while (true) {
    const bool more = is_continued(part.text);
    const std::string_view shown =
        more ? part.text.substr(0, part.text.find_last_of('\\')) : part.text;
    if (shown.size() > kShown) {
      reporter_.report(
          Code::MessageTooLong, part.number, 1, quoted(shown), "at most 78 characters a line");
    }
    text += shown;
    if (!more) break;
    if (cursor_.at_end()) {
      return reporter_.report(Code::ArgumentInvalid,
                              part.number,
                              part.column,
                              quoted(part.text),
                              "one more line behind the backslash");
    }
    text += '\n';
    part = cursor_.next();
  }
  emitter_.put(line.number, Message{text, true});
}

void Interpreter::text_offset(const SourceLine& line) {
  const auto comma = line.text.find(',');
  if (comma == std::string_view::npos) {
    return pass_on(line.number, line.text);  // only shows the offset
  }
  Eigen::Vector2d offset_mm = modal_.text_offset.in_mm();
  const std::string_view value = line.text.substr(comma + 1);
  const auto done = read_text_offset(value, format(), offset_mm);
  if (done) {
    modal_.text_offset = displacement_mm<frame::Programmed>(offset_mm);
    has_dimension_ = true;
    return;
  }
  reporter_.report(Code::ArgumentInvalid,
                   line.number,
                   line.column + static_cast<int>(comma) + 1,
                   quoted(value),
                   done.error());
}

void Interpreter::function(const Block& block, FunctionKind kind) {
  if (!is_alone(block)) return;
  if (kind == FunctionKind::SpindleGroup && block.arguments != "OFF" &&
      !parse_count(block.arguments)) {
    return report(Code::ArgumentInvalid, block, block.words[0], "M96,# or M96,OFF");
  }
  emitter_.put(block.line, Function{.kind = kind, .text = block.text});
}

/// With [reference_scaling] known the holes come out scaled and the machine must not do it again;
/// without, the order goes to the machine.
void Interpreter::switch_scaling(const Block& block, bool is_on) {
  place_.is_scaled = is_on;
  const bool is_ours = options_.scaling.has_value();
  if (!is_ours && is_on) {
    reporter_.report(Code::ScalingUnknown,
                     block.line,
                     block.column,
                     quoted(block.text) + " is passed on to the machine",
                     "[reference_scaling] in machine.toml");
  }
  emitter_.put(block.line,
               Function{.kind = is_on ? FunctionKind::ScalingOn : FunctionKind::ScalingOff,
                        .text = is_ours ? std::string_view() : block.text});
}

}  // namespace panelcal::excellon
