// SPDX-License-Identifier: Apache-2.0
#include "program/text/number_format.h"

#include <array>
#include <charconv>
#include <cstddef>

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

}  // namespace

std::string NumberFormat::summary() const {
  std::string text = unit == LengthUnit::Inch ? "inch " : "metric ";
  text += std::to_string(integer_digits) + "." + std::to_string(decimal_digits);
  text += zeros == Zeros::LeadingKept ? ", leading zeros kept" : ", trailing zeros kept";
  return text;
}

void NumberFormat::take_usual_digits() {
  integer_digits = unit == LengthUnit::Inch ? 2 : 3;
  decimal_digits = unit == LengthUnit::Inch ? 4 : 3;
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

std::optional<int> parse_count(std::string_view text) {
  if (text.empty() || text.size() > 9) return std::nullopt;
  unsigned value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size()) return std::nullopt;
  return static_cast<int>(value);
}

}  // namespace panelcal
