// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>
#include <type_traits>

namespace panelcal {

/// Characters that write_fixed may touch.
inline constexpr std::size_t kFixedChars = 32;
/// Characters that write_count may touch.
inline constexpr std::size_t kCountChars = 16;

namespace internal {

/// Digits of a number below 1000. The count rides along, so that a copy is one store.
struct Digits {
  std::array<char, 3> text;
  std::int8_t n_shown;
};
/// The count of three decimals that are zeros: so few that the point before the first three, or the
/// digits before later ones, are not shown for their sake.
inline constexpr std::int8_t kNoneShown = -8;
using DigitTable = std::array<Digits, 1000>;

/// All three digits; shown as decimals, that is without trailing zeros; kNoneShown of 000.
inline constexpr DigitTable kDecimals = [] {
  DigitTable table{};
  const auto digit = [](int n) { return static_cast<char>('0' + n % 10); };
  for (int n = 0; n < 1000; ++n) {
    const int n_shown = n % 10 != 0 ? 3 : n % 100 != 0 ? 2 : n != 0 ? 1 : kNoneShown;
    table[static_cast<std::size_t>(n)] = {{digit(n / 100), digit(n / 10), digit(n)},
                                          static_cast<std::int8_t>(n_shown)};
  }
  return table;
}();

/// Without leading zeros.
inline constexpr DigitTable kWholes = [] {
  DigitTable table = kDecimals;
  for (std::size_t n = 0; n < table.size(); ++n) {
    table[n].n_shown = n < 10 ? 1 : n < 100 ? 2 : 3;
    std::copy(table[n].text.end() - table[n].n_shown, table[n].text.end(), table[n].text.begin());
  }
  return table;
}();

/// Writes four characters and gives how many of them to show.
inline int copy_digits(const Digits& digits, char* at) {
  std::memcpy(at, &digits, sizeof digits);
  return digits.n_shown;
}

constexpr std::uint32_t power_of_ten(int n) {
  return n == 0 ? 1 : 10 * power_of_ten(n - 1);
}

/// The double below a half: cutting the fraction off x + kBelowHalf, 0 <= x < 2^53, rounds half
/// away from zero. The sum of a fraction of a half is so close to the next whole number that it is
/// rounded there, and that of the next smaller fraction is not; a half itself would take both
/// there.
inline constexpr double kBelowHalf = 0x1.fffffffffffffp-2;

}  // namespace internal

/// The general form of write_fixed_as, for values that are large or no numbers; gives the end.
char* write_fixed(char* at, double value, int n_decimals);

/// Writes a whole number, n >= 0; gives the end.
inline char* write_count(char* at, std::uint32_t n) {
  using internal::copy_digits;
  if (n < 1000) return at + copy_digits(internal::kWholes[n], at);
  if (n < 1'000'000) {
    at += copy_digits(internal::kWholes[n / 1000], at);
    copy_digits(internal::kDecimals[n % 1000], at);
    return at + 3;
  }
  if (n < 1'000'000'000) {
    at += copy_digits(internal::kWholes[n / 1'000'000], at);
  } else {
    at += copy_digits(internal::kWholes[n / 1'000'000'000], at);
    copy_digits(internal::kDecimals[n / 1'000'000 % 1000], at);
    at += 3;
  }
  n %= 1'000'000;
  copy_digits(internal::kDecimals[n / 1000], at);
  copy_digits(internal::kDecimals[n % 1000], at + 3);
  return at + 6;
}

namespace internal {

/// write_fixed_as where it has no table: large values and NaN.
template <int kN>
[[gnu::noinline]] char* write_fixed_beyond(char* at, double value, std::string_view after_whole) {
  char* const end = write_fixed(at, value, kN);
  return std::find(at, end, '.') != end ? end : std::ranges::copy(after_whole, end).out;
}

}  // namespace internal

/// Writes a value in fixed point with at most kN decimals (2 to 9), trailing zeros and a lone point
/// left off: 12.5, -0.000125, 3. Rounds half away from zero. Gives the end.
///
/// The digits come by threes from tables that know how many of them to show, so that nothing has to
/// be decided and no digit is guessed wrong by the processor. It is inlined, since writers of holes
/// do little else.
///
/// In     at: kFixedChars are free
///        after_whole: copied behind a number without a point
template <int kN>
[[gnu::always_inline]] inline char* write_fixed_as(char* at,
                                                   double value,
                                                   std::string_view after_whole = {}) {
  static_assert(kN >= 2 && kN <= 9);
  using internal::copy_digits;
  // Fewer than three or six decimals are as many of which the last ones are zeros.
  constexpr int kDigits = kN <= 3 ? 3 : std::max(kN, 6);
  constexpr std::uint32_t kUnit = internal::power_of_ten(kDigits);
  constexpr std::uint32_t kRounded = internal::power_of_ten(kN);
  constexpr double kMostWhole = 999;
  using Steps = std::conditional_t<kDigits <= 6, std::uint32_t, std::uint64_t>;
  static_assert(kDigits > 6 || (kMostWhole + 1) * kUnit < std::numeric_limits<Steps>::max());
  const double scaled = std::abs(value * kRounded);
  // NaN goes this way too.
  if (!(scaled < kMostWhole * kRounded)) {
    return internal::write_fixed_beyond<kN>(at, value, after_whole);
  }
  const auto steps = static_cast<Steps>(
      static_cast<Steps>(static_cast<std::int64_t>(scaled + internal::kBelowHalf)) *
      (kUnit / kRounded));
  const auto whole = static_cast<std::uint32_t>(steps / kUnit);
  const auto decimals = static_cast<std::uint32_t>(steps - Steps{whole} * kUnit);
  *at = '-';
  at += (std::bit_cast<std::uint64_t>(value) >> 63) & static_cast<std::uint64_t>(steps != 0);
  at += copy_digits(internal::kWholes[whole], at);
  // As if there were nine: the first three, the next three and the last ones.
  constexpr std::uint32_t kFirst = internal::power_of_ten(kDigits - 3);
  *at = '.';
  const std::uint32_t behind_3 = decimals % kFirst;
  int n_shown = std::max(0, 1 + copy_digits(internal::kDecimals[decimals / kFirst], at + 1));
  if constexpr (kDigits >= 6) {
    constexpr std::uint32_t kNext = internal::power_of_ten(kDigits - 6);
    n_shown = std::max(n_shown, 4 + copy_digits(internal::kDecimals[behind_3 / kNext], at + 4));
    if constexpr (kDigits > 6) {
      const std::uint32_t behind_6 = behind_3 % kNext * internal::power_of_ten(9 - kN);
      n_shown = std::max(n_shown, 7 + copy_digits(internal::kDecimals[behind_6], at + 7));
    }
  }
  if (!after_whole.empty() && n_shown == 0) return std::ranges::copy(after_whole, at).out;
  return at + n_shown;
}

}  // namespace panelcal
