// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/number_census.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "program/excellon/text/header_words.h"
#include "program/model/tool_links.h"
#include "program/text/gaps.h"

namespace panelcal::excellon {
namespace {

/// Factor of a mantissa of this number of digits, in units.
double scale_of_digits(std::size_t n_digits, const NumberFormat& format) {
  const int exponent = format.zeros == Zeros::TrailingKept
                           ? format.decimal_digits
                           : static_cast<int>(n_digits) - format.integer_digits;
  return std::pow(10.0, -exponent);
}

std::size_t total_digits(const NumberFormat& format) {
  return static_cast<std::size_t>(format.integer_digits + format.decimal_digits);
}

bool is_coordinate(const Word& word) {
  return word.letter == 'X' || word.letter == 'Y';
}

bool is_nothing(std::string_view number) {
  return number.find_first_of("123456789") == std::string_view::npos;
}

/// The zeros that are kept decide what it is.
bool is_bare(std::string_view number) {
  return number.find('.') == std::string_view::npos && !is_nothing(number);
}

/// The numbers of a block that lengths of the job are known of.
struct Kinds {
  bool has_coordinates = false;  ///< work coordinates and steps: not dwells, zeros or texts
  bool has_diameters = false;
};

Kinds kinds_of(const Block& block, ProgramSet set) {
  const Word& first = block.words[0];
  if (is_coordinate(first) || first.letter == 'R') return {true, false};
  if (first.letter == 'T') return {true, true};
  if (first.letter != 'G' && first.letter != 'M') return {};
  const auto command = command_of(first, set);
  return {command && *command != Command::Dwell && *command != Command::SetZero, false};
}

enum class Line : std::uint8_t { Block, Other, Fault };

/// Moves behind the next line.
Line next_line(LineCursor& cursor, Block& block) {
  SourceLine line = cursor.next();
  LineKind kind = kind_of(line.text);
  if (kind == LineKind::BlockDelete) {
    line = without_slash(line);
    kind = kind_of(line.text);
  }
  if (kind != LineKind::Words || is_tool_link(trimmed(line.text))) return Line::Other;
  if (is_long_message(line.text)) {
    skip_message(cursor, line.text);
    return Line::Other;
  }
  if (lex(line, block)) return Line::Fault;
  return block.n_words > 0 ? Line::Block : Line::Other;
}

bool is_incremental_word(std::string_view text) {
  const HeaderCommand header = split_header_command(text);
  return text.starts_with("G91") || (header.word == "ICI" && header.value != "OFF");
}

/// Sixteen characters at once, a form that GCC and Clang have for every machine.
using Sixteen = signed char __attribute__((vector_size(16)));

/// Characters of a text whose whole lines have nothing but X and Y, each with one decimal point; 0
/// if the next lines have anything else. Most programs without zeros are so from end to end, and
/// each pays for the look.
std::size_t length_of_pointed_lines(std::string_view text) {
  constexpr std::size_t kMost = 127 * sizeof(Sixteen);  // counts fit into a character
  std::size_t size = std::min(text.size(), kMost);
  if (size == kMost) size = text.substr(0, size).find_last_of('\n') + 1;  // 0 if there is none
  Sixteen more_points = {};
  Sixteen others = {};
  const auto look = [&](Sixteen c) {
    const Sixteen xy = (c | 1) == 'Y';
    more_points += xy - (c == '.');
    others |= (c > '9') & ~xy;
  };
  std::size_t i = 0;
  for (; i + sizeof(Sixteen) <= size; i += sizeof(Sixteen)) {
    Sixteen c;
    std::memcpy(&c, text.data() + i, sizeof c);
    look(c);
  }
  Sixteen rest = {};
  std::memcpy(&rest, text.data() + i, size - i);
  look(rest);
  int sum = 0;
  int n_others = 0;
  for (std::size_t lane = 0; lane < sizeof(Sixteen); ++lane) {
    sum += more_points[lane];
    n_others += others[lane] != 0;
  }
  return sum == 0 && n_others == 0 ? size : 0;
}

}  // namespace

double WrittenNumbers::Extent::farthest_mm() const {
  return std::max(std::abs(least_mm), std::abs(most_mm));
}

void WrittenNumbers::add(std::string_view number) {
  if (number.empty()) return;
  ++n_;
  const bool is_negative = number.front() == '-';
  const std::string_view digits = number.substr(is_negative || number.front() == '+' ? 1 : 0);
  std::int64_t mantissa = 0;
  std::size_t n_digits = 0;
  for (const char c : digits) {
    if (c == '.') return add_pointed(number);
    if (c < '0' || c > '9' || ++n_digits > kMostDigits) break;
    mantissa = 10 * mantissa + (c - '0');
  }
  if (n_digits == 0 || n_digits != digits.size()) {
    has_others_ = true;
    return;
  }
  if (is_negative) mantissa = -mantissa;
  OfLength& known = bare_[n_digits];
  known.least = known.n == 0 ? mantissa : std::min(known.least, mantissa);
  known.most = known.n == 0 ? mantissa : std::max(known.most, mantissa);
  ++known.n;
  if (mantissa == 0) return;
  if (digits.front() == '0') ++known.n_leading_zero;
  if (digits.back() == '0') ++known.n_trailing_zero;
}

void WrittenNumbers::add_pointed(std::string_view number) {
  const ParsedLength parsed = parse_length(number, {});
  if (parsed.fault != NumberFault::None) {
    has_others_ = true;
    return;
  }
  const double value = parsed.value / inch(1);
  least_pointed_ = n_pointed_ == 0 ? value : std::min(least_pointed_, value);
  most_pointed_ = n_pointed_ == 0 ? value : std::max(most_pointed_, value);
  ++n_pointed_;
}

bool WrittenNumbers::fit(const NumberFormat& format) const {
  if (has_others_) return false;
  const std::size_t total = total_digits(format);
  const bool may_be_padded = format.zeros == Zeros::TrailingKept && format.states_digits;
  const auto limit = static_cast<std::int64_t>(std::pow(10.0, static_cast<double>(total)));
  for (std::size_t n = total + 1; n <= kMostDigits; ++n) {
    const OfLength& of = bare_.at(n);
    if (of.n > 0 && (!may_be_padded || of.least <= -limit || of.most >= limit)) return false;
  }
  return true;
}

WrittenNumbers::Extent WrittenNumbers::in(const NumberFormat& format) const {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  if (n_pointed_ > 0) {
    least = least_pointed_;
    most = most_pointed_;
  }
  for (std::size_t n = 1; n <= kMostDigits; ++n) {
    const OfLength& of = bare_.at(n);
    if (of.n == 0) continue;
    least = std::min(least, static_cast<double>(of.least) * scale_of_digits(n, format));
    most = std::max(most, static_cast<double>(of.most) * scale_of_digits(n, format));
  }
  const double unit_mm = format.one_unit().in_mm();
  return {least * unit_mm, most * unit_mm};
}

bool WrittenNumbers::mean_the_same_in(const NumberFormat& a, const NumberFormat& b) const {
  if (a.unit != b.unit && n_pointed_ > 0 && (least_pointed_ != 0 || most_pointed_ != 0)) {
    return false;
  }
  for (std::size_t n = 1; n <= kMostDigits; ++n) {
    const OfLength& of = bare_.at(n);
    const bool is_nothing = of.n == 0 || (of.least == 0 && of.most == 0);
    if (!is_nothing && (a.unit != b.unit || scale_of_digits(n, a) != scale_of_digits(n, b)))
      return false;
  }
  return true;
}

int WrittenNumbers::n_short_with_leading_zero(const NumberFormat& format) const {
  int sum = 0;
  for (std::size_t n = 1; n < total_digits(format) && n <= kMostDigits; ++n) {
    sum += bare_.at(n).n_leading_zero;
  }
  return sum;
}

int WrittenNumbers::n_short_with_trailing_zero(const NumberFormat& format) const {
  int sum = 0;
  for (std::size_t n = 1; n < total_digits(format) && n <= kMostDigits; ++n) {
    sum += bare_.at(n).n_trailing_zero;
  }
  return sum;
}

bool has_bare_number(std::string_view program, ProgramSet set) {
  for (LineCursor cursor(program); !cursor.at_end();) {
    if (const std::size_t n = length_of_pointed_lines(program.substr(cursor.offset())); n > 0) {
      cursor.skip(n, 0);
      continue;
    }
    Block block;
    if (next_line(cursor, block) != Line::Block) continue;
    const Kinds kinds = kinds_of(block, set);
    for (const Word& word : block.all()) {
      const bool counts = (kinds.has_coordinates && is_coordinate(word)) ||
                          (kinds.has_diameters && word.letter == 'C');
      if (counts && is_bare(word.number)) return true;
    }
  }
  return false;
}

NumberCensus take_census(std::string_view program, ProgramSet set) {
  NumberCensus census;
  bool has_coordinate = false;
  const auto see = [&](const Word& word, int line) {
    if (word.letter == 'C') {
      if (is_nothing(word.number)) return;
      census.diameters.add(word.number);
    } else {
      (word.letter == 'X' ? census.x : census.y).add(word.number);
    }
    const bool is_first = census.first.empty() || (!has_coordinate && word.letter != 'C');
    if (word.number.empty() || !is_first) return;
    has_coordinate = word.letter != 'C';
    census.first = word.text();
    census.first_line = line;
    census.first_column = word.column;
  };
  for (LineCursor cursor(program); !cursor.at_end();) {
    Block block;
    const Line line = next_line(cursor, block);
    census.has_faults |= line == Line::Fault;
    if (line != Line::Block) continue;
    census.is_incremental |= is_incremental_word(block.text);
    const Kinds kinds = kinds_of(block, set);
    for (const Word& word : block.all()) {
      const bool counts = (kinds.has_coordinates && is_coordinate(word)) ||
                          (kinds.has_diameters && word.letter == 'C');
      if (counts) see(word, block.line);
    }
  }
  return census;
}

}  // namespace panelcal::excellon
