// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/block.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <utility>

#include "program/text/gaps.h"

namespace panelcal::gcode {
namespace {

/// E and O mean nothing in a line; numbers with exponents are not read.
constexpr std::string_view kLetters = "ABCDFGHIJKLMNPQRSTUVWXYZ";

class BlockReader {
 public:
  BlockReader(const SourceLine& line, const std::string& file) : line_(line), file_(file) {
    block_.text = line.text;
    block_.line = line.number;
  }

  Expected<GcodeBlock> read() {
    skip_blanks();
    if (at_ < text().size() && text()[at_] == '/') {
      block_.is_deleted = true;
      ++at_;
    }
    for (skip_blanks(); at_ < text().size(); skip_blanks()) {
      const char c = text()[at_];
      if (c == '(') {
        PANELCAL_CHECK(read_comment());
      } else if (c == ';') {
        block_.rest += text().substr(at_);
        at_ = text().size();
      } else if (c == '%') {
        block_.rest += c;
        ++at_;
      } else {
        PANELCAL_CHECK(read_word());
      }
    }
    return std::move(block_);
  }

 private:
  std::string_view text() const { return line_.text; }

  void skip_blanks() {
    while (at_ < text().size() && is_gap(text()[at_])) ++at_;
  }

  tl::unexpected<Diagnostic> problem(Code code,
                                     std::size_t at,
                                     std::string what,
                                     std::string expected) {
    return failure({code,
                    {file_, line_.number, line_.column + static_cast<int>(at)},
                    std::move(what),
                    std::move(expected)});
  }

  Expected<void> read_comment() {
    const std::size_t end = text().find(')', at_);
    if (end == std::string_view::npos) {
      return problem(Code::CommandUnknown, at_, "a comment without an end", "`)` in the same line");
    }
    block_.rest += text().substr(at_, end + 1 - at_);
    at_ = end + 1;
    return {};
  }

  char here() const { return at_ < text().size() ? text()[at_] : '\0'; }

  Expected<void> read_word() {
    const std::size_t begin = at_;
    const auto letter = static_cast<char>(std::toupper(static_cast<unsigned char>(text()[at_])));
    if (letter == '#') return read_assignment();
    if (letter == 'O' || letter == '[') {
      return problem(Code::NotSupported,
                     begin,
                     quoted(text().substr(begin)),
                     "a letter and a number: expressions and subprograms are not executed");
    }
    if (kLetters.find(letter) == std::string_view::npos) {
      return problem(
          Code::CommandUnknown, begin, quoted(text().substr(begin, 1)), "a letter and a number");
    }
    ++at_;
    GcodeWord word{.letter = letter, .begin = begin};
    PANELCAL_CHECK(read_value(word));
    if (letter != 'G' && letter != 'M' && block_.has(letter)) {
      return problem(Code::ArgumentInvalid,
                     begin,
                     quoted(text().substr(begin, at_ - begin)) + " beside another " + letter,
                     "each letter but G and M once in a line");
    }
    block_.words.push_back(word);
    return {};
  }

  /// `#5=` or `#<name>=`, and a value.
  ///
  /// Source LinuxCNC G-code overview, Parameters: 31 to 5000 are the program's
  Expected<void> read_assignment() {
    constexpr int kLastOfProgram = 5000;
    GcodeWord word{.letter = '#', .begin = at_, .is_computed = true};
    ++at_;
    skip_blanks();
    const std::size_t name = at_;
    int number = 0;
    const auto [rest, error] =
        std::from_chars(text().data() + at_, text().data() + text().size(), number);
    const bool is_number = error == std::errc() && number >= 0;
    bool is_own = is_number && number <= kLastOfProgram;
    if (is_number) {
      at_ = static_cast<std::size_t>(rest - text().data());
    } else if (here() == '<') {
      is_own = pass_variable();
    }
    skip_blanks();
    if (!is_own || at_ == name || here() != '=') {
      return problem(Code::NotSupported,
                     word.begin,
                     quoted(text().substr(word.begin)),
                     "an assignment to a variable of the program: #1 to #5000, or #<name>");
    }
    ++at_;
    PANELCAL_CHECK(read_value(word));
    word.is_computed = true;
    block_.words.push_back(word);
    return {};
  }

  /// Moves behind the number, the variable or the expression of a word.
  Expected<void> read_value(GcodeWord& word) {
    skip_blanks();
    const std::size_t begin = at_;
    if (here() == '-' || here() == '+') ++at_;
    skip_blanks();
    if (here() == '#' || here() == '[') {
      word.is_computed = true;
      if (here() == '#' ? !pass_variable() : !pass_brackets()) {
        return problem(Code::NumberMalformed,
                       word.begin,
                       quoted(text().substr(word.begin)),
                       "a variable or an expression in brackets");
      }
    } else {
      at_ = begin;
      PANELCAL_TRY(word.value, read_number(word.begin));
    }
    word.end = at_;
    return {};
  }

  /// From # behind a variable: `#5`, `#<name>`, `##5`, `#[...]`. From < behind a name.
  bool pass_variable() {
    while (here() == '#') {
      ++at_;
      skip_blanks();
    }
    if (here() == '[') return pass_brackets();
    if (here() == '<') {
      const std::size_t end = text().find('>', at_);
      if (end == std::string_view::npos || end == at_ + 1) return false;
      at_ = end + 1;
      return true;
    }
    const std::size_t begin = at_;
    while (std::isdigit(static_cast<unsigned char>(here()))) ++at_;
    return at_ > begin;
  }

  /// From [ behind the ] that belongs to it.
  bool pass_brackets() {
    int depth = 0;
    do {
      const char c = here();
      if (c == '\0' || c == '(' || c == ';') return false;
      depth += c == '[' ? 1 : c == ']' ? -1 : 0;
      ++at_;
    } while (depth > 0);
    return true;
  }

  /// Blanks may stand between its digits.
  Expected<double> read_number(std::size_t word) {
    std::string digits;
    while (at_ < text().size()) {
      const char c = text()[at_];
      const bool is_sign = (c == '+' || c == '-') && digits.empty();
      if (!is_gap(c)) {
        if (!is_sign && c != '.' && !std::isdigit(static_cast<unsigned char>(c))) break;
        digits += c;
      }
      ++at_;
    }
    while (at_ > word && is_gap(text()[at_ - 1])) --at_;
    const std::size_t from = !digits.empty() && digits.front() == '+' ? 1 : 0;
    double value = 0;
    const char* const end = digits.data() + digits.size();
    const auto [rest, error] =
        std::from_chars(digits.data() + from, end, value, std::chars_format::fixed);
    if (error != std::errc() || rest != end) {
      return problem(Code::NumberMalformed,
                     word,
                     quoted(text().substr(word, std::max<std::size_t>(at_ - word, 1))),
                     "a letter and a decimal number");
    }
    return value;
  }

  SourceLine line_;
  const std::string& file_;
  GcodeBlock block_;
  std::size_t at_ = 0;
};

}  // namespace

const GcodeWord* GcodeBlock::find(char letter) const {
  const auto found = std::ranges::find(words, letter, &GcodeWord::letter);
  return found == words.end() ? nullptr : &*found;
}

Expected<GcodeBlock> read_gcode_block(const SourceLine& line, const std::string& file) {
  return BlockReader(line, file).read();
}

}  // namespace panelcal::gcode
