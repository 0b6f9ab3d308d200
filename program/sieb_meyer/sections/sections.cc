// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/sections/sections.h"

#include <optional>
#include <string>
#include <utility>

#include "program/sieb_meyer/sections/line_role.h"
#include "program/sieb_meyer/text/lexer.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

class Scanner {
 public:
  Scanner(const SectionRules& rules, const Reporter& reporter)
      : rules_(rules), deletes_blocks_(rules.deletes_blocks), reporter_(reporter) {}

  SectionTree scan(LineCursor cursor, std::size_t end) {
    run_begin_ = cursor.place();
    while (cursor.offset() < end && out_.is_sound) {
      here_ = cursor.place();
      const SourceLine line = cursor.next();
      next_ = cursor.place();
      read(line);
    }
    if (!out_.is_sound) return std::move(out_);
    if (!open_.empty()) {
      const Section& section = out_.sections[static_cast<std::size_t>(open_.back())];
      refuse(Code::SectionUnbalanced, section.begin.number, "M31 is never closed", "M30 behind it");
    }
    end_implicit();
    refuse_open_row();
    return std::move(out_);
  }

  /// The offset lines of a text that has nothing else.
  std::optional<Layout> scan_layout(LineCursor cursor, std::size_t end) {
    if (!has_offsets_alone(cursor, end)) return std::nullopt;
    is_layout_ = true;
    out_.sections.emplace_back();
    open_.push_back(0);
    while (cursor.offset() < end && out_.is_sound) {
      here_ = cursor.place();
      const SourceLine line = cursor.next();
      next_ = cursor.place();
      read(line);
    }
    refuse_open_row();
    return Layout{std::move(section(0).rows), out_.is_sound};
  }

 private:
  bool has_offsets_alone(LineCursor cursor, std::size_t end) {
    bool has_any = false;
    while (cursor.offset() < end) {
      SourceLine line = cursor.next();
      if (const auto rest = without_slash(line)) {
        if (deletes_blocks_) continue;
        line = *rest;
      }
      if (is_blank(line.text)) continue;
      if (lex(line, block_) || !role_of(block_).is_offset) return false;
      has_any = true;
    }
    return has_any;
  }

  void refuse(Code code, int line, std::string what, std::string expected) {
    reporter_.report(code, line, std::move(what), std::move(expected));
    out_.is_sound = false;
  }
  Section& section(int i) { return out_.sections[static_cast<std::size_t>(i)]; }

  void read(const SourceLine& whole) {
    // Most lines are coordinates, which the structure has no interest in.
    if (!may_matter(whole.text)) {
      const bool moves = has_coordinate(whole.text);
      if (moves || !is_blank(whole.text)) at_begin_ = false;
      if (moves || !is_blank(whole.text)) works(whole.number, moves);
      return;
    }
    SourceLine line = whole;
    if (const auto rest = without_slash(whole)) {
      if (deletes_blocks_) return;
      line = *rest;
    }
    if (is_blank(line.text)) return;
    if (const auto fault = lex(line, block_)) return report_fault(line, *fault);
    LineRole role = role_of(block_);
    at_begin_ = at_begin_ && role.states_axes;
    if (at_begin_) run_begin_ = next_;  // the axes are the program's, and no copy's
    if (role.deletes_blocks) deletes_blocks_ = *role.deletes_blocks;
    if (role.closes_first) {
      return refuse(Code::SectionMixed,
                    line.number,
                    quoted(block_.text) + " closes a section and opens another",
                    "M30 and M31 in two lines");
    }
    if (is_layout_ && role.n_open + role.n_close > 0) {
      return refuse(Code::SectionMixed,
                    line.number,
                    quoted(block_.text) + ": a bracket in a subprogram of offset lines",
                    "M31 and M30 in the program that calls it");
    }
    for (int i = 0; i < role.n_open && out_.is_sound; ++i) open();
    if (!out_.is_sound) return;
    if (const Layout* layout = called_layout(role)) {
      role.has = {};
      read_call(*layout);
    } else if (role.is_offset) {
      read_offset(role.n_close > 0);
    } else if (role.works) {
      works(line.number, role.moves);
    }
    if (!out_.is_sound) return;
    if (!open_.empty()) {
      section(open_.back()).has |= role.has;
    }
    run_has_ |= role.has;
    for (int i = 0; i < role.n_close && out_.is_sound; ++i) close();
  }

  /// The fault of a line that runs is reported when it does; behind offsets no line runs.
  void report_fault(const SourceLine& line, const LexFault& fault) {
    const bool is_behind_offsets =
        row_begin_ || (open_.empty() ? implicit_ >= 0 : section(open_.back()).is_offset());
    if (!is_behind_offsets) return;
    reporter_.report_syntax(line.number, fault);
    out_.is_sound = false;
  }

  /// A line that does something: no offset may have come before it in its bracket.
  void works(int line, bool moves) {
    if (open_.empty()) {
      end_implicit();
      run_moves_ |= moves;
      return;
    }
    const Section& inner = section(open_.back());
    if (!inner.is_offset() && !row_begin_) return;
    refuse(
        Code::SectionMixed,
        line,
        fmt::format("a working line follows the offsets of the M31 in line {}", inner.begin.number),
        "M30 in the last offset line, or M31 here");
  }

  void open() {
    if (open_.empty()) {
      end_implicit();
    } else if (section(open_.back()).is_offset() || row_begin_) {
      return works(here_.number, false);
    }
    if (static_cast<int>(open_.size()) + rules_.depth >= kMostLevels) {
      return refuse(Code::NestingTooDeep,
                    here_.number,
                    "M31 opens another level",
                    fmt::format("at most {} levels, subprograms counted", kMostLevels));
    }
    const int index = static_cast<int>(out_.sections.size());
    const int parent = open_.empty() ? -1 : open_.back();
    Section opened;
    opened.parent = parent;
    opened.begin = here_;
    opened.is_bracketed = true;
    out_.sections.push_back(std::move(opened));
    (parent < 0 ? out_.roots : section(parent).children).push_back(index);
    open_.push_back(index);
    run_has_brackets_ = true;
  }

  void close() {
    if (open_.empty()) {
      // Format 1000 has no M31: there M30 only ends the offsets.
      if (implicit_ >= 0 && rules_.format.file == FileFormat::F1000) return end_implicit();
      return refuse(Code::SectionUnbalanced,
                    here_.number,
                    "M30 closes what no M31 opened",
                    "M31 at the beginning of the section");
    }
    refuse_open_row();
    Section& closed = section(open_.back());
    if (!closed.is_offset()) closed.body_end = next_.offset;
    closed.closing = here_;
    closed.after = next_;
    const SectionContent has = closed.has;
    open_.pop_back();
    if (!open_.empty()) {
      section(open_.back()).has |= has;
    } else {
      run_begin_ = next_;
    }
  }

  /// Offsets without brackets move everything since the last ones.
  bool begin_implicit() {
    if (implicit_ >= 0) return true;
    if (rules_.in_subprogram || run_has_brackets_) {
      refuse(Code::SectionMixed,
             here_.number,
             rules_.in_subprogram
                 ? "an offset line in a subprogram, outside all brackets"
                 : "an offset line outside all brackets, in a program that uses brackets",
             "M31 and M30 round the lines that it moves");
      return false;
    }
    if (!std::exchange(run_moves_, false)) {
      refuse(Code::SectionMixed,
             here_.number,
             "an offset line with nothing to move behind the offsets before it",
             "offset lines in a row, behind the coordinates that they move");
      return false;
    }
    implicit_ = static_cast<int>(out_.sections.size());
    Section run;
    run.begin = run_begin_;
    run.body_end = here_.offset;
    run.has = run_has_;
    out_.sections.push_back(std::move(run));
    out_.roots.push_back(implicit_);
    return true;
  }

  void end_implicit() {
    if (implicit_ < 0) return;
    refuse_open_row();
    implicit_ = -1;
    run_has_ = {};
  }

  void refuse_open_row() {
    if (!row_begin_) return;
    refuse(Code::ArgumentInvalid,
           row_begin_->line,
           "M50V2 begins a row of patterns that nothing ends",
           "X#Y#M50W# in the next line");
    row_begin_.reset();
  }

  bool read_number(const Word& word, double& out) {
    const ParsedNumber number = parse_number(word.number, rules_.format, Quantity::Coordinate);
    if (number.problem == NumberProblem::None) {
      out = number.value;
      return true;
    }
    reporter_.report(
        Code::NumberMalformed, block_.of(word), expectation(number.problem, rules_.format));
    out_.is_sound = false;
    return false;
  }

  /// The line that closes the section may switch something for what follows, such as M92.
  void read_offset(bool closes) {
    if (open_.empty() && !begin_implicit()) return;
    Section& moved = section(open_.empty() ? implicit_ : open_.back());
    if (!moved.is_offset() && !row_begin_) moved.body_end = here_.offset;
    Eigen::Vector2d offset_mm = Eigen::Vector2d::Zero();
    OffsetCodes codes;
    std::optional<int> n_patterns;
    bool begins_row = false;
    for (const Word& word : block_.all()) {
      switch (word.letter) {
        case 'X':
          if (!read_number(word, offset_mm.x())) return;
          break;
        case 'Y':
          if (!read_number(word, offset_mm.y())) return;
          break;
        case 'V':
          begins_row = true;
          if (word.number != "2") return refuse_word(word, "V2");
          if (rules_.format.file == FileFormat::F1000) {
            return refuse_word(word, "a command of format 1000", Code::CommandFormat);
          }
          break;
        case 'W':
          n_patterns = parse_count(word.number);
          if (!n_patterns || *n_patterns < 2) return refuse_word(word, "W2 or more patterns");
          break;
        case 'M':
        case 'G':
          if (!read_code(word, closes, codes)) return;
          break;
        default:
          return refuse_word(word, "X, Y, V2, W# and M codes in an offset line");
      }
    }
    if (!codes.is_known()) {
      return refuse(Code::ArgumentInvalid,
                    here_.number,
                    quoted(block_.text) + ": the manual has no such combination",
                    "M50, M60, M70, M80 or M90, or M60 with one of the last three");
    }
    add_row(moved, codes.orientation(), offset_mm, begins_row, n_patterns);
    end_offset_line(moved);
  }

  const Layout* called_layout(const LineRole& role) const {
    if (!role.has.calls || !rules_.find_layout || rules_.format.file != FileFormat::F5000) {
      return nullptr;
    }
    return rules_.find_layout(block_.argument, deletes_blocks_);
  }

  /// A call of offset lines stands for them, with its coordinate added.
  void read_call(const Layout& layout) {
    refuse_open_row();
    out_.is_sound &= layout.is_sound;
    if (!out_.is_sound) return;
    Eigen::Vector2d zero_mm = Eigen::Vector2d::Zero();
    bool has_zero = false;
    for (const Word& word : block_.all()) {
      const bool is_axis = word.letter == 'X' || word.letter == 'Y';
      has_zero |= is_axis;
      if (is_axis && !read_number(word, word.letter == 'X' ? zero_mm.x() : zero_mm.y())) return;
      const auto command = word.letter == 'M' ? command_of(word) : std::nullopt;
      if (is_axis || command == Command::CloseSection || command == Command::Subprogram) continue;
      return refuse_word(word, "X, Y and M30 before the call of a subprogram of offset lines");
    }
    if (static_cast<int>(open_.size()) + rules_.depth >= kMostLevels) {
      return refuse(Code::NestingTooDeep,
                    here_.number,
                    quoted(block_.text) + " opens another level",
                    fmt::format("at most {} levels, subprograms counted", kMostLevels));
    }
    if (open_.empty() && !begin_implicit()) return;
    Section& moved = section(open_.empty() ? implicit_ : open_.back());
    if (!moved.is_offset()) moved.body_end = here_.offset;
    if (has_zero && moved.layout_line == 0) moved.layout_line = here_.number;
    for (CopyRow row : layout.rows) {
      row.line = here_.number;
      row.first_mm += zero_mm;
      row.last_mm += zero_mm;
      moved.rows.push_back(row);
    }
    end_offset_line(moved);
  }

  /// Behind offsets without brackets, others may follow.
  void end_offset_line(Section& moved) {
    if (!open_.empty()) return;
    moved.closing = here_;
    moved.after = next_;
    run_begin_ = next_;
  }

  void refuse_word(const Word& word, std::string expected, Code code = Code::ArgumentInvalid) {
    reporter_.report(code, block_.in(word), std::move(expected));
    out_.is_sound = false;
  }

  /// The offset commands of a line. The manual has them alone, and M60 with one of M70, M80, M90.
  struct OffsetCodes {
    bool plain = false;
    bool turned = false;
    bool mirror_x = false;
    bool mirror_y = false;
    bool half_turn = false;

    bool is_known() const {
      const int n_others = int{mirror_x} + int{mirror_y} + int{half_turn};
      return plain ? !turned && n_others == 0 : n_others <= 1;
    }
    Eigen::Matrix2d orientation() const {
      return offset_orientation(turned, mirror_x || half_turn, mirror_y || half_turn);
    }
  };

  bool read_code(const Word& word, bool closes, OffsetCodes& codes) {
    const auto command = command_of(word);
    if (!command) {
      refuse_word(word, "a code that `panelcal help sieb-meyer` lists");
      return false;
    }
    switch (*command) {
      case Command::Offset:
        codes.plain = true;
        return true;
      case Command::OffsetTurned:
        codes.turned = true;
        return true;
      case Command::OffsetMirrorX:
        codes.mirror_x = true;
        return true;
      case Command::OffsetMirrorY:
        codes.mirror_y = true;
        return true;
      case Command::OffsetHalfTurn:
        codes.half_turn = true;
        return true;
      case Command::OpenSection:
        refuse_word(word, "no M31 in an offset line");
        return false;
      case Command::CloseSection:
      case Command::Absolute:
        return true;
      default:
        if (!closes) refuse_word(word, "it in a line of its own");
        return closes;
    }
  }

  void add_row(Section& moved,
               const Eigen::Matrix2d& orientation,
               const Eigen::Vector2d& offset_mm,
               bool begins_row,
               std::optional<int> n_patterns) {
    const bool is_plain = orientation == Eigen::Matrix2d::Identity();
    if ((begins_row || n_patterns) && !is_plain) {
      return refuse(Code::ArgumentInvalid,
                    here_.number,
                    quoted(block_.text) + ": a row of patterns is turned or mirrored",
                    "M50 alone in both lines of M50V2");
    }
    if (begins_row && n_patterns) {
      return refuse(Code::ArgumentInvalid,
                    here_.number,
                    quoted(block_.text) + ": M50V2 and W# in one line",
                    "W# in the line behind M50V2");
    }
    if (begins_row) {
      refuse_open_row();
      row_begin_ = {.line = here_.number, .first_mm = offset_mm};
      return;
    }
    if (row_begin_.has_value() != n_patterns.has_value()) {
      return refuse(Code::ArgumentInvalid,
                    here_.number,
                    quoted(block_.text),
                    n_patterns ? "X#Y#M50V2 in the line before W#" : "W# in the line behind M50V2");
    }
    if (row_begin_) {
      moved.rows.push_back({.line = here_.number,
                            .first_mm = row_begin_->first_mm,
                            .last_mm = offset_mm,
                            .count = *n_patterns});
      row_begin_.reset();
      return;
    }
    moved.rows.push_back({.line = here_.number,
                          .orientation = orientation,
                          .first_mm = offset_mm,
                          .last_mm = offset_mm});
  }

  const SectionRules& rules_;
  bool deletes_blocks_;
  const Reporter& reporter_;
  SectionTree out_;
  Block block_;
  std::vector<int> open_;
  bool is_layout_ = false;  ///< the text is a subprogram of offset lines
  bool at_begin_ = true;    ///< nothing but FV has come
  int implicit_ = -1;
  std::optional<CopyRow> row_begin_;  ///< of M50V2
  LinePlace here_;
  LinePlace next_;
  LinePlace run_begin_;  ///< place that an offset line without brackets would move from
  SectionContent run_has_;
  bool run_moves_ = false;
  bool run_has_brackets_ = false;
};

}  // namespace

SectionTree scan_sections(std::string_view bytes,
                          LinePlace begin,
                          std::size_t end,
                          const SectionRules& rules,
                          const Reporter& reporter) {
  // Every bracket and every offset is an M command.
  const std::string_view text = bytes.substr(begin.offset, end - begin.offset);
  if (text.find('M') == std::string_view::npos) return {};
  return Scanner(rules, reporter).scan(LineCursor(bytes, begin), end);
}

std::optional<Layout> scan_layout(std::string_view bytes,
                                  LinePlace begin,
                                  std::size_t end,
                                  const SectionRules& rules,
                                  const Reporter& reporter) {
  return Scanner(rules, reporter).scan_layout(LineCursor(bytes, begin), end);
}

}  // namespace panelcal::sieb_meyer
