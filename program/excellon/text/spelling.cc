// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/spelling.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <utility>

#include "program/excellon/text/header.h"
#include "program/excellon/text/lexer.h"
#include "program/model/tool_links.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

bool is_gap(char c) {
  return c == ' ' || c == '\t';
}
bool is_small(char c) {
  return c >= 'a' && c <= 'z';
}
bool is_decimal(char c) {
  return c >= '0' && c <= '9';
}
char in_capitals(char c) {
  return is_small(c) ? static_cast<char>(c - 'a' + 'A') : c;
}

/// A character that no program has which is written as the manual says, but in texts and comments.
bool is_unusual(char c) {
  return is_small(c) || c == ';' || c == '(' || c == 'N' || c == '\0';
}

/// The first unusual character from `at` on, eight characters at a time.
std::size_t find_unusual(std::string_view text, std::size_t at) {
  constexpr std::uint64_t kOnes = 0x0101010101010101;
  constexpr std::uint64_t kTops = 0x8080808080808080;
  const auto has_zero = [](std::uint64_t v) { return ((v - kOnes) & ~v & kTops) != 0; };
  for (; text.size() - at >= 8; at += 8) {
    std::uint64_t v = 0;
    std::memcpy(&v, text.data() + at, sizeof v);
    // Small letters, and few others, have both of the bits 0x40 and 0x20.
    if ((v & (v << 1) & (kOnes * 0x40)) != 0 || has_zero(v) || has_zero(v ^ (kOnes * ';')) ||
        has_zero(v ^ (kOnes * '(')) || has_zero(v ^ (kOnes * 'N'))) {
      break;
    }
  }
  while (at < text.size() && !is_unusual(text[at])) ++at;
  return at;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_gap(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_gap(text.back())) text.remove_suffix(1);
  return text;
}

std::size_t first_of_line(std::string_view line) {
  return static_cast<std::size_t>(std::ranges::find_if_not(line, is_gap) - line.begin());
}

/// Comment lines, and lines that begin with $: what small letters there are is meant.
bool stays_as_it_is(std::string_view line) {
  const std::size_t first = first_of_line(line);
  return first == line.size() || line[first] == ';' || line[first] == '$';
}

/// All unusual characters stand in lines that stay as they are.
bool is_as_the_manual_says(std::string_view bytes) {
  for (std::size_t at = find_unusual(bytes, 0); at < bytes.size();) {
    if (bytes[at] == 'N' && (at + 1 == bytes.size() || !is_decimal(bytes[at + 1]))) {
      at = find_unusual(bytes, at + 1);  // of INCH or ON
      continue;
    }
    const std::size_t before = bytes.find_last_of("\r\n", at);
    const std::size_t begin = before == bytes.npos ? 0 : before + 1;
    const std::size_t end = std::min(bytes.find_first_of("\r\n", at), bytes.size());
    if (!stays_as_it_is(bytes.substr(begin, end - begin))) return false;
    at = find_unusual(bytes, end);
  }
  return true;
}

/// A number format in a comment behind a block would be lost with the comment.
bool may_state_format(std::string_view comment) {
  constexpr std::string_view kWord = "FORMAT";
  return !std::ranges::search(comment, kWord, {}, in_capitals).empty();
}

class Speller {
 public:
  Speller(std::string_view bytes, const Reporter& reporter)
      : bytes_(bytes), reporter_(reporter), out_(bytes) {}

  std::string respell() {
    blank_leaders();
    LineCursor cursor(bytes_);
    bool in_message = false;
    while (!cursor.at_end()) {
      const std::size_t begin = cursor.offset();
      const SourceLine line = cursor.next();
      if (!in_message) respell_line(line, begin);
      const std::string_view now = std::string_view(out_).substr(begin, line.text.size());
      in_message = (in_message || is_long_message(now)) && is_continued(now);
    }
    if (out_ == bytes_) out_.clear();
    return std::move(out_);
  }

 private:
  enum class Kind : std::uint8_t { Leader, Number, Comment, Letters };

  void report(Kind kind, int line, std::size_t column, std::string what, std::string expected) {
    if (std::exchange(reported_[static_cast<std::size_t>(kind)], true)) return;
    reporter_.report(Code::NotationAccepted,
                     line,
                     static_cast<int>(column) + 1,
                     std::move(what),
                     std::move(expected));
  }

  /// Paper tapes begin and end with NUL characters; amid a program they would be damage.
  void blank_leaders() {
    constexpr std::string_view kLeader{"\0 \t\r\n", 5};
    const std::size_t first = std::min(bytes_.find_first_not_of(kLeader), bytes_.size());
    const std::size_t last = bytes_.find_last_not_of(kLeader);
    const auto blank = [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (out_[i] != '\0') continue;
        out_[i] = ' ';
        report(Kind::Leader, 1, 0, "NUL characters around the program", "a text without them");
      }
    };
    blank(0, first);
    if (last != bytes_.npos) blank(last + 1, bytes_.size());
  }

  void respell_line(const SourceLine& line, std::size_t begin) {
    if (stays_as_it_is(std::string_view(out_).substr(begin, line.text.size()))) return;
    char* const text = out_.data() + begin;
    const std::size_t size = line.text.size();
    const std::size_t first = blank_number(line, text);
    const std::size_t end = end_of_commands(std::string_view(text + first, size - first)) + first;
    if (end == size) blank_comments(line, text);
    const std::string before(text, end);
    std::transform(text, text + end, text, in_capitals);
    const auto small = std::ranges::find_if(before, is_small);
    if (small == before.end()) return;
    report(Kind::Letters,
           line.number,
           static_cast<std::size_t>(small - before.begin()),
           quoted(line.text) + " is read as " + quoted(std::string_view(text, size)),
           "capital letters");
  }

  /// `N10` at the beginning of a block; gives the offset of what follows it.
  std::size_t blank_number(const SourceLine& line, char* text) {
    const std::size_t size = line.text.size();
    std::size_t at = first_of_line(std::string_view(text, size));
    if (at < size && text[at] == '/') ++at;
    while (at < size && is_gap(text[at])) ++at;
    if (at + 1 >= size || in_capitals(text[at]) != 'N' || !is_decimal(text[at + 1])) return at;
    const std::size_t number = at++;
    while (at < size && is_decimal(text[at])) ++at;
    report(Kind::Number,
           line.number,
           number,
           quoted(line.text.substr(number, at - number)) + " numbers its block",
           "blocks without numbers");
    std::fill(text + number, text + at, ' ');
    while (at < size && is_gap(text[at])) ++at;
    return at;
  }

  /// Offset behind the comma of M45, M47 and M97 to M99, whose texts stay; else the end.
  static std::size_t end_of_commands(std::string_view block) {
    constexpr std::array<std::string_view, 5> kTexts = {"M45,", "M47,", "M97,", "M98,", "M99,"};
    for (const std::string_view code : kTexts) {
      if (block.size() < code.size()) continue;
      if (std::ranges::equal(block.substr(0, code.size()), code, {}, in_capitals)) {
        return code.size();
      }
    }
    return block.size();
  }

  void blank_comments(const SourceLine& line, char* text) {
    const std::size_t size = line.text.size();
    for (std::size_t at = 0; at < size; ++at) {
      if (text[at] != ';' && text[at] != '(') continue;
      std::size_t end = size;
      if (text[at] == '(') {
        int depth = 0;
        for (end = at; end < size; ++end) {
          depth += text[end] == '(' ? 1 : text[end] == ')' ? -1 : 0;
          if (depth == 0) break;
        }
        if (end++ == size) return;  // not closed
      }
      const std::string_view comment = line.text.substr(at, end - at);
      if (may_state_format(comment)) return;
      report(Kind::Comment,
             line.number,
             at,
             quoted(comment) + " is a comment",
             "; at the beginning of a line");
      std::fill(text + at, text + end, ' ');
      at = end - 1;
    }
  }

  std::string_view bytes_;
  const Reporter& reporter_;
  std::string out_;
  std::array<bool, 4> reported_{};
};

/// A line that a program of this language may have.
bool is_block(std::string_view line) {
  if (line == "%" || line.front() == '/' || line.starts_with("$uvis") || is_tool_link(line)) {
    return true;
  }
  if (is_header_word(line)) return true;
  Block block;
  if (lex({line, 1, 1}, block) || block.n_words == 0) return false;
  constexpr std::string_view kLetters = "XYAIJRPTFBGMSCHZU";
  const bool is_known = std::ranges::all_of(
      block.all(), [&](const Word& word) { return kLetters.find(word.letter) != kLetters.npos; });
  const Word& first = block.words[0];
  return is_known && (first.letter == 'X' || first.letter == 'Y' || !first.number.empty());
}

}  // namespace

std::string respell(std::string_view bytes, const Reporter& reporter) {
  if (is_as_the_manual_says(bytes)) return {};
  return Speller(bytes, reporter).respell();
}

ForeignText find_foreign(std::string_view bytes) {
  constexpr int kLooked = 200;  // lines: no program begins with 200 others
  LineCursor ahead(bytes);
  for (int i = 0; i < kLooked && !ahead.at_end(); ++i) ahead.next();
  const std::string_view head = bytes.substr(0, ahead.offset());
  DiagnosticLog unused;
  const std::string respelled_head = respell(head, Reporter("", unused));
  ForeignText first;
  LineCursor cursor(respelled_head.empty() ? head : std::string_view(respelled_head));
  while (!cursor.at_end()) {
    const int number = cursor.line_number();
    const std::string_view line = trimmed(cursor.next().text);
    if (line.empty() || line.front() == ';') continue;
    if (is_block(line)) return {};
    const bool opens_another = line.front() == '%';
    if (first.line == 0 || opens_another) first.line = number;
    if (opens_another) break;
  }
  if (first.line == 0) return {};
  // As it is written, not as it was respelled.
  LineCursor source(head);
  while (source.line_number() < first.line) source.next();
  first.text = trimmed(source.next().text);
  return first;
}

}  // namespace panelcal::excellon
