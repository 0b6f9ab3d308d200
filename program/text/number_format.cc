// SPDX-License-Identifier: Apache-2.0
#include "program/text/number_format.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>

#include "program/text/gaps.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr int kMaxFormatDigits = 15;  // every integer of 15 digits is exact in a double
constexpr std::array<double, 23> kFormatPowers = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                  1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                  1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/// More digits than the format has are zeros on the left, and change nothing.
bool is_padded(std::int64_t mantissa, const NumberFormat& format) {
  return format.zeros == Zeros::TrailingKept && format.states_digits &&
         static_cast<double>(mantissa) <
             kFormatPowers.at(static_cast<std::size_t>(format.integer_digits) +
                              static_cast<std::size_t>(format.decimal_digits));
}

bool is_word(std::string_view text, std::string_view small_letters) {
  return std::ranges::equal(text, small_letters, {}, [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
}

}  // namespace

std::string NumberFormat::summary() const {
  std::string text = unit == LengthUnit::Inch ? "inch " : "metric ";
  text += std::to_string(integer_digits) + "." + std::to_string(decimal_digits);
  text += zeros == Zeros::LeadingKept ? ", leading zeros kept" : ", trailing zeros kept";
  return text;
}

std::string NumberFormat::option() const {
  std::string text = unit == LengthUnit::Inch ? "inch," : "metric,";
  text += zeros == Zeros::LeadingKept ? "lz," : "tz,";
  return text + std::to_string(integer_digits) + "." + std::to_string(decimal_digits);
}

std::string NumberFormat::digit_mask() const {
  return std::string(static_cast<std::size_t>(integer_digits), '0') + '.' +
         std::string(static_cast<std::size_t>(decimal_digits), '0');
}

std::string NumberFormat::header_word() const {
  const std::string_view word = unit == LengthUnit::Inch ? "INCH" : "METRIC";
  const std::string_view kept = zeros == Zeros::LeadingKept ? "LZ" : "TZ";
  return fmt::format("{},{},{}", word, kept, digit_mask());
}

void NumberFormat::take_usual_digits() {
  integer_digits = unit == LengthUnit::Inch ? 2 : 3;
  decimal_digits = unit == LengthUnit::Inch ? 4 : 3;
}

bool are_scaled_alike(const NumberFormat& a, const NumberFormat& b) {
  if (a.zeros != b.zeros) return false;
  return a.zeros == Zeros::LeadingKept ? a.integer_digits == b.integer_digits
                                       : a.decimal_digits == b.decimal_digits;
}

std::optional<LengthUnit> parse_unit(std::string_view text) {
  if (is_word(text, "inch")) return LengthUnit::Inch;
  if (is_word(text, "metric") || is_word(text, "mm")) return LengthUnit::Millimeter;
  return std::nullopt;
}

std::optional<Zeros> parse_zeros(std::string_view text) {
  if (is_word(text, "lz")) return Zeros::LeadingKept;
  if (is_word(text, "tz")) return Zeros::TrailingKept;
  return std::nullopt;
}

std::optional<RateUnit> parse_rate_unit(std::string_view text) {
  if (is_word(text, "m/min")) return RateUnit::MetersPerMinute;
  if (is_word(text, "inch/min")) return RateUnit::InchesPerMinute;
  return std::nullopt;
}

std::optional<std::pair<int, int>> parse_digits(std::string_view text) {
  const auto digit = [](char c) { return c >= '1' && c <= '6'; };
  if (text.size() != 3 || text[1] != '.' || !digit(text[0]) || !digit(text[2])) return std::nullopt;
  return std::pair(text[0] - '0', text[2] - '0');
}

tl::expected<PartialFormat, std::string> parse_format(std::string_view text) {
  constexpr std::string_view kExpected =
      "a unit (inch, metric), kept zeros (lz, tz) and digits (2.4), each at most once";
  PartialFormat format;
  const auto take = [](auto& part, const auto& read) {
    const bool is_new = read && !part;
    if (is_new) part = read;
    return is_new;
  };
  while (true) {
    const auto comma = text.find(',');
    const std::string_view part = trimmed(text.substr(0, comma));
    if (!take(format.unit, parse_unit(part)) && !take(format.zeros, parse_zeros(part)) &&
        !take(format.digits, parse_digits(part))) {
      return tl::make_unexpected(std::string(kExpected));
    }
    if (comma == std::string_view::npos) return format;
    text.remove_prefix(comma + 1);
  }
}

ParsedLength parse_length(std::string_view text, const NumberFormat& format) {
  const char* at = text.data();
  const char* const end = at + text.size();
  const bool negative = at != end && *at == '-';
  if (at != end && (*at == '-' || *at == '+')) ++at;

  std::int64_t mantissa = 0;
  int n_digits = 0;
  int n_behind_point = -1;  // -1: no point seen
  for (; at != end; ++at) {
    const unsigned digit = static_cast<unsigned char>(*at) - '0';
    if (digit < 10) {
      if (++n_digits > kMaxFormatDigits) return {{}, NumberFault::TooManyDigits};
      mantissa = mantissa * 10 + digit;
      if (n_behind_point >= 0) ++n_behind_point;
    } else if (*at == '.' && n_behind_point < 0) {
      n_behind_point = 0;
    } else {
      return {{}, NumberFault::Malformed};
    }
  }
  // A lone sign or point is not the manual's way to write zero.
  if (n_digits == 0 && !text.empty()) return {{}, NumberFault::Malformed};

  int exponent = 0;  // value = mantissa / 10^exponent
  if (n_behind_point >= 0) {
    exponent = n_behind_point;
  } else if (n_digits > format.integer_digits + format.decimal_digits) {
    if (!is_padded(mantissa, format)) return {{}, NumberFault::TooManyDigits};
    exponent = format.decimal_digits;
  } else if (format.zeros == Zeros::TrailingKept) {
    exponent = format.decimal_digits;
  } else {
    exponent = n_digits - format.integer_digits;
  }
  const double magnitude = exponent >= 0 ? static_cast<double>(mantissa) / kFormatPowers[exponent]
                                         : static_cast<double>(mantissa) * kFormatPowers[-exponent];
  return {format.one_unit() * (negative ? -magnitude : magnitude), NumberFault::None};
}

bool has_extra_digits(std::string_view number, const NumberFormat& format) {
  const bool has_sign = number.starts_with('-') || number.starts_with('+');
  const auto n_digits = static_cast<int>(number.size()) - (has_sign ? 1 : 0);
  return n_digits > format.integer_digits + format.decimal_digits &&
         number.find('.') == std::string_view::npos;
}

bool is_bare(std::string_view number) {
  return number.find('.') == std::string_view::npos &&
         number.find_first_of("123456789") != std::string_view::npos;
}

bool has_bare_number(std::string_view text) {
  constexpr std::string_view kNumber = ".0123456789";
  while (true) {
    const auto begin = text.find_first_of(kNumber);
    if (begin == std::string_view::npos) return false;
    text.remove_prefix(begin);
    const std::string_view number = text.substr(0, text.find_first_not_of(kNumber));
    if (is_bare(number)) return true;
    text.remove_prefix(number.size());
  }
}

std::optional<int> parse_count(std::string_view text) {
  if (text.empty() || text.size() > 9) return std::nullopt;
  unsigned value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size()) return std::nullopt;
  return static_cast<int>(value);
}

}  // namespace panelcal
