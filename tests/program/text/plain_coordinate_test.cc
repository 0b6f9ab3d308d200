// SPDX-License-Identifier: Apache-2.0
#include "program/text/plain_coordinate.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal::excellon {
namespace {

constexpr std::uint64_t kSeed = 20261121;
constexpr std::size_t kLongestRun = 8;

std::vector<NumberFormat> all_formats() {
  std::vector<NumberFormat> formats;
  for (const LengthUnit unit : {LengthUnit::Inch, LengthUnit::Millimeter}) {
    for (const Zeros zeros : {Zeros::LeadingKept, Zeros::TrailingKept}) {
      for (int integer_digits = 0; integer_digits <= 6; ++integer_digits) {
        for (int decimal_digits = 0; decimal_digits <= 6; ++decimal_digits) {
          formats.push_back({unit, zeros, false, integer_digits, decimal_digits});
        }
      }
    }
  }
  return formats;
}

/// The line stands in memory of exactly its size, so that a sanitizer sees every byte read too far.
std::optional<PlainCoordinate> read(std::string_view line, const NumberFormat& format) {
  const std::vector<char> exact(line.begin(), line.end());
  LineCursor cursor({exact.data(), exact.size()});
  std::optional<PlainCoordinate> read;
  PlainReader(format).read_lines(cursor, line.size(), [&](int, const PlainCoordinate& block) {
    read = block;
    return true;
  });
  return cursor.at_end() && cursor.line_number() == 2 && line.find_first_of("\r\n") == line.npos
             ? read
             : std::nullopt;
}

/// The same word by word through parse_length. Whatever is not X and Y, each once, each without a
/// fault, is nothing.
std::optional<PlainCoordinate> read_slowly(std::string_view line, const NumberFormat& format) {
  PlainCoordinate coordinate;
  if (line.empty()) return std::nullopt;
  while (!line.empty()) {
    if (line[0] != 'X' && line[0] != 'Y') return std::nullopt;
    std::optional<double>& axis_mm = coordinate.xy_mm[line[0] == 'X' ? 0 : 1];
    const std::size_t next = std::min(line.find_first_of("XY", 1), line.size());
    const std::string_view number = line.substr(1, next - 1);
    const ParsedLength parsed = parse_length(number, format);
    if (axis_mm || parsed.fault != NumberFault::None) return std::nullopt;
    axis_mm = parsed.value.in_mm();
    if (!number.empty() && number.find('.') == std::string_view::npos) coordinate.has_point = false;
    line.remove_prefix(next);
  }
  return coordinate;
}

/// Line that the reader need not read although it has no fault: it is rare.
bool is_unusual(std::string_view line) {
  if (line[0] == 'Y' && line.find('X') != std::string_view::npos) return true;
  std::size_t n_digits = 0;
  for (const char c : line) {
    n_digits = c >= '0' && c <= '9' ? n_digits + 1 : 0;
    if (n_digits > kLongestRun) return true;
  }
  return false;
}

bool is_same(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return std::bit_cast<std::uint64_t>(*a) == std::bit_cast<std::uint64_t>(*b);
}

/// Bit-identical where read, and read wherever it should be.
::testing::AssertionResult agrees(std::string_view line, const NumberFormat& format) {
  const auto fast = read(line, format);
  const auto slow = read_slowly(line, format);
  const bool leaves_alone = !slow || is_unusual(line);
  const auto failure = [&] {
    return ::testing::AssertionFailure() << "'" << line << "' as " << format.summary() << ": ";
  };
  if (fast.has_value() == leaves_alone) return failure() << (fast ? "read" : "not read");
  if (!fast) return ::testing::AssertionSuccess();
  if (!is_same(fast->xy_mm[0], slow->xy_mm[0]) || !is_same(fast->xy_mm[1], slow->xy_mm[1])) {
    return failure() << "another value";
  }
  if (fast->has_point != slow->has_point) return failure() << "has_point";
  return ::testing::AssertionSuccess();
}

std::size_t below(Random& random, std::size_t n) {
  return static_cast<std::size_t>(random.uniform() * static_cast<double>(n));
}

char any_of(Random& random, std::string_view characters) {
  return characters[below(random, characters.size())];
}

/// A number of up to `n_most` digits with or without sign and point.
std::string random_number(Random& random, std::size_t n_most) {
  std::string number;
  for (std::size_t n = below(random, n_most + 1); n > 0; --n) {
    number += any_of(random, random.uniform() < 0.3 ? "09" : "0123456789");
  }
  if (random.uniform() < 0.3) number.insert(below(random, number.size() + 1), 1, '.');
  if (random.uniform() < 0.3) number.insert(0, 1, any_of(random, "+-"));
  return number;
}

std::string random_line(Random& random, std::size_t n_most_digits) {
  const std::string x = "X" + random_number(random, n_most_digits);
  const std::string y = "Y" + random_number(random, n_most_digits);
  switch (below(random, 5)) {
    case 0:
      return x;
    case 1:
      return y;
    case 2:
      return y + x;
    default:
      return x + y;
  }
}

TEST(PlainCoordinate, RandomBlocksAgreeBitForBit) {
  Random random(kSeed);
  for (const NumberFormat& format : all_formats()) {
    for (int i = 0; i < 2000; ++i) {
      ASSERT_TRUE(agrees(random_line(random, 6), format)) << "seed " << kSeed;
    }
  }
}

TEST(PlainCoordinate, LongNumbersAgreeBitForBit) {
  Random random(kSeed);
  for (const NumberFormat& format : all_formats()) {
    for (int i = 0; i < 500; ++i) {
      ASSERT_TRUE(agrees(random_line(random, 18), format)) << "seed " << kSeed;
    }
  }
}

TEST(PlainCoordinate, SpoiltBlocksAgreeBitForBit) {
  Random random(kSeed);
  std::string hostile = "XY0123456789.+- \t/;,%GMTRxy:@\r\n\x7F\x80\xB0\xB9\xFF";
  hostile += '\0';
  for (const NumberFormat& format : all_formats()) {
    for (int i = 0; i < 1000; ++i) {
      std::string line = random_line(random, 8);
      for (std::size_t n = 1 + below(random, 3); n > 0; --n) {
        const std::size_t at = below(random, line.size() + 1);
        if (random.uniform() < 0.3) {
          line.erase(at, 1);
        } else if (random.uniform() < 0.5 && at < line.size()) {
          line[at] = any_of(random, hostile);
        } else {
          line.insert(at, 1, any_of(random, hostile));
        }
      }
      ASSERT_TRUE(agrees(line, format)) << "seed " << kSeed;
    }
  }
}

TEST(PlainCoordinate, EveryByteBehindAndInsideANumberAgrees) {
  for (const NumberFormat& format : all_formats()) {
    for (int byte = 0; byte < 256; ++byte) {
      const std::string any(1, static_cast<char>(byte));
      for (const std::string& line : {any,
                                      "X" + any,
                                      "X1" + any + "2",
                                      "X12" + any + "Y3",
                                      "X00123456" + any,
                                      "Y" + any + "12.5",
                                      "X1.5Y-12.34" + any,
                                      any + "X1Y2"}) {
        ASSERT_TRUE(agrees(line, format)) << "byte " << byte;
      }
    }
  }
}

/// Block of one line, with its number.
struct NumberedBlock {
  int line = 0;
  std::optional<PlainCoordinate> block;
};

/// Line by line.
std::vector<NumberedBlock> read_each(std::string_view text, const NumberFormat& format) {
  std::vector<NumberedBlock> blocks;
  for (LineCursor cursor(text); !cursor.at_end();) {
    const SourceLine line = cursor.next();
    blocks.push_back({line.number, read(line.text, format)});
  }
  return blocks;
}

/// Plain lines many at once up to `stop`, at most `n_at_once`; LineCursor has the others, and those
/// behind `stop`.
std::vector<NumberedBlock> read_many(std::string_view text,
                                     const NumberFormat& format,
                                     std::size_t stop,
                                     int n_at_once) {
  const PlainReader reader(format);
  std::vector<NumberedBlock> blocks;
  for (LineCursor cursor(text); !cursor.at_end();) {
    int n_left = n_at_once;
    reader.read_lines(cursor, stop, [&](int line, const PlainCoordinate& block) {
      if (n_left-- == 0) return false;
      blocks.push_back({line, block});
      return true;
    });
    if (cursor.at_end()) break;
    const SourceLine line = cursor.next();
    const bool is_behind = cursor.offset() > stop || n_left < 0;
    blocks.push_back({line.number, is_behind ? read(line.text, format) : std::nullopt});
  }
  return blocks;
}

/// Lines of all kinds with line ends of all kinds, most of them of one kind.
std::string random_text(Random& random) {
  constexpr std::array<std::string_view, 4> kEnds = {"\n", "\r\n", "\r", "\n\r"};
  const std::string_view usual_end = kEnds[below(random, kEnds.size())];
  std::string text;
  for (std::size_t n = below(random, 40); n > 0; --n) {
    const double kind = random.uniform();
    text += kind < 0.8    ? random_line(random, kind < 0.7 ? 6 : 18)
            : kind < 0.9  ? std::string()
            : kind < 0.95 ? "T1"
                          : "X1;2";
    text += random.uniform() < 0.9 ? usual_end : kEnds[below(random, kEnds.size())];
  }
  return random.uniform() < 0.5 ? text : text + random_line(random, 6);
}

TEST(PlainCoordinate, ManyLinesAtOnceAreTheSameLines) {
  Random random(kSeed);
  for (const NumberFormat& format : all_formats()) {
    for (int i = 0; i < 100; ++i) {
      const std::string random_lines = random_text(random);
      const std::vector<char> exact(random_lines.begin(), random_lines.end());
      const std::string_view text(exact.data(), exact.size());
      const std::size_t stop = below(random, text.size() + 10);
      const auto each = read_each(text, format);
      const auto many = read_many(text, format, stop, 1 + static_cast<int>(below(random, 20)));
      ASSERT_EQ(many.size(), each.size()) << text;
      for (std::size_t k = 0; k < each.size(); ++k) {
        ASSERT_EQ(many[k].line, each[k].line) << text;
        ASSERT_EQ(many[k].block.has_value(), each[k].block.has_value()) << k << " of\n" << text;
        if (!each[k].block) continue;
        ASSERT_TRUE(is_same(many[k].block->xy_mm[0], each[k].block->xy_mm[0])) << text;
        ASSERT_TRUE(is_same(many[k].block->xy_mm[1], each[k].block->xy_mm[1])) << text;
        ASSERT_EQ(many[k].block->has_point, each[k].block->has_point) << text;
        ASSERT_EQ(many[k].block->n_points, each[k].block->n_points) << text;
      }
    }
  }
}

/// Blocks that a reader leaves seen which passes over blocks, and the number of the others.
struct SkippingRead {
  std::vector<NumberedBlock> seen;
  std::int64_t n_skipped = 0;
  LinePlace end;
};

SkippingRead read_skipping(std::string_view text, std::size_t stop, std::int64_t most) {
  SkippingRead out;
  LineCursor cursor(text);
  PlainReader({.unit = LengthUnit::Millimeter, .zeros = Zeros::TrailingKept})
      .read_lines(
          cursor,
          stop,
          [&](int line, const PlainCoordinate& block) {
            out.seen.push_back({line, block});
            return true;
          },
          [&](std::int64_t n) {
            n = std::min(n, most - out.n_skipped);
            out.n_skipped += n;
            return n;
          });
  out.end = cursor.place();
  return out;
}

std::string random_digits(Random& random, std::size_t n) {
  std::string digits;
  for (; n > 0; --n) digits += static_cast<char>('0' + below(random, 10));
  return digits;
}

TEST(PlainCoordinate, LinesThatArePassedOverAreTheSameLines) {
  Random random(kSeed);
  constexpr std::int64_t kAll = 1'000'000;
  std::int64_t n_skipped = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string text;
    for (std::size_t n = 1 + below(random, 6); n > 0; --n) {
      const std::size_t n_x = 1 + below(random, 6);
      const std::size_t n_y = 1 + below(random, 6);
      for (std::size_t k = 1 + below(random, 8); k > 0; --k) {
        text += 'X' + random_digits(random, n_x) + 'Y' + random_digits(random, n_y) + '\n';
      }
      if (random.uniform() < 0.1) text += '\r';
      if (random.uniform() < 0.1) text += random_line(random, 6) + '\n';
    }
    const std::vector<char> exact(text.begin(), text.end());
    const std::size_t stop = below(random, text.size() + 10);
    const std::string_view lines(exact.data(), exact.size());
    const SkippingRead all = read_skipping(lines, stop, 0);
    const auto most = random.uniform() < 0.5 ? kAll : static_cast<std::int64_t>(below(random, 10));
    const SkippingRead some = read_skipping(lines, stop, most);
    n_skipped += some.n_skipped;
    ASSERT_EQ(some.end.offset, all.end.offset) << text;
    ASSERT_EQ(some.end.number, all.end.number) << text;
    ASSERT_EQ(static_cast<std::int64_t>(some.seen.size()) + some.n_skipped,
              static_cast<std::int64_t>(all.seen.size()))
        << text;
    if (all.seen.empty()) continue;
    ASSERT_EQ(some.seen.back().line, all.seen.back().line) << text;
    for (const NumberedBlock& seen : some.seen) {
      const auto& same = all.seen[static_cast<std::size_t>(seen.line - 1)];
      ASSERT_EQ(seen.line, same.line);
      for (std::size_t axis = 0; axis < 2; ++axis) {
        ASSERT_TRUE(is_same(seen.block->xy_mm[axis], same.block->xy_mm[axis])) << text;
      }
    }
  }
  EXPECT_GT(n_skipped, 10'000);
}

TEST(PlainCoordinate, LinesThatArePassedOverAreCheckedAllTheSame) {
  std::string text;
  for (int i = 0; i < 50; ++i) text += i == 30 ? "X00A000Y000001\n" : "X000000Y000001\n";
  const SkippingRead read = read_skipping(text, text.size(), 1000);
  EXPECT_EQ(read.end.number, 31);
  EXPECT_EQ(read.n_skipped, 28);  // but for the first, which shows the layout, and the last
  EXPECT_EQ(read.seen.back().line, 30);
}

TEST(PlainCoordinate, AnAxisLeftOutStaysWhereItWas) {
  const Eigen::Vector2d at_mm(3, 4);
  EXPECT_EQ(read("Y14", {.unit = LengthUnit::Millimeter})->from(at_mm).x(), 3);
  EXPECT_EQ(read("X7.", NumberFormat())->from(at_mm), Eigen::Vector2d(7 * kMmPerInch, 4));
}

TEST(PlainCoordinate, ManyLinesAtOnceEndBeforeTheStop) {
  std::string text;
  for (int i = 0; i < 100; ++i) text += "X1.Y2.\n";
  LineCursor cursor(text);
  int n_lines = 0;
  PlainReader({}).read_lines(cursor, 3 * 7 + 1, [&n_lines](int, const PlainCoordinate&) {
    ++n_lines;
    return true;
  });
  EXPECT_EQ(n_lines, 4);  // the fourth begins before it
  EXPECT_EQ(cursor.offset(), 4U * 7);
  EXPECT_EQ(cursor.line_number(), 5);
}

TEST(PlainCoordinate, LeavesTheUnusualAlone) {
  for (const char* line : {"",
                           " X1",
                           "X1 ",
                           "X1 Y1",
                           "X1X2",
                           "X1Y1X1",
                           "Y2Y",
                           "X-",
                           "X+Y1",
                           "X.",
                           "X1.2.3",
                           "X--1",
                           "X1-",
                           "X1e3",
                           "G85X1",
                           "X1G85X2",
                           "X1,2",
                           "/X1",
                           "T1",
                           "x1",
                           "X123456789",
                           "X1.123456789",
                           "X12345678.12345678",
                           "X0075000",
                           "Z1",
                           "W1"}) {
    EXPECT_FALSE(read(line, NumberFormat())) << line;
  }
}

TEST(PlainCoordinate, HasPointUnlessTheFormatDecides) {
  for (const char* line : {"X1.5Y.5", "X1.Y", "X", "XY", "Y-2.0"}) {
    EXPECT_TRUE(read(line, NumberFormat())->has_point) << line;
  }
  for (const char* line : {"X1", "X1.5Y1", "X1Y1.5", "XY0", "Y-01"}) {
    EXPECT_FALSE(read(line, NumberFormat())->has_point) << line;
  }
}

TEST(PlainCoordinate, AnAxisLeftOutIsAbsentAndOneWithoutDigitsIsZero) {
  const auto only_y = read("Y014", NumberFormat());
  ASSERT_TRUE(only_y);
  EXPECT_EQ(only_y->xy_mm[0], std::nullopt);
  EXPECT_DOUBLE_EQ(only_y->xy_mm[1].value(), 1.4 * kMmPerInch);
  EXPECT_EQ(read("XY1", NumberFormat())->xy_mm[0], 0.0);
}

}  // namespace
}  // namespace panelcal::excellon
