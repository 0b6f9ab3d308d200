// SPDX-License-Identifier: Apache-2.0
#include "program/writers/text_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::size_t kFlushBytes = std::size_t{1} << 16;

constexpr std::array<double, 10> kScale = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
constexpr std::array<std::uint32_t, 10> kWholeScale = {
    1, 10, 100, 1'000, 10'000, 100'000, 1'000'000, 10'000'000, 100'000'000, 1'000'000'000};

using internal::copy_digits;
using internal::kDecimals;
using internal::kWholes;

/// Writes a point and the decimals without trailing zeros; gives their end. Precondition: not 0.
char* write_decimals(std::uint32_t billionths, char* at) {
  *at = '.';
  int n_shown = copy_digits(kDecimals[billionths / 1'000'000], at + 1);
  const std::uint32_t behind_3 = billionths % 1'000'000;
  if (behind_3 == 0) return at + 1 + n_shown;
  n_shown = copy_digits(kDecimals[behind_3 / 1000], at + 4);
  const std::uint32_t behind_6 = behind_3 % 1000;
  if (behind_6 == 0) return at + 4 + n_shown;
  return at + 7 + copy_digits(kDecimals[behind_6], at + 7);
}

/// 10^n, 0 <= n <= 304.
double power_of_ten(int n) {
  static constexpr std::array<double, 305> kPowers = [] {
    std::array<double, 305> powers{};
    double power = 1;
    for (double& entry : powers) {
      entry = power;
      power *= 10;
    }
    return powers;
  }();
  return kPowers[static_cast<std::size_t>(n)];
}

char* write_digits(char* at, int n) {
  const fmt::format_int digits(n);
  return std::copy_n(digits.data(), digits.size(), at);
}

/// d.ddd x 10^exponent of the digits, exponent <= 0, as 0.00123 or 1.23e-05.
char* write_general(char* at, int digits, int n_digits, int exponent) {
  constexpr int kLeastFixed = -4;
  if (exponent == 0) return write_digits(at, digits);  // only 1
  if (exponent >= kLeastFixed) {
    *at++ = '0';
    *at++ = '.';
    at = std::fill_n(at, -exponent - 1, '0');
    return write_digits(at, digits);
  }
  char* const end = write_digits(at + 1, digits);
  at[0] = at[1];
  at[1] = '.';
  at = n_digits == 1 ? at + 1 : end;
  at = std::copy_n(exponent > -10 ? "e-0" : "e-", exponent > -10 ? 3 : 2, at);
  return write_digits(at, -exponent);
}

}  // namespace

void TextWriter::write(std::string_view text) {
  if (status_ && !text.empty()) status_ = bytes_.write(text);
}

void TextWriter::flush() {
  write(text_);
  text_.clear();
  write({rows_.data(), n_row_chars_});
  n_row_chars_ = 0;
}

void TextWriter::take_rows() {
  text_.append(rows_.data(), n_row_chars_);
  n_row_chars_ = 0;
}

void TextWriter::make_room() {
  if (rows_.empty()) return rows_.resize(kFlushBytes + kMostRow);
  flush();
}

void TextWriter::flush_if_large() {
  if (text_.size() >= kFlushBytes) flush();
}

void TextWriter::fail(Diagnostic diagnostic) {
  if (status_) status_ = failure(std::move(diagnostic));
}

Expected<void> TextWriter::finish() {
  end();
  flush();
  return std::move(status_);
}

char* write_fixed(char* at, double value, int n_decimals) {
  const double scaled = std::abs(value * kScale[static_cast<std::size_t>(n_decimals)]);
  // Beyond exact whole numbers, and NaN.
  if (!(scaled < 9e15)) {
    const std::string text = fmt::format("{}", value);
    return std::copy(text.begin(), text.end(), at);
  }
  const auto steps =
      static_cast<std::uint64_t>(static_cast<std::int64_t>(scaled + internal::kBelowHalf));
  const std::uint32_t unit = kWholeScale[static_cast<std::size_t>(n_decimals)];
  const std::uint64_t whole = steps / unit;
  const auto billionths = static_cast<std::uint32_t>(steps % unit) *
                          kWholeScale[static_cast<std::size_t>(9 - n_decimals)];

  if (value < 0 && steps != 0) *at++ = '-';
  if (whole < kWholes.size()) {
    at += copy_digits(kWholes[whole], at);
  } else {
    const fmt::format_int digits(whole);
    at = std::copy_n(digits.data(), digits.size(), at);
  }
  return billionths != 0 ? write_decimals(billionths, at) : at;
}

void append_fixed(std::string& out, double value, int n_decimals) {
  std::array<char, kFixedChars> text;
  const char* const end = write_fixed(text.data(), value, n_decimals);
  out.append(text.data(), static_cast<std::size_t>(end - text.data()));
}

void append_risk(std::string& out, double risk) {
  std::array<char, kRiskChars> digits;
  out.append(digits.data(), write_risk(digits.data(), risk));
}

char* write_risk(char* at, double risk) {
  // Written so that a NaN is certain, and what is too small to be a number of its own is 0.
  if (!(risk < 1)) risk = 1;
  if (risk < 1e-300) {
    *at = '0';
    return at + 1;
  }
  int exponent = static_cast<int>(std::floor(std::log10(risk)));
  auto digits = static_cast<int>(std::lround(risk * power_of_ten(3 - exponent)));
  if (digits >= 10'000) {
    digits /= 10;
    ++exponent;
  } else if (digits < 1000) {  // the logarithm was rounded up
    digits = static_cast<int>(std::lround(risk * power_of_ten(4 - exponent)));
    --exponent;
  }
  int n_digits = 4;
  for (; digits % 10 == 0; digits /= 10) --n_digits;
  return write_general(at, digits, n_digits, exponent);
}

}  // namespace panelcal
