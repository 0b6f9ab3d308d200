// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/header_words.h"

#include <algorithm>
#include <array>

#include "calib/base/diagnostic.h"
#include "program/text/gaps.h"

namespace panelcal::excellon {
namespace {

struct HeaderWord {
  std::string_view word;
  HeaderWordKind kind;
};

constexpr std::array kHeaderWords = {
#define EXCELLON_HEADER_WORD(word, command_class, effect, kind) \
  HeaderWord{word, HeaderWordKind::kind},
#include "program/excellon/text/header_words.def"
};

/// ICI alone is ICI,ON.
std::string_view switched(std::string_view value) {
  return value.empty() ? "ON" : value;
}

}  // namespace

std::vector<HeaderWordInfo> header_word_table() {
  using enum CommandClass;
  constexpr std::array<std::string_view, 3> kKinds = {"handled", "passed", "refused"};
  return {
#define EXCELLON_HEADER_WORD(word, command_class, effect, kind) \
  HeaderWordInfo{                                               \
      word, command_class, effect, kKinds[static_cast<std::size_t>(HeaderWordKind::kind)]},
#include "program/excellon/text/header_words.def"
  };
}

std::optional<HeaderWordKind> kind_of_header_word(std::string_view word) {
  const auto known = std::ranges::find(kHeaderWords, word, &HeaderWord::word);
  if (known == kHeaderWords.end()) return std::nullopt;
  return known->kind;
}

std::string_view nearest_header_word(std::string_view word) {
  std::array<std::string_view, kHeaderWords.size()> words;
  std::ranges::transform(kHeaderWords, words.begin(), &HeaderWord::word);
  return nearest_word(word, words);
}

HeaderCommand split_header_command(std::string_view block) {
  const auto comma = block.find(',');
  if (comma == std::string_view::npos) return {trimmed(block), {}};
  return {trimmed(block.substr(0, comma)), trimmed(block.substr(comma + 1))};
}

std::string HeaderCommand::text() const {
  std::string text(word);
  if (!value.empty()) text.append(",").append(value);
  return text;
}

std::optional<FormatWords> read_format_words(std::string_view value) {
  FormatWords words;
  while (!value.empty()) {
    const auto comma = value.find(',');
    const std::string_view part = trimmed(value.substr(0, comma));
    if (part == "LZ" || part == "TZ") {
      words.zeros = part == "LZ" ? Zeros::LeadingKept : Zeros::TrailingKept;
    } else if (is_digit_mask(part)) {
      const auto point = static_cast<int>(part.find('.'));
      words.digits.emplace(point, static_cast<int>(part.size()) - point - 1);
    } else {
      return std::nullopt;
    }
    if (comma == std::string_view::npos) break;
    value.remove_prefix(comma + 1);
  }
  return words;
}

std::optional<PartialFormat> unit_statement(const HeaderCommand& command) {
  const bool is_inch = command.word == "INCH";
  if (!is_inch && command.word != "METRIC") return std::nullopt;
  const std::optional<FormatWords> words = read_format_words(command.value);
  if (!words) return std::nullopt;
  return PartialFormat{
      is_inch ? LengthUnit::Inch : LengthUnit::Millimeter, words->zeros, words->digits, ""};
}

OptionAgain compare_options(const HeaderCommand& first,
                            const HeaderCommand& again,
                            const StatedFormat& stated) {
  using enum OptionAgain;
  if (first.value == again.value) return Same;
  if (again.word == "ICI" || again.word == "OM48" || again.word == "BLKD") {
    return switched(first.value) == switched(again.value) ? Same : Contradicts;
  }
  const std::optional<PartialFormat> statement = unit_statement(again);
  if (!statement) return Contradicts;
  const PartialFormat parts = stated.obeyed(StatedFormat::Source::Word, *statement);
  const NumberFormat& format = stated.format();
  const std::pair digits(format.integer_digits, format.decimal_digits);
  if (parts.digits && *parts.digits != digits) return Contradicts;
  if (!parts.zeros) return Same;
  if (!stated.states_zeros()) return More;
  return *parts.zeros == format.zeros ? Same : Contradicts;
}

bool is_set_up(std::string_view text) {
  return text == "G90" || text == "G91" || text == "M71" || text == "M72";
}

bool is_header_word(std::string_view block) {
  // Nearly all other blocks have a digit or nothing behind their first letter.
  if (block.size() < 2 || block[0] < 'A' || block[0] > 'Z' || (block[1] >= '0' && block[1] <= '9'))
    return false;
  const std::string_view word = split_header_command(block).word;
  const bool is_whole = word.size() > 1 || block.find(',') != std::string_view::npos;
  return is_whole && word != "CAN_TEXT_OFF" && kind_of_header_word(word).has_value();
}

HeaderAhead look_ahead(LineCursor cursor, bool may_rewind) {
  while (!cursor.at_end()) {
    const std::string_view text = trimmed(cursor.next().text);
    if (text == "M48") return HeaderAhead::Start;
    if (is_header_word(text)) return HeaderAhead::Word;
    if (text.empty() || text.front() == ';' || is_set_up(text)) continue;
    if (text != "%" || !std::exchange(may_rewind, false)) return HeaderAhead::None;
  }
  return HeaderAhead::None;
}

bool is_digit_mask(std::string_view text) {
  const auto point = text.find('.');
  return point != std::string_view::npos && point >= 1 && point <= 6 &&
         text.size() - point - 1 >= 1 && text.size() - point - 1 <= 6 &&
         text.find_first_not_of("0.") == std::string_view::npos &&
         text.find('.', point + 1) == std::string_view::npos;
}

tl::expected<void, std::string> read_text_offset(std::string_view value,
                                                 const NumberFormat& format,
                                                 Eigen::Vector2d& offset_mm) {
  const auto comma = value.find(',');
  const ParsedLength x = parse_length(value.substr(0, comma), format);
  ParsedLength y;
  if (comma != std::string_view::npos) y = parse_length(value.substr(comma + 1), format);
  if (value.empty() || x.fault != NumberFault::None || y.fault != NumberFault::None) {
    return tl::make_unexpected("CAN_TEXT_OFF,x or CAN_TEXT_OFF,x,y");
  }
  offset_mm.x() = x.value.in_mm();
  if (comma != std::string_view::npos) offset_mm.y() = y.value.in_mm();
  return {};
}

}  // namespace panelcal::excellon
