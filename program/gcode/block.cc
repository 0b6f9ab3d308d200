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

  Expected<void> read_word() {
    const std::size_t begin = at_;
    const auto letter = static_cast<char>(std::toupper(static_cast<unsigned char>(text()[at_])));
    if (letter == 'O' || letter == '#' || letter == '[') {
      return problem(
          Code::NotSupported,
          begin,
          quoted(text().substr(begin)),
          "numbers as they are: variables, expressions and subprograms are not executed");
    }
    if (kLetters.find(letter) == std::string_view::npos) {
      return problem(
          Code::CommandUnknown, begin, quoted(text().substr(begin, 1)), "a letter and a number");
    }
    ++at_;
    skip_blanks();
    PANELCAL_TRY(const double value, read_number(begin));
    if (letter != 'G' && letter != 'M' && block_.has(letter)) {
      return problem(Code::ArgumentInvalid,
                     begin,
                     quoted(text().substr(begin, at_ - begin)) + " beside another " + letter,
                     "each letter but G and M once in a line");
    }
    block_.words.push_back({letter, value, begin, at_});
    return {};
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
    if (at_ < text().size() && (text()[at_] == '#' || text()[at_] == '[')) {
      return problem(Code::NotSupported,
                     word,
                     quoted(text().substr(word)),
                     "numbers as they are: variables and expressions are not executed");
    }
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
