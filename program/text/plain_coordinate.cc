// SPDX-License-Identifier: Apache-2.0
#include "program/text/plain_coordinate.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace panelcal {
namespace {

constexpr int kMaxPlainDigits =
    15;  // as parse_length: every integer of 15 digits is exact in a double
constexpr std::array<double, kMaxPlainDigits + 1> kPlainPowers = {
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
constexpr std::array<std::int64_t, 9> kWholePowersOfTen = {
    1, 10, 100, 1'000, 10'000, 100'000, 1'000'000, 10'000'000, 100'000'000};

constexpr std::uint64_t in_every_byte(std::uint64_t byte) {
  return byte * 0x0101010101010101;
}

/// Eight characters, the first one in the lowest byte.
inline std::uint64_t load_eight(const char* at) {
  std::uint64_t characters = 0;
  std::memcpy(&characters, at, sizeof characters);
  if constexpr (std::endian::native == std::endian::big) {
    characters = __builtin_bswap64(characters);
  }
  return characters;
}

/// The next eight characters of the line; zero bytes stand for what lies behind its end.
inline std::uint64_t next_eight(std::string_view line, const char* at) {
  const char* const end = line.data() + line.size();
  const std::ptrdiff_t n_left = end - at;
  if (n_left >= 8) return load_eight(at);
  // The last eight, without those before `at`: one load instead of one for each character.
  if (n_left > 0 && line.size() >= 8) return load_eight(end - 8) >> (8 * (8 - n_left));
  std::uint64_t characters = 0;
  for (std::ptrdiff_t i = 0; i < n_left; ++i) {
    characters |= std::uint64_t{static_cast<unsigned char>(at[i])} << (8 * i);
  }
  return characters;
}

struct DigitRun {
  std::int64_t value = 0;
  int n_digits = 0;  ///< 0 to 8; at 8 the run may go on
};

/// The digits that `characters` begin with.
inline DigitRun read_digits(std::uint64_t characters) {
  const std::uint64_t values = characters ^ in_every_byte('0');
  // A byte above 9 gets its top bit set. It may carry into the bytes behind it, never before it.
  const std::uint64_t others = (values | (values + in_every_byte(0x80 - 10))) & in_every_byte(0x80);
  const int n_digits = std::countr_zero(others) / 8;
  if (n_digits == 0) return {};
  // Digits to the top, zeros before them; then pairs, fours and eights of digits at once.
  std::uint64_t sum = values << (8 * (8 - n_digits));
  sum = (sum * ((10 << 8) + 1) >> 8) & 0x00FF00FF00FF00FF;
  sum = (sum * ((100 << 16) + 1) >> 16) & 0x0000FFFF0000FFFF;
  sum = sum * ((std::uint64_t{10'000} << 32) + 1) >> 32;
  return {static_cast<std::int64_t>(sum), n_digits};
}

}  // namespace

PlainReader::PlainReader(const NumberFormat& format)
    : unit_mm_(format.one_unit().in_mm()),
      n_most_digits_(std::min(kMaxRun, format.integer_digits + format.decimal_digits)) {
  for (int n_digits = 0; n_digits <= kMaxRun; ++n_digits) {
    const int exponent = format.zeros == Zeros::TrailingKept ? format.decimal_digits
                                                             : n_digits - format.integer_digits;
    Scale& scale = of_count_[static_cast<std::size_t>(n_digits)];
    if (exponent >= 0) {
      scale.per = kPlainPowers[static_cast<std::size_t>(exponent)];
    } else {
      scale.times = kPlainPowers[static_cast<std::size_t>(-exponent)];
    }
  }
}

bool PlainReader::read(std::string_view line, PlainCoordinate& out) const {
  const char* at = line.data();
  const char* const end = at + line.size();
  const auto is_next = [&](char c) { return at != end && *at == c; };
  out.has_point = true;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    out.xy_mm[axis].reset();
    if (!is_next(axis == 0 ? 'X' : 'Y')) continue;
    const char* const begin = ++at;
    const bool is_negative = is_next('-');
    if (is_negative || is_next('+')) ++at;
    const DigitRun whole = read_digits(next_eight(line, at));
    at += whole.n_digits;

    double mantissa = static_cast<double>(whole.value);
    Scale scale = of_count_[static_cast<std::size_t>(whole.n_digits)];
    if (is_next('.')) {
      ++at;
      const DigitRun fraction = read_digits(next_eight(line, at));
      at += fraction.n_digits;
      const int n_digits = whole.n_digits + fraction.n_digits;
      if (n_digits == 0 || n_digits > kMaxPlainDigits) return false;
      const auto n_behind = static_cast<std::size_t>(fraction.n_digits);
      mantissa = static_cast<double>(whole.value * kWholePowersOfTen[n_behind] + fraction.value);
      scale = {1, kPlainPowers[n_behind]};
    } else if (at != begin) {
      if (whole.n_digits == 0 || whole.n_digits > n_most_digits_) return false;
      out.has_point = false;
    }
    const double magnitude = mantissa * scale.times / scale.per;
    out.xy_mm[axis] = unit_mm_ * (is_negative ? -magnitude : magnitude);
  }
  // Not at the end: a blank, a second point, the ninth digit of a run, anything else.
  return at == end && !line.empty();
}

}  // namespace panelcal
