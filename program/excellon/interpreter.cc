// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/excellon/interpreter.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace panelcal::excellon {
namespace {

std::string text_of(const Word& word) {
  return word.letter + std::string(word.number);
}

/// Commands that do not run yet are refused by name, with whatever follows them.
bool takes_arguments(const Word& word) {
  const auto number = parse_count(word.number);
  const auto command = number ? find_command(word.letter, *number) : std::nullopt;
  return command &&
         (!info(*command).runs || info(*command).operands.find(',') != std::string_view::npos);
}

}  // namespace

Interpreter::Interpreter(const Program& program,
                         const WalkOptions& options,
                         Survey& survey,
                         MeasurementSource* source,
                         OperationSink* sink,
                         DiagnosticLog& log)
    : program_(program),
      options_(options),
      sink_(sink),
      reporter_(program.source.file, log),
      vision_(options, survey, source, reporter_, log),
      cursor_(program.source.bytes, program.header.body),
      format_(program.header.format),
      work_zero_(options.absolute_zero +
                 displacement_mm<frame::Machine>(options.work_zero.in_mm())) {
  modal_.incremental = program.header.incremental;
}

void Interpreter::run() {
  pass_on_header();
  while (!cursor_.at_end() && !ended_) run_line(cursor_.next());
  if (has_end_) return check_rest();
  if (ended_) return;
  vision_.end_program(cursor_.line_number());
  if (sink_ == nullptr && !vision_.must_stop()) {
    reporter_.report(
        Code::EndMissing, cursor_.line_number(), 0, "the program has no end", "M30 or M00");
  }
}

void Interpreter::pass_on_header() {
  for (const HeaderSetting& setting : program_.header.settings) {
    put(setting.line, Setting{setting.text, SettingKind::Header});
  }
}

/// Says once if anything but line ends and a rewind mark follows the end of the program.
void Interpreter::check_rest() {
  if (sink_ != nullptr || vision_.must_stop()) return;
  while (!cursor_.at_end()) {
    const SourceLine line = cursor_.next();
    const LineKind kind = kind_of(line.text);
    if (kind == LineKind::Empty || kind == LineKind::PatternMark) continue;
    return reporter_.report(
        Code::TextAfterEnd, line.number, 1, quoted(line.text), "nothing behind the end");
  }
}

void Interpreter::run_line(const SourceLine& line) {
  switch (kind_of(line.text)) {
    case LineKind::Empty:
      return;
    case LineKind::PatternMark:
      return run_section(line.number);
    case LineKind::KeyboardOrder:
      vision_.keyboard_order(line, format_);
      return put(line.number, Setting{line.text, SettingKind::Vision});
    case LineKind::BlockDelete: {
      const auto slash = line.text.find('/');
      if (line.text.find_first_not_of(" \t", slash + 1) == std::string_view::npos) {
        return put(line.number, Setting{line.text.substr(slash, 1)});  // clears tool links
      }
      if (program_.header.deletes_blocks) return;
      reporter_.report(Code::NotSupported,
                       line.number,
                       static_cast<int>(slash) + 1,
                       quoted(line.text) + ": block delete without BLKD is not supported yet");
      return;
    }
    case LineKind::Words:
      run_words(line);
      break;
  }
  if (vision_.must_stop()) ended_ = true;
}

void Interpreter::run_words(const SourceLine& line) {
  if (is_tool_link(line.text)) {
    return put(line.number, Setting{line.text});  // tool links
  }
  Block block;
  if (const auto fault = lex(line, block)) {
    reporter_.report(Code::BlockSyntax,
                     line.number,
                     fault->column,
                     quoted(fault->text),
                     std::string(fault->expected));
    return;
  }
  if (block.n_words == 0) {
    reporter_.report(Code::BlockSyntax, line.number, block.column, quoted(block.text), "a command");
    return;
  }
  const Word& first = block.words[0];
  if (block.arguments_column != 0 && !takes_arguments(first)) {
    reporter_.report(
        Code::BlockNotAlone,
        block.line,
        block.arguments_column - 1,
        quoted("," + std::string(block.arguments)) + " behind " + quoted(text_of(first)),
        "no comma in this block");
    return;
  }
  switch (first.letter) {
    case 'X':
    case 'Y':
      return drill_coordinate(block);
    case 'R':
      return repeat_hole(block);
    case 'T':
      return select_tool(block);
    case 'G':
    case 'M':
      break;
    case 'F':
    case 'S':
    case 'A':
    case 'I':
    case 'J':
    case 'P':
    case 'B':
    case 'C':
    case 'H':
    case 'Z':
      reporter_.report(Code::NotSupported,
                       block.line,
                       first.column,
                       quoted(text_of(first)) + " in a block of its own is not supported yet");
      return;
    default:
      reporter_.report(Code::CommandUnknown,
                       block.line,
                       first.column,
                       quoted(text_of(first)),
                       "X, Y, G, M, T or R");
      return;
  }
  const auto number = parse_count(first.number);
  const auto command = number ? find_command(first.letter, *number) : std::nullopt;
  if (!command) return report(Code::CommandUnknown, block, first, "a code of the manual's table");
  run_command(block, first, *command);
}

void Interpreter::run_command(const Block& block, const Word& word, Command command) {
  if (!info(command).runs) {
    reporter_.report(Code::NotSupported,
                     block.line,
                     word.column,
                     quoted(text_of(word)) + " (" + std::string(info(command).section) +
                         ") is not supported yet");
    return;
  }
  switch (command) {
    case Command::BeginPattern:
      if (is_alone(block)) run_section(block.line);
      return;
    case Command::EndOfPattern:
    case Command::RepeatPattern:
    case Command::EndOfRepeat:
    case Command::SwapAxes:
    case Command::MirrorX:
    case Command::MirrorY:
      return report(Code::CommandMisplaced, block, word, "a step and repeat section opened by M25");
    case Command::SelectVisionTool:
      if (is_alone(block)) vision_.select_tool(block, format_);
      return;
    case Command::BaseOffset:
    case Command::BaseSeries:
    case Command::HoleAtTarget:
    case Command::NestedOffset:
    case Command::NestedSeries:
    case Command::NestedHoleAtTarget:
      return measure(block, command);
    case Command::SetZero:
      return set_zero(block);
    case Command::OperatorMessage:
      if (is_alone(block)) put(block.line, Message{block.arguments});
      return;
    case Command::StoreCorrections:
    case Command::RewindCorrections:
    case Command::AdvanceCorrections:
      return stored_label(block, command);
    case Command::EndNoRewind:
      return end_program(block, block.all().subspan(1), StopKind::EndNoRewind);
    case Command::EndRewind:
      return end_program(block, block.all().subspan(1), StopKind::EndRewind);
    default:
      return run_without_operands(block, command);
  }
}

void Interpreter::run_without_operands(const Block& block, Command command) {
  if (!is_alone(block)) return;
  switch (command) {
    case Command::DrillMode:
      return put(block.line, Setting{block.text});
    case Command::Absolute:
      modal_.incremental = false;
      return;
    case Command::Incremental:
      modal_.incremental = true;
      return;
    case Command::Metric:
      return set_unit(block, LengthUnit::Millimeter);
    case Command::Inch:
      return set_unit(block, LengthUnit::Inch);
    case Command::CancelBase:
      return vision_.cancel_base(block.line);
    case Command::CancelNested:
      return vision_.cancel_nested(block.line);
    default:
      // A table row that says Runs without a handler: our own mistake, never the user's.
      report(Code::Internal, block, block.words[0], "a handler for this command");
  }
}

// --- step and repeat ---------------------------------------------------------------------------

void Interpreter::run_section(int line) {
  if (in_pattern_) {
    reporter_.report(
        Code::CommandMisplaced, line, 1, "a pattern begins inside a pattern", "M01 and M08 first");
    return;
  }
  const auto section = scan_section(cursor_, line, format_, reporter_);
  if (!section) {
    ended_ = true;
    return;
  }
  pattern_start_ = modal_;
  in_pattern_ = true;
  path_.assign(section->levels.size(), 0);
  run_level(*section, section->levels.size(), Transform<frame::Nominal, frame::Nominal>());
  in_pattern_ = false;
  path_.clear();
  placement_ = Placement();
  if (ended_) return;
  end_section(*section);
}

/// The manual clears the incremental accumulators at M08, back to work zero. It does not say what
/// an omitted axis means then in absolute mode, so that is refused (AxisUser::Cleared).
void Interpreter::end_section(const RepeatSection& section) {
  vision_.end_section(section.closing.line);
  modal_ = Modal{.user = {AxisUser::Cleared, AxisUser::Cleared}, .incremental = modal_.incremental};
  cursor_ = section.after;

  if (section.closing.n_words == 1) return;
  const Word& second = section.closing.words[1];
  const auto number = parse_count(second.number);
  const auto command = number ? find_command(second.letter, *number) : std::nullopt;
  if (command != Command::EndRewind && command != Command::EndNoRewind) {
    return report(Code::BlockNotAlone, section.closing, second, "M08 alone or with M30");
  }
  end_program(section.closing,
              section.closing.all().subspan(2),
              command == Command::EndRewind ? StopKind::EndRewind : StopKind::EndNoRewind);
}

/// Runs everything below `level` once in place and once for every copy that the level asks for.
void Interpreter::run_level(const RepeatSection& section,
                            std::size_t level,
                            const Transform<frame::Nominal, frame::Nominal>& outer) {
  if (level == 0) return run_pattern(section, outer);
  // levels[] is innermost first, the path outermost first.
  const std::size_t depth = section.levels.size() - level;
  path_[depth] = 0;
  run_level(section, level - 1, outer);
  // Checking needs the copies only where they measure.
  if (sink_ == nullptr && !section.has_vision) return;

  Eigen::Vector2d offset_mm = Eigen::Vector2d::Zero();
  for (const CopyRun& run : section.levels[level - 1]) {
    if (run.restarts) offset_mm.setZero();
    const Eigen::Matrix2d orientation = copy_orientation(run);
    for (int i = 0; i < run.count && !ended_; ++i) {
      offset_mm += run.step.in_mm();
      ++path_[depth];
      run_level(section,
                level - 1,
                outer * Transform<frame::Nominal, frame::Nominal>(orientation, offset_mm));
    }
  }
}

void Interpreter::run_pattern(const RepeatSection& section,
                              const Transform<frame::Nominal, frame::Nominal>& place) {
  if (ended_) return;
  placement_ = Placement(place.linear(), place.translation());
  modal_ = pattern_start_;
  vision_.begin_instance();
  LineCursor line = section.pattern;
  if (line.offset() == section.pattern_end) count_idle_line(section.line);
  while (line.offset() < section.pattern_end && !ended_) {
    const int number = line.line_number();
    const std::int64_t n_before = n_operations_;
    run_line(line.next());
    if (n_operations_ == n_before) count_idle_line(number);
  }
  vision_.end_instance(line.line_number());
}

}  // namespace panelcal::excellon
