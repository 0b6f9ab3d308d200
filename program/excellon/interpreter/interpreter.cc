// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>
#include <utility>

#include "program/excellon/interpreter/parts.h"
#include "program/excellon/text/header_words.h"

namespace panelcal::excellon {
namespace {

/// As the source has it, not as it was respelled: places are the same in both.
std::string_view source_words(const Walk& walk, std::string_view part) {
  const auto offset = static_cast<std::size_t>(part.data() - walk.text.data());
  return std::string_view(walk.program.source.bytes).substr(offset, part.size());
}

bool takes_arguments(std::optional<Command> command) {
  return command && info(*command).operands.find(',') != std::string_view::npos;
}

/// Keyboard orders with lengths: `$uvis,searcharea,2`, `$uvis,focus,x1y2`.
bool has_vision_length(std::string_view order) {
  return order.find(",searcharea") != order.npos || order.find(",focus") != order.npos;
}

void pass_on_header(Walk& walk) {
  for (const HeaderSetting& setting : walk.header.settings) {
    if (is_tool_link(setting.text)) walk.emitter.links().link(setting.text);
    if (setting.text == "/") walk.emitter.links().clear();
    walk.pass_on(setting.line, setting.text, SettingKind::Header);
  }
  if (walk.header.zero_set) {
    walk.emitter.put(
        walk.header.end_line > 0 ? walk.header.end_line : walk.header.zero_line,
        ZeroSet{displacement_mm<frame::Machine>(walk.frame(*walk.header.zero_set).in_mm()),
                walk.place.work_zero});
  }
  if (walk.header.stops_at_end)
    walk.emitter.put(walk.header.end_line, Stop{.kind = StopKind::HeaderEnd});
}

/// Says once if anything but line ends and a rewind mark follows the end of the program.
void check_rest(Walk& walk) {
  if (walk.vision.must_stop()) return;
  while (!walk.cursor.at_end()) {
    const SourceLine line = walk.cursor.next();
    const LineKind kind = kind_of(line.text);
    if (kind == LineKind::Empty || kind == LineKind::PatternMark) continue;
    return walk.reporter.report(Code::TextAfterEnd,
                                line.number,
                                quoted(source_words(walk, line.text)),
                                "nothing behind the end");
  }
}

/// `/` alone clears the tool links; in front of a block it is block delete.
void run_slashed(Walk& walk, const SourceLine& line) {
  const SourceLine rest = without_slash(line);
  if (kind_of(rest.text) == LineKind::Empty) {
    if (rest.text.find(';') != std::string_view::npos) return;  // a comment left out
    walk.emitter.links().clear();
    return walk.emitter.put(line.number, Setting{"/"});
  }
  if (walk.deletes_blocks) {
    if (is_long_message(rest.text)) skip_message(walk.cursor, rest.text);
    return;
  }
  const bool is_stated = walk.header.block_delete || walk.program.reading.block_delete;
  if (!is_stated && !std::exchange(walk.warned_slash, true)) {
    walk.reporter.report(Code::BlockDeleteAssumed, line, "BLKD,ON or BLKD,OFF in the header");
  }
  if (kind_of(rest.text) == LineKind::BlockDelete) {
    return walk.reporter.report(
        Code::BlockSyntax, rest.number, rest.column, quoted(line.text), "one slash");
  }
  run_line(walk, rest);
}

/// The first word of what should be a block of its own: X and Y behind T# or G05, M06 behind T#,
/// and the end of the program behind X and Y. In another order the manual has another meaning for
/// them, as for M30X#Y#.
std::optional<std::size_t> second_block(const Walk& walk, const Block& block) {
  if (block.argument_column != 0 || block.n_words < 2) return std::nullopt;
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
    const bool is_stop = i + 1 == n && walk.command(last) == Command::OptionalStop;
    return is_stop || is_place(i, n) ? std::optional(i) : std::nullopt;
  }
  if (walk.command(first) == Command::DrillMode && first.number == "05" && is_place(1, n)) return 1;
  const auto code = walk.command(last);
  const bool ends = code == Command::EndRewind || code == Command::EndNoRewind;
  return ends && is_place(0, n - 1) ? std::optional(n - 1) : std::nullopt;
}

void outside_section(Walk& walk, const Block& block) {
  walk.reporter.report(
      Code::CommandMisplaced, block.first(), "a step and repeat section opened by M25");
}

void refuse_second_header(Walk& walk, const Block& block) {
  walk.reporter.report(Code::CommandMisplaced, block.first(), "one header, at the beginning");
}

/// A cycle whose code stands in the middle of its block.
void refuse_begin(Walk& walk, const Block& block, Command command) {
  walk.reporter.report(Code::CoordinateMissing,
                       block.first(),
                       std::string(info(command).operands) + ", the first place before the code");
}

void override_rates(Walk& walk, const Block& block) {
  walk.body_rates = true;
  walk.pass_on(block.line, block.text);
}

void set_incremental(Walk& walk, bool is_on) {
  walk.modal.incremental = is_on;
  walk.steps_comment.reset();
}

/// commands.def has the handler of each.
void run_command(Walk& walk, const Block& block, Command command) {
  switch (command) {
#define EXCELLON_COMMAND(name, letter, number, kind, operands, section, effect, test, handler) \
  case Command::name:                                                                          \
    handler;                                                                                   \
    return;
#include "program/excellon/text/commands.def"
  }
}

void run_code(Walk& walk, const Block& block) {
  const auto known = walk.command(block.words[0]);
  if (known) return run_command(walk, block, *known);
  walk.reporter.report(Code::CommandUnknown,
                       block.first(),
                       walk.set == ProgramSet::FormatOne
                           ? "a code of the manual's Format One (FMAT,1)"
                           : "a code that `panelcal help excellon` lists");
}

void run_block(Walk& walk, const Block& block) {
  const Word& first = block.words[0];
  if (block.argument_column != 0 && !takes_arguments(walk.command(first))) {
    walk.reporter.report(
        Code::BlockNotAlone,
        block.line,
        block.argument_column - 1,
        quoted("," + std::string(block.argument)) + " behind " + quoted(first.text()),
        "no comma in this block");
    return;
  }
  if (first.letter != 'X' && first.letter != 'Y') refuse_pending(walk, block.line, block.text);
  switch (first.letter) {
    case 'X':
    case 'Y':
      return coordinate(walk, block);
    case 'A':
    case 'I':
    case 'J':
      return move_or_rout(walk, block, block.all());
    case 'R':
      return repeat_hole(walk, block);
    case 'P':
      return repeat_pattern(walk, block);
    case 'T':
      return select_tool(walk, block);
    case 'F':
    case 'B':
      return rate(walk, block);
    case 'G':
    case 'M':
      return run_code(walk, block);
    case 'S':
    case 'C':
    case 'H':
    case 'Z':
      return walk.reporter.report(
          Code::BlockNotAlone, block.in(first), "T# before it, in the same block");
    default:
      walk.reporter.report(Code::CommandUnknown, block.of(first), "X, Y, G, M, T, R, P, F or B");
  }
}

void run_words(Walk& walk, const SourceLine& whole) {
  if (is_long_message(whole.text)) return long_message(walk, whole);
  const SourceLine line = without_blanks(whole);
  if (is_tool_link(line.text)) {
    walk.emitter.links().link(line.text);
    return walk.emitter.put(line.number, Setting{line.text});
  }
  constexpr std::string_view kTextOffset = "CAN_TEXT_OFF";
  if (line.text.starts_with(kTextOffset)) return text_offset(walk, line);
  if (is_header_word(line.text)) return header_word(walk, line);
  Block block;
  if (const auto fault = lex(line, block)) {
    walk.reporter.report_syntax(line.number, *fault);
    return;
  }
  if (block.n_words == 0) {
    walk.reporter.report(
        Code::BlockSyntax, line.number, block.column, quoted(block.text), "a command");
    return;
  }
  const auto i_second = second_block(walk, block);
  if (!i_second) return run_block(walk, block);
  const Block begin = part_of(block, 0, *i_second);
  const Block end = part_of(block, *i_second, block.n_words);
  if (!std::exchange(walk.warned_split, true)) {
    walk.reporter.report(Code::NotationAccepted,
                         block,
                         " is read as " + quoted(begin.text) + " and " + quoted(end.text),
                         "two blocks");
  }
  run_block(walk, begin);
  if (!walk.has_ended()) run_block(walk, end);
}

void read_line(Walk& walk, const SourceLine& line) {
  switch (kind_of(line.text)) {
    case LineKind::Empty:
      return check_comment(walk, line);
    case LineKind::PatternMark:
      run_section(walk, line.number);
      break;
    case LineKind::KeyboardOrder:
      walk.has_dimension |= has_vision_length(line.text);
      walk.vision.keyboard_order(line,
                                 walk.format(),
                                 {.line = line.number,
                                  .file = std::string(walk.place.pattern.path),
                                  .file_sha256 = std::string(walk.place.pattern.sha256),
                                  .path = walk.place.path,
                                  .nominal = {},
                                  .placement = {},
                                  .work_zero = walk.place.work_zero});
      walk.pass_on_vision(line.number, line.text);
      break;
    case LineKind::BlockDelete:
      run_slashed(walk, line);
      break;
    case LineKind::Words:
      run_words(walk, line);
      break;
  }
  walk.emitter.stop_after(walk.trial);
  const bool is_of_program = !walk.in_pattern && !walk.in_stored_pattern;
  if (is_of_program &&
      std::exchange(walk.n_vision_steps, walk.vision.n_steps()) != walk.vision.n_steps()) {
    walk.asked_until = walk.cursor.offset();
  }
  if (walk.vision.must_stop()) walk.ended = true;
}

}  // namespace

Walk::Walk(const Program& walked,
           const WalkOptions& walk_options,
           Survey& survey,
           const WalkEnds& ends)
    : program(walked),
      header(header_of(program)),
      text(text_of(program)),
      options(walk_options),
      trial(ends.trial),
      reporter(ends.reporter(program.source.file)),
      vision(options, survey, ends.measurements, reporter, ends.log),
      emitter(header.tools, options, place, vision.corrections(), reporter, ends.sink),
      set(header.set),
      deletes_blocks(program.deletes_blocks()),
      cursor(text, header.body),
      stated(header.stated),
      plain(header.format()),
      axes(axis_orientation(program.axis_version()), Eigen::Vector2d::Zero()),
      frame(axes),
      body_rules(header.body_rules),
      has_dimension(header.has_dimension) {
  modal.incremental = header.incremental;
  modal.text_offset = header.text_offset;
  place.placement = frame;
  place.is_scaled = options.scaling && options.scaling->starts_enabled;
  const auto correction = header.zero_correction;
  const auto zero = [this](const Displacement<frame::Programmed>& d) {
    return displacement_mm<frame::Machine>(frame(d).in_mm());
  };
  place.work_zero =
      options.absolute_zero +
      (correction ? zero(*correction) : displacement_mm<frame::Machine>(options.work_zero.in_mm()));
  if (header.zero_set) place.work_zero = place.work_zero + zero(*header.zero_set);
}

void Walk::end_at(std::size_t offset) {
  ends_early = true;
  cursor = LineCursor(text.substr(0, offset), header.body);
}

void run(Walk& walk) {
  pass_on_header(walk);
  while (!walk.cursor.at_end() && !walk.has_ended()) {
    if (!run_plain_lines(walk, walk.cursor.text().size())) run_line(walk, walk.cursor.next());
  }
  if (walk.has_end) return check_rest(walk);
  if (walk.has_ended() || walk.ends_early) return;
  end_without_mark(walk);
}

// --- lines -------------------------------------------------------------------------------------

/// A refused line may have said where the axes are: those behind it are not blamed for what it
/// leaves open.
void run_line(Walk& walk, const SourceLine& line) {
  walk.n_refused = walk.reporter.n_refused();
  read_line(walk, line);
  if (std::exchange(walk.n_refused, walk.reporter.n_refused()) == walk.reporter.n_refused()) return;
  walk.modal.user = {AxisUser::None, AxisUser::None};
  walk.modal.begins_pattern = false;
}

/// The short way for what nearly every line is: a hole at absolute coordinates that both passes
/// know. Everything else, and every doubt, goes the long way. No hole changes what decides this.
bool run_plain_lines(Walk& walk, std::size_t end) {
  if (walk.modal.motion != Motion::Drill || walk.modal.incremental || walk.modal.begins_pattern ||
      walk.pending || walk.steps_comment || walk.modal.user[0] != AxisUser::Work ||
      walk.modal.user[1] != AxisUser::Work || !walk.vision.may_drill() ||
      !walk.has_working_tool()) {
    return false;
  }
  const auto drill = [&walk](int line, const PlainCoordinate& block) {
    if (walk.emitter.is_over_limit()) return false;
    const Eigen::Vector2d at_mm = block.from(walk.modal.at_mm);
    walk.modal.at_mm = at_mm;
    walk.modal.has_hole = true;
    walk.emitter.drill(line, at_mm);
    return true;
  };
  if (walk.emitter.is_executing()) return walk.plain.read_lines(walk.cursor, end, drill);
  return walk.plain.read_lines(
      walk.cursor, end, drill, [&walk](std::int64_t n) { return walk.emitter.count_unseen(n); });
}

}  // namespace panelcal::excellon
