// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/interpreter/interpreter.h"

#include <algorithm>
#include <string>
#include <utility>

#include "program/excellon/text/header_words.h"

namespace panelcal::excellon {
namespace {

bool takes_arguments(std::optional<Command> command) {
  return command && info(*command).operands.find(',') != std::string_view::npos;
}

/// Keyboard orders with lengths: `$uvis,searcharea,2`, `$uvis,focus,x1y2`.
bool has_vision_length(std::string_view order) {
  return order.find(",searcharea") != order.npos || order.find(",focus") != order.npos;
}

Placement excellon_placement(int version) {
  return {axis_orientation(version), Eigen::Vector2d::Zero()};
}

}  // namespace

Interpreter::Interpreter(const Program& program,
                         const WalkOptions& options,
                         Survey& survey,
                         MeasurementSource* source,
                         OperationSink* sink,
                         DiagnosticLog& log,
                         TrialExecution* trial)
    : program_(program),
      header_(header_of(program)),
      text_(text_of(program)),
      options_(options),
      trial_(trial),
      reporter_(
          program.source.file,
          log,
          sink == nullptr || trial != nullptr ? Reporter::Level::All : Reporter::Level::ErrorsOnly,
          trial == nullptr ? nullptr : &trial->working_log),
      vision_(options, survey, source, reporter_, log),
      emitter_(header_.tools, options, place_, vision_.corrections(), reporter_, sink),
      set_(header_.set),
      deletes_blocks_(program.deletes_blocks()),
      cursor_(text_, header_.body),
      stated_(header_.stated),
      plain_(header_.format()),
      axes_(excellon_placement(program.axis_version())),
      frame_(axes_),
      body_rules_(header_.body_rules),
      has_dimension_(header_.has_dimension) {
  modal_.incremental = header_.incremental;
  modal_.text_offset = header_.text_offset;
  place_.placement = frame_;
  place_.is_scaled = options.scaling && options.scaling->starts_enabled;
  const auto correction = header_.zero_correction;
  const auto zero = [this](const Displacement<frame::Programmed>& d) {
    return displacement_mm<frame::Machine>(frame_(d).in_mm());
  };
  place_.work_zero =
      options.absolute_zero +
      (correction ? zero(*correction) : displacement_mm<frame::Machine>(options.work_zero.in_mm()));
  if (header_.zero_set) place_.work_zero = place_.work_zero + zero(*header_.zero_set);
}

void Interpreter::end_at(std::size_t offset) {
  ends_early_ = true;
  cursor_ = LineCursor(text_.substr(0, offset), header_.body);
}

void Interpreter::run() {
  pass_on_header();
  while (!cursor_.at_end() && !has_ended()) {
    if (!run_plain_lines(cursor_.text().size())) run_line(cursor_.next());
  }
  if (has_end_) return check_rest();
  if (has_ended() || ends_early_) return;
  end_without_mark();
}

void Interpreter::pass_on_header() {
  for (const HeaderSetting& setting : header_.settings) {
    if (is_tool_link(setting.text)) emitter_.links().link(setting.text);
    if (setting.text == "/") emitter_.links().clear();
    pass_on(setting.line, setting.text, SettingKind::Header);
  }
  if (header_.zero_set) {
    emitter_.put(header_.end_line > 0 ? header_.end_line : header_.zero_line,
                 ZeroSet{displacement_mm<frame::Machine>(frame_(*header_.zero_set).in_mm()),
                         place_.work_zero});
  }
  if (header_.stops_at_end) emitter_.put(header_.end_line, Stop{.kind = StopKind::HeaderEnd});
}

/// As the source has it, not as it was respelled: places are the same in both.
std::string_view Interpreter::as_written(std::string_view part) const {
  const auto offset = static_cast<std::size_t>(part.data() - text_.data());
  return std::string_view(program_.source.bytes).substr(offset, part.size());
}

/// Says once if anything but line ends and a rewind mark follows the end of the program.
void Interpreter::check_rest() {
  if (vision_.must_stop()) return;
  while (!cursor_.at_end()) {
    const SourceLine line = cursor_.next();
    const LineKind kind = kind_of(line.text);
    if (kind == LineKind::Empty || kind == LineKind::PatternMark) continue;
    return reporter_.report(Code::TextAfterEnd,
                            line.number,
                            1,
                            quoted(as_written(line.text)),
                            "nothing behind the end");
  }
}

// --- lines -------------------------------------------------------------------------------------

/// A refused line may have said where the axes are: those behind it are not blamed for what it
/// leaves open.
void Interpreter::run_line(const SourceLine& line) {
  n_refused_ = reporter_.n_refused();
  read_line(line);
  if (std::exchange(n_refused_, reporter_.n_refused()) == reporter_.n_refused()) return;
  modal_.user = {AxisUser::None, AxisUser::None};
  modal_.begins_pattern = false;
}

void Interpreter::read_line(const SourceLine& line) {
  switch (kind_of(line.text)) {
    case LineKind::Empty:
      return check_comment(line);
    case LineKind::PatternMark:
      run_section(line.number);
      break;
    case LineKind::KeyboardOrder:
      has_dimension_ |= has_vision_length(line.text);
      vision_.keyboard_order(line,
                             format(),
                             {.line = line.number,
                              .file = std::string(place_.pattern.path),
                              .file_sha256 = std::string(place_.pattern.sha256),
                              .path = place_.path,
                              .nominal = {},
                              .placement = {},
                              .work_zero = place_.work_zero});
      pass_on_vision(line.number, line.text);
      break;
    case LineKind::BlockDelete:
      run_slashed(line);
      break;
    case LineKind::Words:
      run_words(line);
      break;
  }
  emitter_.stop_after(trial_);
  const bool is_of_program = !in_pattern_ && !in_stored_pattern_;
  if (is_of_program && std::exchange(n_vision_steps_, vision_.n_steps()) != vision_.n_steps()) {
    asked_until_ = cursor_.offset();
  }
  if (vision_.must_stop()) ended_ = true;
}

/// The short way for what nearly every line is: a hole at absolute coordinates that both passes
/// know. Everything else, and every doubt, goes the long way. No hole changes what decides this.
bool Interpreter::run_plain_lines(std::size_t end) {
  if (modal_.motion != Motion::Drill || modal_.incremental || modal_.begins_pattern || pending_ ||
      steps_comment_ || modal_.user[0] != AxisUser::Work || modal_.user[1] != AxisUser::Work ||
      !vision_.may_drill() || !has_working_tool()) {
    return false;
  }
  const auto drill = [this](int line, const PlainCoordinate& block) {
    if (emitter_.is_over_limit()) return false;
    const Eigen::Vector2d at_mm = block.from(modal_.at_mm);
    modal_.at_mm = at_mm;
    modal_.has_hole = true;
    emitter_.drill(line, at_mm);
    return true;
  };
  if (emitter_.is_executing()) return plain_.read_lines(cursor_, end, drill);
  return plain_.read_lines(
      cursor_, end, drill, [this](std::int64_t n) { return emitter_.count_unseen(n); });
}

/// `/` alone clears the tool links; in front of a block it is block delete.
void Interpreter::run_slashed(const SourceLine& line) {
  const SourceLine rest = without_slash(line);
  if (kind_of(rest.text) == LineKind::Empty) {
    if (rest.text.find(';') != std::string_view::npos) return;  // a comment left out
    emitter_.links().clear();
    return emitter_.put(line.number, Setting{"/"});
  }
  if (deletes_blocks_) {
    if (is_long_message(rest.text)) skip_message(cursor_, rest.text);
    return;
  }
  const bool is_stated = header_.block_delete || program_.reading.block_delete;
  if (!is_stated && !std::exchange(warned_slash_, true)) {
    reporter_.report(Code::BlockDeleteAssumed,
                     line.number,
                     line.column,
                     quoted(line.text),
                     "BLKD,ON or BLKD,OFF in the header");
  }
  if (kind_of(rest.text) == LineKind::BlockDelete) {
    return reporter_.report(
        Code::BlockSyntax, rest.number, rest.column, quoted(line.text), "one slash");
  }
  run_line(rest);
}

void Interpreter::run_words(const SourceLine& whole) {
  if (is_long_message(whole.text)) return long_message(whole);
  const SourceLine line = without_blanks(whole);
  if (is_tool_link(line.text)) {
    emitter_.links().link(line.text);
    return emitter_.put(line.number, Setting{line.text});
  }
  constexpr std::string_view kTextOffset = "CAN_TEXT_OFF";
  if (line.text.starts_with(kTextOffset)) return text_offset(line);
  if (is_header_word(line.text)) return header_word(line);
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
  const auto i_second = second_block(block);
  if (!i_second) return run_block(block);
  const Block begin = part_of(block, 0, *i_second);
  const Block end = part_of(block, *i_second, block.n_words);
  if (!std::exchange(warned_split_, true)) {
    reporter_.report(
        Code::NotationAccepted,
        block.line,
        block.column,
        quoted(block.text) + " is read as " + quoted(begin.text) + " and " + quoted(end.text),
        "two blocks");
  }
  run_block(begin);
  if (!has_ended()) run_block(end);
}

/// The first word of what should be a block of its own: X and Y behind T# or G05, M06 behind T#,
/// and the end of the program behind X and Y. In another order the manual has another meaning for
/// them, as for M30X#Y#.
std::optional<std::size_t> Interpreter::second_block(const Block& block) const {
  if (block.arguments_column != 0 || block.n_words < 2) return std::nullopt;
  const auto is_place = [&](std::size_t begin, std::size_t end) {
    return begin < end && std::ranges::all_of(block.all().subspan(begin, end - begin), [](auto& w) {
             return w.letter == 'X' || w.letter == 'Y';
           });
  };
  const std::size_t n = block.n_words;
  const Word& first = block.words[0];
  const Word& last = block.words[n - 1];
  if (first.letter == 'T') {
    constexpr std::string_view kData = "CFSBHZ";
    std::size_t i = 1;
    while (i < n && kData.find(block.words[i].letter) != std::string_view::npos) ++i;
    const bool is_stop = i + 1 == n && command(last) == Command::OptionalStop;
    return is_stop || is_place(i, n) ? std::optional(i) : std::nullopt;
  }
  if (command(first) == Command::DrillMode && first.number == "05" && is_place(1, n)) return 1;
  const auto code = command(last);
  const bool ends = code == Command::EndRewind || code == Command::EndNoRewind;
  return ends && is_place(0, n - 1) ? std::optional(n - 1) : std::nullopt;
}

void Interpreter::run_block(const Block& block) {
  const Word& first = block.words[0];
  if (block.arguments_column != 0 && !takes_arguments(command(first))) {
    reporter_.report(Code::BlockNotAlone,
                     block.line,
                     block.arguments_column - 1,
                     quoted("," + std::string(block.arguments)) + " behind " + quoted(first.text()),
                     "no comma in this block");
    return;
  }
  if (first.letter != 'X' && first.letter != 'Y') refuse_pending(block.line, block.text);
  switch (first.letter) {
    case 'X':
    case 'Y':
      return coordinate(block);
    case 'A':
    case 'I':
    case 'J':
      return move_or_rout(block, block.all());
    case 'R':
      return repeat_hole(block);
    case 'P':
      return repeat_pattern(block);
    case 'T':
      return select_tool(block);
    case 'F':
    case 'B':
      return rate(block);
    case 'G':
    case 'M':
      return run_code(block);
    case 'S':
    case 'C':
    case 'H':
    case 'Z':
      return report(Code::BlockNotAlone, block, first, "T# before it, in the same block");
    default:
      reporter_.report(Code::CommandUnknown,
                       block.line,
                       first.column,
                       quoted(first.text()),
                       "X, Y, G, M, T, R, P, F or B");
  }
}

void Interpreter::run_code(const Block& block) {
  const auto known = command(block.words[0]);
  if (known) return run_command(block, *known);
  report(Code::CommandUnknown,
         block,
         block.words[0],
         set_ == ProgramSet::FormatOne ? "a code of the manual's Format One (FMAT,1)"
                                       : "a code that `panelcal help excellon` lists");
}

void Interpreter::run_command(const Block& block, Command command) {
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
      return report(
          Code::CommandMisplaced, block, block.words[0], "a step and repeat section opened by M25");
    case Command::HeaderStart:
    case Command::HeaderEnd:
      return report(Code::CommandMisplaced, block, block.words[0], "one header, at the beginning");
    case Command::RoutMode:
      return start_motion(block, Motion::Rapid);
    case Command::LinearMove:
      return start_motion(block, Motion::Line);
    case Command::ClockwiseMove:
      return start_motion(block, Motion::Clockwise);
    case Command::CounterclockwiseMove:
      return start_motion(block, Motion::Counterclockwise);
    case Command::CircleClockwise:
    case Command::CircleCounterclockwise:
      return routed_circle(block, command);
    case Command::CannedCircle:
    case Command::CannedSlot:
    case Command::RoutedStepSlot:
      return report(Code::CoordinateMissing,
                    block,
                    block.words[0],
                    std::string(info(command).operands) + ", the first place before the code");
    case Command::DualInLine1:
    case Command::DualInLine:
    case Command::EightPin:
    case Command::TextX:
    case Command::TextY:
    case Command::StoredPattern:
      return begin_cycle(block, command);
    case Command::SelectVisionTool:
      return select_vision_tool(block);
    case Command::BaseOffset:
    case Command::BaseSeries:
    case Command::HoleAtTarget:
    case Command::NestedOffset:
    case Command::NestedSeries:
    case Command::NestedHoleAtTarget:
      return measure(block, command);
    case Command::Autocalibration:
      return autocalibration(block);
    case Command::SetZero:
      return set_zero(block);
    case Command::Dwell:
      return dwell(block);
    case Command::OperatorMessage:
      return message(block);
    case Command::LongMessage:  // with its comma it would have been read as one
      return report(Code::ArgumentInvalid, block, block.words[0], "M45,text");
    case Command::StoreCorrections:
    case Command::RewindCorrections:
    case Command::AdvanceCorrections:
      return stored_label(block, command);
    case Command::InspectionStop:
      return stop(block, block.all().subspan(1), StopKind::Inspection);
    case Command::OptionalStop:
      return stop(block, block.all().subspan(1), StopKind::Optional);
    case Command::EndNoRewind:
      return end_program(block, block.all().subspan(1), StopKind::EndNoRewind);
    case Command::EndRewind:
      return end_program(block, block.all().subspan(1), StopKind::EndRewind);
    case Command::BinaryMap:
      return function(block, FunctionKind::BinaryMap);
    case Command::SpindleGroup:
      return function(block, FunctionKind::SpindleGroup);
    default:
      return run_without_operands(block, command);
  }
}

void Interpreter::run_without_operands(const Block& block, Command command) {
  if (!is_alone(block)) return;
  switch (command) {
    case Command::DrillMode:
      // Not as written: Format One's G81 would be another command in Format Two.
      if (drill_mode(block)) emitter_.put(block.line, Setting{"G05"});
      return;
    case Command::OverrideFeedSpeed:
      body_rates_ = true;
      return pass_on(block.line, block.text);
    case Command::CompensationOff:
      return switch_compensation(block, CompensationSide::Off);
    case Command::CompensationLeft:
      return switch_compensation(block, CompensationSide::Left);
    case Command::CompensationRight:
      return switch_compensation(block, CompensationSide::Right);
    case Command::PlungeDepthControlled:
      return plunge(block, PlungeKind::Contouring);
    case Command::Plunge:
      return plunge(block, PlungeKind::Plain);
    case Command::RetractClamping:
      return retract(block, true);
    case Command::Retract:
      return retract(block, false);
    case Command::Absolute:
    case Command::Incremental:
      modal_.incremental = command == Command::Incremental;
      steps_comment_.reset();
      return;
    case Command::Metric:
      return set_unit(block, LengthUnit::Millimeter);
    case Command::Inch:
      return set_unit(block, LengthUnit::Inch);
    case Command::CancelBase:
    case Command::CancelNested:
      return cancel_correction(block, command);
    case Command::ToolTipCheck:
      return function(block, FunctionKind::ToolTipCheck);
    case Command::PeckOn:
      return function(block, FunctionKind::PeckOn);
    case Command::PeckOff:
      return function(block, FunctionKind::PeckOff);
    case Command::ScalingOn:
      return switch_scaling(block, true);
    case Command::ScalingOff:
      return switch_scaling(block, false);
    default:
      // A table row without a handler: our own mistake, never the user's.
      report(Code::Internal, block, block.words[0], "a handler for this command");
  }
}

}  // namespace panelcal::excellon
