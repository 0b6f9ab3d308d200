// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <type_traits>

#include "program/text/number_format.h"
#include "program/text/source_text.h"
#include <Eigen/Core>

namespace panelcal {

/// A block of nothing but X and Y, as nearly every block is.
struct PlainCoordinate {
  std::array<std::optional<double>, 2> xy_mm;  ///< an axis that the block leaves out is absent
  bool has_point = true;  ///< every number has a decimal point or no digits: any format reads it
  int n_points = 0;

  /// Place to which it leads from another: an axis that is left out stays.
  Eigen::Vector2d from(const Eigen::Vector2d& at_mm) const {
    return {xy_mm[0].value_or(at_mm.x()), xy_mm[1].value_or(at_mm.y())};
  }
};

/// Reads plain coordinate blocks fast, eight characters at a time.
///
/// It reads numbers bit for bit as parse_length does. The lines that it leaves alone (blanks, other
/// letters, Y before X, more than eight digits in a row, every fault) are no error: the general
/// reader must judge it.
///
/// See    tests/program/text/plain_coordinate_test.cc
class PlainReader {
 public:
  /// Precondition: the format's digit counts are 0 to 15.
  explicit PlainReader(const NumberFormat& format);

  /// Reads one plain block after the other, and moves the cursor behind those that `visit` took.
  /// Ends at the first block that is not plain or that `visit` does not take: that one is for
  /// LineCursor::next().
  ///
  /// In     stop: no line from this offset on
  ///        visit: bool(int line, const PlainCoordinate&); false: it did not take the block
  /// Out    false: nothing was taken
  template <class Visit>
  bool read_lines(LineCursor& cursor, std::size_t stop, Visit visit) const {
    return read_all(cursor, stop, visit, nullptr);
  }
  /// The same for those who need no places but the last one. Blocks that have both axes, and
  /// another such block behind them, are checked and passed over, unless `skip` wants to see them.
  ///
  /// In     skip: std::int64_t(std::int64_t n); how many of the next n blocks to pass over
  template <class Visit, class Skip>
  bool read_lines(LineCursor& cursor, std::size_t stop, Visit visit, Skip skip) const {
    return read_all(cursor, stop, visit, skip);
  }

 private:
  static constexpr int kMaxRun = 8;
  static constexpr int kMaxDigits = 15;  // as parse_length: exact in a double
  /// Characters behind a block's first that may be looked at: X and Y, each with a sign, a point
  /// and two runs of digits, and a line end.
  static constexpr std::size_t kMargin = 48;
  /// mantissa * times / per; one of the two is 1, so that only one operation rounds.
  struct Scale {
    double times = 1;
    double per = 1;
  };
  struct DigitRun {
    std::int64_t value = 0;
    int n_digits = 0;  ///< 0 to 8; at 8 the run may go on
  };
  static constexpr std::array<double, kMaxDigits + 1> kPowersOfTen = {
      1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
  static constexpr std::array<std::int64_t, 9> kWholePowersOfTen = {
      1, 10, 100, 1'000, 10'000, 100'000, 1'000'000, 10'000'000, 100'000'000};

  static constexpr std::uint64_t in_every_byte(std::uint64_t byte) {
    return byte * 0x0101010101010101;
  }
  /// Eight characters, the first one in the lowest byte.
  static std::uint64_t load_eight(const char* at) {
    std::uint64_t characters = 0;
    std::memcpy(&characters, at, sizeof characters);
    if constexpr (std::endian::native == std::endian::big) {
      characters = __builtin_bswap64(characters);
    }
    return characters;
  }
  /// The top bit of every byte above 9. One of them may carry into the bytes behind it, never
  /// before it.
  static std::uint64_t not_digits(std::uint64_t values) {
    return (values | (values + in_every_byte(0x80 - 10))) & in_every_byte(0x80);
  }
  /// The number that the first n bytes are the digits of, 1 <= n <= 8.
  static std::int64_t value_of(std::uint64_t values, int n) {
    // Digits to the top, zeros before them; then pairs, fours and eights of digits at once.
    std::uint64_t sum = values << (8 * (8 - n));
    sum = (sum * ((10 << 8) + 1) >> 8) & 0x00FF00FF00FF00FF;
    sum = (sum * ((100 << 16) + 1) >> 16) & 0x0000FFFF0000FFFF;
    sum = sum * ((std::uint64_t{10'000} << 32) + 1) >> 32;
    return static_cast<std::int64_t>(sum);
  }
  /// The digits that eight characters begin with.
  static DigitRun read_digits(std::uint64_t characters) {
    const std::uint64_t values = characters ^ in_every_byte('0');
    const int n_digits = std::countr_zero(not_digits(values)) / 8;
    if (n_digits == 0) return {};
    return {value_of(values, n_digits), n_digits};
  }

  /// `skip` may be null.
  template <class Visit, class Skip>
  bool read_all(LineCursor& cursor, std::size_t stop, Visit& visit, Skip skip) const {
    const std::string_view text = cursor.text();
    const std::size_t begin = cursor.offset();
    stop = std::min(stop, text.size());
    if (begin + kMargin < text.size()) {
      read_some(
          cursor, text.data(), std::min(stop, text.size() - kMargin), text.size(), visit, skip);
    }
    if (cursor.offset() < stop && cursor.offset() + kMargin >= text.size()) {
      // The last lines are read where something follows them.
      std::array<char, 2 * kMargin> last{};
      const std::string_view rest = text.substr(cursor.offset());
      rest.copy(last.data(), rest.size());
      read_some(cursor, last.data() - cursor.offset(), stop, text.size(), visit, skip);
    }
    return cursor.offset() != begin;
  }

  /// Precondition: kMargin characters may be read from every line that begins before `stop`
  template <class Visit, class Skip>
  void read_some(LineCursor& cursor,
                 const char* text,
                 std::size_t stop,
                 std::size_t size,
                 Visit& visit,
                 Skip& skip) const {
    const char* const begin = text + cursor.offset();
    const char* const end = text + size;
    const char* at = begin;
    const int first_line = cursor.line_number();
    int line = first_line;
    PlainCoordinate block;
    Layout layout;
    int n_lines_without = 0;
    while (at < text + stop) {
      if constexpr (!std::is_null_pointer_v<Skip>) {
        const std::int64_t n_skipped = skip(count_alike(at, text + stop, layout));
        at += n_skipped * static_cast<std::int64_t>(layout.length);
        line += static_cast<int>(n_skipped);
      }
      if (is_alike(at, layout)) {
        if (!visit(line, read_alike(at, layout))) break;
        at += layout.length;
        ++line;
        continue;
      }
      const char* const next = read_block(at, block);
      if (next == nullptr) break;
      // If layouts change all the time, looking for them costs more than it saves.
      constexpr int kLinesWithout = 32;
      const bool is_time = --n_lines_without < 0;
      layout = is_time ? layout_of(at, next) : Layout();
      if (is_time) n_lines_without = kLinesWithout;
      // Not at a line end: a blank, a second point, the ninth digit of a run, anything else.
      if (*next != '\n' && *next != '\r' && next != end) break;
      if (!visit(line, block)) break;
      at = next == end ? end : next + line_end_length(next, end);
      ++line;
    }
    cursor.skip(static_cast<std::size_t>(at - begin), line - first_line);
  }

  /// The digits of a number without sign and point, of which there is a known count.
  struct DigitLayout {
    std::uint64_t tops = 0;  ///< the top bits of their bytes
    int n_digits = 0;
    Scale scale;
  };
  /// A block of both axes that ends in LF, as the last one was: where the next block begins is
  /// known before this one has been read.
  struct Layout {
    std::size_t y = 0;       ///< offset of the letter
    std::size_t length = 0;  ///< with the LF; 0: the block was not so
    DigitLayout x_digits;
    DigitLayout y_digits;
  };
  Layout layout_of(const char* at, const char* end) const {
    const std::string_view block(at, static_cast<std::size_t>(end - at));
    const std::size_t y = block.find('Y');
    if (block.front() != 'X' || y == block.npos || block.find_first_of("+-.") != block.npos) {
      return {};
    }
    const std::size_t n_x = y - 1;
    const std::size_t n_y = block.size() - y - 1;
    if (n_x == 0 || n_y == 0) return {};
    return {y, block.size() + 1, digit_layout(n_x), digit_layout(n_y)};
  }
  /// Precondition: 1 <= n_digits <= kMaxRun
  DigitLayout digit_layout(std::size_t n_digits) const {
    return {in_every_byte(0x80) >> (8 * (kMaxRun - n_digits)),
            static_cast<int>(n_digits),
            of_count_[n_digits]};
  }

  static std::uint64_t load_values(const char* at) { return load_eight(at) ^ in_every_byte('0'); }
  static bool is_alike(const char* at, const Layout& layout) {
    const std::uint64_t no_x = not_digits(load_values(at + 1)) & layout.x_digits.tops;
    const std::uint64_t no_y = not_digits(load_values(at + layout.y + 1)) & layout.y_digits.tops;
    const char* const next = at + layout.length;
    // LF CR would be one line end.
    return layout.length != 0 && *at == 'X' && at[layout.y] == 'Y' && (no_x | no_y) == 0 &&
           next[-1] == '\n' && next[0] != '\r';
  }
  /// Number of blocks from here on that have the layout, but for the last of them.
  static std::int64_t count_alike(const char* at, const char* stop, const Layout& layout) {
    std::int64_t n = 0;
    for (; at < stop && is_alike(at, layout); at += layout.length) ++n;
    return std::max<std::int64_t>(n - 1, 0);
  }
  /// Precondition: is_alike()
  PlainCoordinate read_alike(const char* at, const Layout& layout) const {
    return {{length_mm(load_values(at + 1), layout.x_digits),
             length_mm(load_values(at + layout.y + 1), layout.y_digits)},
            false,
            0};
  }
  double length_mm(std::uint64_t values, const DigitLayout& digits) const {
    const auto mantissa = static_cast<double>(value_of(values, digits.n_digits));
    return unit_mm_ * (mantissa * digits.scale.times / digits.scale.per);
  }

  /// Reads the number behind an axis's letter; gives its end, null if it is not plain.
  const char* read_number(const char* at, std::optional<double>& mm, PlainCoordinate& out) const {
    const char* const begin = at;
    const bool is_negative = *at == '-';
    if (is_negative || *at == '+') ++at;
    const DigitRun whole = read_digits(load_eight(at));
    at += whole.n_digits;
    double mantissa = static_cast<double>(whole.value);
    Scale scale = of_count_[static_cast<std::size_t>(whole.n_digits)];
    if (*at == '.') {
      ++at;
      ++out.n_points;
      const DigitRun fraction = read_digits(load_eight(at));
      at += fraction.n_digits;
      const int n_digits = whole.n_digits + fraction.n_digits;
      if (n_digits == 0 || n_digits > kMaxDigits) return nullptr;
      const auto n_behind = static_cast<std::size_t>(fraction.n_digits);
      mantissa = static_cast<double>(whole.value * kWholePowersOfTen[n_behind] + fraction.value);
      scale = {1, kPowersOfTen[n_behind]};
    } else if (at != begin) {
      if (whole.n_digits == 0 || whole.n_digits > n_most_digits_) return nullptr;
      out.has_point = false;
    }
    const double magnitude = mantissa * scale.times / scale.per;
    mm = unit_mm_ * (is_negative ? -magnitude : magnitude);
    return at;
  }

  /// Reads the axes that a block begins with; gives what follows, null if there is none or if a
  /// number is not plain. Precondition: kMargin characters from `at` on
  const char* read_block(const char* at, PlainCoordinate& out) const {
    out.has_point = true;
    out.n_points = 0;
    const bool has_x = *at == 'X';
    if (has_x) {
      at = read_number(at + 1, out.xy_mm[0], out);
      if (at == nullptr) return nullptr;
    } else {
      out.xy_mm[0].reset();
    }
    if (*at == 'Y') return read_number(at + 1, out.xy_mm[1], out);
    out.xy_mm[1].reset();
    return has_x ? at : nullptr;
  }

  double unit_mm_;
  int n_most_digits_;                        ///< without a decimal point
  std::array<Scale, kMaxRun + 1> of_count_;  ///< by the number of digits, without a decimal point
};

}  // namespace panelcal
