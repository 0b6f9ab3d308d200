// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/writers/text_writer.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::size_t kFlushBytes = std::size_t{1} << 16;

}  // namespace

void TextWriter::flush() {
  if (status_) status_ = bytes_.write(text_);
  text_.clear();
}

void TextWriter::flush_if_large() {
  if (text_.size() >= kFlushBytes) flush();
}

Expected<void> TextWriter::finish() {
  flush();
  return std::move(status_);
}

void append_fixed(std::string& out, double value, int n_decimals) {
  constexpr std::array<double, 10> kScale = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
  const double scaled = value * kScale[static_cast<std::size_t>(n_decimals)];
  if (!(std::abs(scaled) < 9e15)) {  // beyond exact whole numbers, and NaN
    fmt::format_to(std::back_inserter(out), "{}", value);
    return;
  }
  std::int64_t whole = std::llround(scaled);
  if (whole < 0) {
    out += '-';
    whole = -whole;
  }
  const auto unit = static_cast<std::int64_t>(kScale[static_cast<std::size_t>(n_decimals)]);
  const fmt::format_int integer(whole / unit);
  out.append(integer.data(), integer.size());
  std::int64_t fraction = whole % unit;
  if (fraction == 0) return;
  std::array<char, 9> digits{};
  int n = n_decimals;
  for (int i = n_decimals - 1; i >= 0; --i) {
    digits[static_cast<std::size_t>(i)] = static_cast<char>('0' + fraction % 10);
    fraction /= 10;
  }
  while (digits[static_cast<std::size_t>(n - 1)] == '0') --n;
  out += '.';
  out.append(digits.data(), static_cast<std::size_t>(n));
}

}  // namespace panelcal
