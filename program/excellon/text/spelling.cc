// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/spelling.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <utility>

#include "program/excellon/text/comment_format.h"
#include "program/excellon/text/header_words.h"
#include "program/excellon/text/lexer.h"
#include "program/model/tool_links.h"
#include "program/text/gaps.h"

namespace panelcal::excellon {
namespace {

bool is_small(char c) {
  return c >= 'a' && c <= 'z';
}
bool is_decimal(char c) {
  return c >= '0' && c <= '9';
}
char in_capitals(char c) {
  return is_small(c) ? static_cast<char>(c - 'a' + 'A') : c;
}

/// A character that a program as the manual writes it has in texts and comments only, or seldom:
/// the N of INCH, the M of calls.
bool is_telling(char c) {
  return is_small(c) || c == ';' || c == '(' || c == 'N' || c == 'M';
}

/// Sixteen characters at once, a form that GCC and Clang have for every machine.
using Characters = unsigned char __attribute__((vector_size(16)));

Characters lower_of(Characters a, Characters b) {
  return a < b ? a : b;
}

/// A character of the block may be a telling one. Every program is looked at whole, so few
/// operations count: the extremes of the block tell of small letters, and of ; ( M and N, each by a
/// distance of 0 or 1, which a few rare neighbours have as well.
bool may_have_telling(const char* block, std::size_t size) {
  Characters highest = {};
  Characters nearest = ~highest;
  for (std::size_t i = 0; i < size; i += sizeof(Characters)) {
    Characters c;
    std::memcpy(&c, block + i, sizeof c);
    highest = c > highest ? c : highest;
    nearest = lower_of(nearest, lower_of('N' - c, lower_of(c ^ ';', c ^ '(')));
  }
  const auto found = (highest >= 'a') | (nearest <= 1);
  std::array<std::uint64_t, 2> halves{};
  std::memcpy(halves.data(), &found, sizeof found);
  return (halves[0] | halves[1]) != 0;
}

/// The first telling character from `at` on.
std::size_t find_telling(std::string_view text, std::size_t at) {
  constexpr std::size_t kBlock = 8 * sizeof(Characters);
  for (; text.size() - at >= kBlock; at += kBlock) {
    const char* const block = text.data() + at;
    if (!may_have_telling(block, kBlock)) continue;
    const char* const first = std::find_if(block, block + kBlock, is_telling);
    if (first != block + kBlock) return at + static_cast<std::size_t>(first - block);
  }
  while (at < text.size() && !is_telling(text[at])) ++at;
  return at;
}

std::size_t first_of_line(std::string_view line) {
  return static_cast<std::size_t>(std::ranges::find_if_not(line, is_gap) - line.begin());
}

/// Comment lines, and lines that begin with $: what small letters there are is meant.
bool stays_as_it_is(std::string_view line) {
  const std::size_t first = first_of_line(line);
  return first == line.size() || line[first] == ';' || line[first] == '$';
}

constexpr std::string_view kLeader{"\0 \t\r\n", 5};

/// NUL characters stand before the first line, or behind the last one.
bool has_leader(std::string_view bytes) {
  const std::size_t first = std::min(bytes.find_first_not_of(kLeader), bytes.size());
  const std::size_t last = bytes.find_last_not_of(kLeader);
  return bytes.substr(0, first).find('\0') != bytes.npos ||
         (last != bytes.npos && bytes.find('\0', last) != bytes.npos);
}

struct Look {
  bool is_as_the_manual_says = false;
  bool calls_patterns = true;  ///< known where the text is as the manual says
};

/// Small letters, comments and block numbers stand only in lines that stay as they are.
Look look_at(std::string_view bytes) {
  if (has_leader(bytes)) return {};
  bool calls_patterns = false;
  for (std::size_t at = find_telling(bytes, 0); at < bytes.size();) {
    const bool is_number = bytes[at] == 'N' && at + 1 < bytes.size() && is_decimal(bytes[at + 1]);
    if (bytes[at] == 'M' || (bytes[at] == 'N' && !is_number)) {
      calls_patterns |= bytes.substr(at).starts_with("M99,");
      at = find_telling(bytes, at + 1);
      continue;
    }
    const std::size_t before = bytes.find_last_of("\r\n", at);
    const std::size_t begin = before == bytes.npos ? 0 : before + 1;
    const std::size_t end = std::min(bytes.find_first_of("\r\n", at), bytes.size());
    if (!stays_as_it_is(bytes.substr(begin, end - begin))) return {};
    at = find_telling(bytes, end);
  }
  return {true, calls_patterns};
}

/// A number format in brackets, or behind a block, would be lost with the comment.
bool states_format(std::string_view comment) {
  constexpr std::string_view kFile = "FILE_FORMAT";
  std::string capitals(comment);
  std::ranges::transform(capitals, capitals.begin(), in_capitals);
  const auto at = capitals.find(kFile);
  const bool is_file_format =
      at != capitals.npos &&
      trimmed(std::string_view(capitals).substr(at + kFile.size())).starts_with('=');
  return is_file_format || capitals.find("FORMAT={") != capitals.npos ||
         read_comment_format(comment).digits;
}

/// A long message, behind the slash of block delete as well.
bool begins_message(std::string_view line) {
  const std::size_t first = first_of_line(line);
  if (first < line.size() && line[first] == '/') line.remove_prefix(first + 1);
  return is_long_message(line);
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
      in_message = (in_message || begins_message(now)) && is_continued(now);
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
      if (states_format(comment)) {
        reporter_.report(Code::ArgumentInvalid,
                         line.number,
                         static_cast<int>(at) + 1,
                         quoted(comment) + " states a number format behind a block",
                         "a line of its own that begins with ;");
      } else {
        report(Kind::Comment,
               line.number,
               at,
               quoted(comment) + " is a comment",
               "; at the beginning of a line");
      }
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

/// With the line as it is written, not as it was respelled.
ForeignText as_written(std::string_view head, ForeignText foreign) {
  LineCursor source(head);
  while (source.line_number() < foreign.line) source.next();
  foreign.text = trimmed(source.next().text);
  return foreign;
}

}  // namespace

Spelling respell(std::string_view bytes, const Reporter& reporter) {
  const Look look = look_at(bytes);
  if (look.is_as_the_manual_says) return {{}, look.calls_patterns};
  return {Speller(bytes, reporter).respell(), true};
}

ForeignText find_foreign(std::string_view bytes) {
  constexpr int kLooked = 200;  // lines: no program begins with 200 others
  LineCursor ahead(bytes);
  for (int i = 0; i < kLooked && !ahead.at_end(); ++i) ahead.next();
  const std::string_view head = bytes.substr(0, ahead.offset());
  DiagnosticLog unused;
  const std::string respelled_head = respell(head, Reporter("", unused)).text;
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
  return first.line == 0 ? first : as_written(head, first);
}

}  // namespace panelcal::excellon
