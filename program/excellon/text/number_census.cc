// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/number_census.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "program/excellon/text/header_words.h"
#include "program/model/setting_lengths.h"
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

/// Of the numbers of a block what a census makes of them.
enum class Meaning : std::uint8_t { None, Place, Diameter, Other, Rate };

/// Work coordinates and steps are places: not dwells, zeros and sizes of cycles.
Meaning meaning_of(const Block& block, const Word& word, ProgramSet set) {
  constexpr std::string_view kLengths = "AIJZU";
  const Word& first = block.words[0];
  if (word.letter == 'F' || word.letter == 'B') return Meaning::Rate;
  if (kLengths.find(word.letter) != std::string_view::npos) return Meaning::Other;
  if (word.letter == 'C' && first.letter == 'T') return Meaning::Diameter;
  if (!is_coordinate(word)) return Meaning::None;
  if (is_coordinate(first) || first.letter == 'R' || first.letter == 'T') {
    const Word* const cycle = block.find('G');
    const bool is_size = cycle != nullptr && command_of(*cycle, set) == Command::CannedCircle &&
                         word.column > cycle->column;
    return is_size ? Meaning::Other : Meaning::Place;
  }
  const auto command = command_of(first, set);
  const bool is_place = command && *command != Command::Dwell && *command != Command::SetZero;
  return is_place ? Meaning::Place : Meaning::Other;
}

/// Lengths of settings and orders, which have forms of their own.
bool has_settings_length(std::string_view text) {
  constexpr std::array<std::string_view, 7> kWords = {
      "CP,", "Z,", "ZC,", "CAN_TEXT_OFF,", "$uvis,searcharea,", "$uvis,focus,", "G34,"};
  const bool is_one =
      std::ranges::any_of(kWords, [&](std::string_view word) { return text.starts_with(word); });
  if (text.starts_with("G34,") && std::ranges::count(text, ',') < 2) return false;
  return (is_one || has_length(text)) && !is_nothing(text);
}

bool is_end(const Block& block, ProgramSet set) {
  return std::ranges::any_of(block.all(), [&](const Word& word) {
    if (word.letter != 'M') return false;
    const auto command = command_of(word, set);
    return command == Command::EndRewind || command == Command::EndNoRewind;
  });
}

enum class Line : std::uint8_t { Block, Setting, Other, Fault };

/// Moves behind the next line that is executed, or to the end of the text.
Line next_line(LineCursor& cursor, const LineRules& rules, Block& block) {
  SourceLine line = cursor.next();
  LineKind kind = kind_of(line.text);
  if (kind == LineKind::BlockDelete) {
    if (rules.deletes_blocks) return Line::Other;
    line = without_slash(line);
    kind = kind_of(line.text);
  }
  block.text = trimmed(line.text);
  block.line = line.number;
  if (kind != LineKind::Words && kind != LineKind::KeyboardOrder) return Line::Other;
  if (is_tool_link(block.text)) return Line::Other;
  if (is_long_message(line.text)) {
    skip_message(cursor, line.text);
    return Line::Other;
  }
  if (has_settings_length(block.text)) return Line::Setting;
  if (kind == LineKind::KeyboardOrder) return Line::Other;
  if (lex(line, block)) return Line::Fault;
  return block.n_words > 0 ? Line::Block : Line::Other;
}

bool is_incremental_word(std::string_view text) {
  const HeaderCommand header = split_header_command(text);
  return text.starts_with("G91") || (header.word == "ICI" && header.value != "OFF");
}

/// Sixteen characters at once, a form that GCC and Clang have for every machine.
using Sixteen = signed char __attribute__((vector_size(16)));

Sixteen sixteen_at(const char* text) {
  Sixteen c;
  std::memcpy(&c, text, sizeof c);
  return c;
}

/// Lines that a text begins with.
struct PointedLines {
  std::size_t n_characters = 0;
  bool are_so = false;  ///< nothing but X and Y, each with a decimal point or a lone 0
};

/// Most programs without zeros have decimal points from end to end, and each pays for the look.
PointedLines look_for_pointed_lines(std::string_view text) {
  constexpr std::size_t kMost = 127 * sizeof(Sixteen);  // counts fit into a character
  std::size_t size = std::min(text.size(), kMost);
  if (size == kMost) {
    const std::size_t line_end = text.substr(0, size).find_last_of("\r\n");
    if (line_end == std::string_view::npos) return {size, false};
    size = line_end + 1;
  }
  Sixteen more_points = {};
  Sixteen others = {};
  // Of the characters in `c` those that follow each are in `next`, and those behind in `third`.
  const auto look = [&](Sixteen c, Sixteen next, Sixteen third) {
    const Sixteen xy = (c | 1) == 'Y';
    const Sixteen ends = (third < '0') & (third != '.');
    const Sixteen zero = xy & (next == '0') & (ends | (third > '9'));
    more_points += xy - zero - (c == '.');
    others |= ((c > '9') & ~xy) | (c == '/');
  };
  std::size_t i = 0;
  for (; i + sizeof(Sixteen) + 2 <= size; i += sizeof(Sixteen)) {
    const char* const at = text.data() + i;
    look(sixteen_at(at), sixteen_at(at + 1), sixteen_at(at + 2));
  }
  // Behind the last line there is nothing: characters of value 0 end its number.
  std::array<char, 2 * sizeof(Sixteen) + 2> rest = {};
  std::memcpy(rest.data(), text.data() + i, size - i);
  for (std::size_t k = 0; k < size - i; k += sizeof(Sixteen)) {
    const char* const at = rest.data() + k;
    look(sixteen_at(at), sixteen_at(at + 1), sixteen_at(at + 2));
  }
  int sum = 0;
  bool has_others = false;
  for (std::size_t lane = 0; lane < sizeof(Sixteen); ++lane) {
    sum += more_points[lane];
    has_others |= others[lane] != 0;
  }
  return {size, sum == 0 && !has_others};
}

/// Number of the line that a part of the program stands in.
int line_of(std::string_view part, std::string_view program) {
  LineCursor cursor(program);
  const auto offset = static_cast<std::size_t>(part.data() - program.data());
  int number = 1;
  while (!cursor.at_end() && cursor.offset() <= offset) number = cursor.next().number;
  return number;
}

/// Passes every line that is executed up to the end of the program to `visit`, as its kind and its
/// block, until it returns false.
///
/// In     skips_pointed: lines of X and Y alone that have no bare number need not be passed
template <class Visit>
void visit_lines(std::string_view program,
                 const LineRules& rules,
                 bool skips_pointed,
                 const Visit& visit) {
  std::size_t slow_until = skips_pointed ? 0 : program.size();
  for (LineCursor cursor(program); !cursor.at_end();) {
    if (cursor.offset() >= slow_until) {
      const PointedLines ahead = look_for_pointed_lines(program.substr(cursor.offset()));
      if (ahead.are_so) {
        cursor.skip(ahead.n_characters, 0);
        continue;
      }
      slow_until = cursor.offset() + ahead.n_characters;
    }
    Block block;
    const Line line = next_line(cursor, rules, block);
    if (!visit(line, block) || (line == Line::Block && is_end(block, rules.set))) return;
  }
}

/// Follows tools, modes and coordinates as far as single holes need it.
class HoleList {
 public:
  HoleList(const LineRules& rules, const NumberFormat& format, std::size_t max_holes)
      : rules_(rules), format_(format), max_holes_(max_holes) {}

  /// False: no more lines are wanted.
  bool take(Line line, const Block& block) {
    if (block.text == "%") is_in_header_ = false;
    if (line == Line::Fault) holes_.is_readable = is_in_header_;
    if (is_incremental_word(block.text)) holes_.is_readable = false;
    if (line != Line::Block || !holes_.is_readable) return holes_.is_readable;
    const Word& first = block.words[0];
    const auto command = command_of(first, rules_.set);
    if (command == Command::HeaderStart) is_in_header_ = true;
    if (command == Command::HeaderEnd) is_in_header_ = false;
    if (first.letter == 'T') take_tool(block);
    if (is_in_header_) return true;
    if (command) take_mode(*command);
    take_place(block);
    return holes_.is_readable && holes_.n_holes < max_holes_;
  }

  ListedHoles finish() {
    std::erase_if(holes_.tools, [](const ListedHoles::OfTool& of) { return of.at_mm.empty(); });
    return std::move(holes_);
  }

 private:
  void take_mode(Command command) {
    switch (command) {
      case Command::RoutMode:
        is_routing_ = true;
        break;
      case Command::DrillMode:
        is_routing_ = false;
        break;
      case Command::DualInLine1:
      case Command::DualInLine:
      case Command::EightPin:
      case Command::TextX:
      case Command::TextY:
      case Command::StoredPattern:
      case Command::SetZero:
        is_passed_over_ = true;
        break;
      default:
        break;
    }
  }

  /// Three or four digits are a tool and an index, unless the header has that very tool.
  void take_tool(const Block& block) {
    int number = parse_count(block.words[0].number).value_or(0);
    if (!is_in_header_ && number > 99 && !diameters_mm_.contains(number)) number /= 100;
    if (const Word* const diameter = block.find('C')) {
      const double diameter_mm = length_mm(diameter->number);
      if (diameter_mm > 0) diameters_mm_[number] = diameter_mm;
    }
    if (is_in_header_) return;
    is_passed_over_ = false;
    const auto known = std::ranges::find(holes_.tools, number, &ListedHoles::OfTool::tool);
    i_tool_ = static_cast<std::size_t>(known - holes_.tools.begin());
    if (known == holes_.tools.end()) holes_.tools.push_back({.tool = number});
    const auto diameter = diameters_mm_.find(number);
    if (diameter != diameters_mm_.end()) holes_.tools[i_tool_].diameter_mm = diameter->second;
  }

  void take_place(const Block& block) {
    const char kind = block.words[0].letter;
    if (kind == 'M' || kind == 'P') return;
    if (kind == 'R') return take_steps(block);
    bool is_hole = !is_routing_ && !is_passed_over_ && i_tool_ < holes_.tools.size();
    bool has_place = false;
    for (const Word& word : block.all()) {
      if (!is_coordinate(word)) {
        is_hole &= kind == 'T';
        continue;
      }
      has_place = true;
      at_mm_[word.letter == 'X' ? 0 : 1] = length_mm(word.number);
      if (holes_.first_bare.text.empty() && is_bare(word.number)) {
        holes_.first_bare = {word.text(), block.line, word.column};
      }
    }
    if (!is_hole || !has_place || block.argument_column > 0) return;
    holes_.tools[i_tool_].at_mm.push_back(at_mm_);
    ++holes_.n_holes;
  }

  /// The position behind R#X#Y#; R#M02 leaves it.
  void take_steps(const Block& block) {
    if (block.find('M') != nullptr) return;
    const int n = parse_count(block.words[0].number).value_or(0);
    for (const Word& word : block.all()) {
      if (is_coordinate(word)) at_mm_[word.letter == 'X' ? 0 : 1] += n * length_mm(word.number);
    }
  }

  double length_mm(std::string_view number) {
    const ParsedLength parsed = parse_length(number, format_);
    holes_.is_readable &= parsed.fault == NumberFault::None;
    return parsed.value.in_mm();
  }

  LineRules rules_;
  NumberFormat format_;
  std::size_t max_holes_;
  ListedHoles holes_;
  std::map<int, double> diameters_mm_;
  std::size_t i_tool_ = std::numeric_limits<std::size_t>::max();
  Eigen::Vector2d at_mm_ = Eigen::Vector2d::Zero();
  bool is_in_header_ = false;
  bool is_routing_ = false;
  bool is_passed_over_ = false;
};

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

WrittenNumbers::KeptZeros WrittenNumbers::short_with_zeros(const NumberFormat& format) const {
  KeptZeros sum;
  for (std::size_t n = 1; n < total_digits(format) && n <= kMostDigits; ++n) {
    sum.n_leading += bare_.at(n).n_leading_zero;
    sum.n_trailing += bare_.at(n).n_trailing_zero;
  }
  return sum;
}

unsigned WrittenNumbers::lengths() const {
  unsigned bits = 0;
  for (std::size_t n = 0; n <= kMostDigits; ++n) {
    const OfLength& of = bare_.at(n);
    if (of.least != 0 || of.most != 0) bits |= 1U << n;
  }
  return bits;
}

std::optional<NumberPlace> find_bare_number(std::string_view program, const LineRules& rules) {
  std::optional<NumberPlace> found;
  visit_lines(program, rules, true, [&](Line line, const Block& block) {
    const auto is_bare_length = [&](const Word& word) {
      const Meaning meaning = meaning_of(block, word, rules.set);
      return meaning != Meaning::None && meaning != Meaning::Rate && is_bare(word.number);
    };
    if (line == Line::Setting && has_bare_number(lengths_of(block.text))) {
      found = NumberPlace{std::string(block.text), line_of(block.text, program), 1};
    } else if (line == Line::Block) {
      const auto word = std::ranges::find_if(block.all(), is_bare_length);
      if (word != block.all().end()) {
        found = NumberPlace{word->text(), line_of(block.text, program), word->column};
      }
    }
    return !found;
  });
  return found;
}

void take_census(std::string_view program, const LineRules& rules, NumberCensus& census) {
  bool has_coordinate = !census.x.is_empty() || !census.y.is_empty();
  const auto name_first = [&](std::string_view text, int line, int column, bool is_coordinate_of) {
    if (!census.first.text.empty() && (has_coordinate || !is_coordinate_of)) return;
    has_coordinate = is_coordinate_of;
    census.first = {std::string(text), line, column};
  };
  visit_lines(program, rules, false, [&](Line line, const Block& block) {
    census.has_faults |= line == Line::Fault;
    if (line == Line::Setting) {
      census.has_other_lengths = true;
      census.has_other_bare_lengths |= has_bare_number(lengths_of(block.text));
      name_first(block.text, block.line, 1, false);
    }
    if (line != Line::Block) return true;
    census.is_incremental |= is_incremental_word(block.text);
    for (const Word& word : block.all()) {
      const Meaning meaning = meaning_of(block, word, rules.set);
      if (meaning == Meaning::None) continue;
      if (meaning == Meaning::Place) {
        (word.letter == 'X' ? census.x : census.y).add(word.number);
      } else if (is_nothing(word.number)) {
        continue;
      } else if (meaning == Meaning::Diameter) {
        census.diameters.add(word.number);
      } else {
        census.has_other_lengths = true;
        census.has_other_bare_lengths |= meaning == Meaning::Other && is_bare(word.number);
      }
      if (word.number.empty()) continue;
      name_first(word.text(), block.line, word.column, meaning == Meaning::Place);
    }
    return true;
  });
}

ListedHoles list_holes(std::string_view program,
                       const LineRules& rules,
                       const NumberFormat& format,
                       std::size_t max_holes) {
  HoleList list(rules, format, max_holes);
  visit_lines(
      program, rules, false, [&](Line line, const Block& block) { return list.take(line, block); });
  return list.finish();
}

}  // namespace panelcal::excellon
