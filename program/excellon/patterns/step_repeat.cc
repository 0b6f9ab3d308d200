// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/patterns/step_repeat.h"

#include <algorithm>
#include <string>

namespace panelcal::excellon {
namespace {

bool is_vision(const Block& block, ProgramSet set) {
  return std::ranges::any_of(block.all(), [set](const Word& word) {
    const std::optional<Command> command = command_of(word, set);
    if (!command) return false;
    const CommandClass kind = info(*command).command_class;
    return kind == CommandClass::Measurement || command == Command::StoreCorrections ||
           command == Command::RewindCorrections || command == Command::AdvanceCorrections ||
           command == Command::CancelBase || command == Command::CancelNested ||
           command == Command::Autocalibration ||
           command == Command::StoredPattern;  // which may measure
  });
}

class SectionScanner {
 public:
  SectionScanner(LineCursor from, int line, const SectionContext& context, const Reporter& reporter)
      : cursor_(from), context_(context), format_(context.format), reporter_(reporter) {
    section_.line = line;
    section_.pattern = from;
    section_.line_of_open_count = context.line_of_open_count;
  }

  std::optional<RepeatSection> scan() {
    if (!find_pattern_end()) return std::nullopt;
    while (!cursor_.at_end()) {
      const SourceLine line = next_line();
      const LineKind kind = kind_of(line.text);
      if (kind == LineKind::Empty) continue;
      Block block;
      if (kind != LineKind::Words || lex(line, block) || block.n_words == 0) {
        return misplaced(line, 1, line.text);
      }
      if (!has_no_arguments(block)) return std::nullopt;
      const Word& first = block.words[0];
      const std::optional<Command> command = command_of(first, context_.set);
      if (command == Command::EndOfPattern) {
        if (!open_level(block)) return std::nullopt;
      } else if (command == Command::RepeatPattern || first.letter == 'R') {
        if (!read_copies(block)) return std::nullopt;
      } else if (command == Command::EndOfRepeat) {
        section_.closing = block;
        section_.after = cursor_;
        return std::move(section_);
      } else {
        return misplaced(line, block.column, block.text);
      }
    }
    return unclosed("M08");
  }

 private:
  /// Blocks with a slash are read as the switch says; deleted, they are empty lines.
  SourceLine next_line() {
    SourceLine line = cursor_.next();
    if (kind_of(line.text) != LineKind::BlockDelete) return line;
    line = without_slash(line);
    if (context_.deletes_blocks) {
      if (is_long_message(line.text)) skip_message(cursor_, line.text);
      line.text = {};
    }
    return line;
  }

  bool find_pattern_end() {
    while (!cursor_.at_end()) {
      section_.pattern_end = cursor_.offset();
      const SourceLine line = next_line();
      const auto first = line.text.find_first_not_of(" \t");
      if (first == std::string_view::npos) continue;
      const char c = line.text[first];
      if (c == 'T') section_.changes_tools = true;
      if (c == '$') section_.has_vision = true;
      if (c != 'M' && c != 'G' && c != '%') continue;
      if (is_long_message(line.text)) {
        skip_message(cursor_, line.text);
        continue;
      }
      Block block;
      if (c != '%' && lex(line, block)) continue;  // reported when the pattern is executed
      section_.has_vision |= is_vision(block, context_.set);
      const auto command =
          c == '%' ? Command::BeginPattern : command_of(block.words[0], context_.set);
      switch (command.value_or(Command::DrillMode)) {
        case Command::EndOfPattern:
          return has_no_arguments(block) && open_level(block);
        case Command::BeginPattern:
        case Command::EndOfRepeat:
        case Command::EndRewind:
        case Command::EndNoRewind:
          unclosed("M01");
          return false;
        default:
          break;
      }
    }
    unclosed("M01");
    return false;
  }

  bool open_level(const Block& block) {
    if (block.n_words > 1) {
      const Word& second = block.words[1];
      reporter_.report(Code::BlockNotAlone,
                       block.in(second),
                       quoted(block.words[0].text()) + " in a block by itself");
      return false;
    }
    if (section_.levels.size() == kMaxLevels) {
      reporter_.report(Code::NestingTooDeep,
                       block,
                       " opens one level too many",
                       "at most " + std::to_string(kMaxLevels) + " levels");
      return false;
    }
    section_.levels.emplace_back();
    restarts_ = true;
    return true;
  }

  /// `(R#)M02X#Y#(M70)(M80)(M90)`, or a bare M02, which clears the offset counter.
  bool read_copies(const Block& block) {
    Copies copies{.run = {}, .tool = std::nullopt, .line = block.line};
    CopyRun& run = copies.run;
    bool has_axis = false;
    bool has_orientation = false;
    Eigen::Vector2d step_mm = Eigen::Vector2d::Zero();
    bool has_repeat = false;
    for (const Word& word : block.all()) {
      const std::optional<Command> command = command_of(word, context_.set);
      if (word.letter == 'R' && &word == &block.words[0]) {
        const auto count = parse_count(word.number);
        if (!count || *count < 1 || *count > 9999) return bad(block, word, "R1 to R9999");
        run.count = *count;
      } else if (command == Command::RepeatPattern && !has_repeat) {
        has_repeat = true;
      } else if (word.letter == 'X' || word.letter == 'Y') {
        const ParsedLength parsed = parse_length(word.number, format_);
        if (parsed.fault != NumberFault::None) {
          reporter_.report_number(parsed.fault, word.number, block.line, word.column + 1, format_);
          return false;
        }
        if (block.find(word.letter) != &word) return bad(block, word, "each axis once");
        step_mm[word.letter - 'X'] = parsed.value.in_mm();
        has_axis = true;
      } else if (command == Command::SwapAxes || command == Command::MirrorX ||
                 command == Command::MirrorY) {
        if ((command == Command::SwapAxes && run.swap_axes) ||
            (command == Command::MirrorX && run.mirror_x) ||
            (command == Command::MirrorY && run.mirror_y)) {
          return bad(block, word, "each of M70, M80 and M90 once");
        }
        if (command != Command::SwapAxes && run.swap_axes && !section_.swap_before_mirror) {
          section_.swap_before_mirror = block;
        }
        run.swap_axes |= command == Command::SwapAxes;
        run.mirror_x |= command == Command::MirrorX;
        run.mirror_y |= command == Command::MirrorY;
        has_orientation = true;
      } else if (word.letter == 'T' && !copies.tool) {
        copies.tool = word;
        section_.changes_tools = true;
      } else {
        return bad(block, word, "M02 with X, Y, M70, M80, M90 or T");
      }
    }
    if (!has_repeat) return bad(block, block.words[0], "R#M02X#Y# between M01 and M08");
    if (!has_axis && !has_orientation) {
      if (block.words[0].letter == 'R' || copies.tool)
        return bad(block, block.words[0], "R#M02X#Y#");
      restarts_ = true;
      section_.line_of_open_count = 0;
      return true;
    }
    if (section_.line_of_open_count != 0 && restarts_ && !section_.count_behind_open_one) {
      section_.count_behind_open_one.emplace(block, section_.line_of_open_count);
    }
    const bool stays_open = has_axis && block.words[0].letter != 'R';
    section_.line_of_open_count = stays_open ? block.line : 0;
    run.step = displacement_mm<frame::Programmed>(step_mm);
    run.restarts = restarts_;
    restarts_ = false;
    section_.levels.back().push_back(copies);
    return true;
  }

  bool has_no_arguments(const Block& block) {
    if (block.argument_column == 0) return true;
    const Word& first = block.words[0];
    reporter_.report(Code::BlockNotAlone,
                     block.line,
                     block.argument_column - 1,
                     quoted("," + std::string(block.argument)) + " behind " + quoted(first.text()),
                     "no comma in this block");
    return false;
  }

  bool bad(const Block& block, const Word& word, std::string expected) {
    reporter_.report(Code::ArgumentInvalid, block.of(word), std::move(expected));
    return false;
  }

  std::nullopt_t misplaced(const SourceLine& line, int column, std::string_view text) {
    reporter_.report(Code::CommandMisplaced,
                     line.number,
                     column,
                     quoted(text) + " stands between M01 and M08 of the section opened in line " +
                         std::to_string(section_.line),
                     "M02, R#M02, M01 or M08");
    return std::nullopt;
  }

  std::nullopt_t unclosed(std::string_view missing) {
    reporter_.report(Code::RepeatUnclosed,
                     section_.line,
                     "no " + std::string(missing),
                     "M25 ... M01 ... M02 ... M08");
    return std::nullopt;
  }

  LineCursor cursor_;
  const SectionContext& context_;
  const NumberFormat& format_;
  const Reporter& reporter_;
  RepeatSection section_;
  bool restarts_ = true;
};

}  // namespace

std::optional<RepeatSection> scan_section(LineCursor from,
                                          int line,
                                          const SectionContext& context,
                                          const Reporter& reporter) {
  return SectionScanner(from, line, context, reporter).scan();
}

}  // namespace panelcal::excellon
