// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/statistics/random.h"
#include "program/writers/fixed_point.h"
#include "program/writers/text_writer.h"
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

constexpr std::uint64_t kSeed = 20261121;
constexpr int kMostDecimals = 9;
constexpr double kExactWhole = 9e15;

template <int kN>
std::string fixed_as(double value, std::string_view after_whole = {}) {
  std::vector<char> room(kFixedChars + after_whole.size());
  const char* const end = write_fixed_as<kN>(room.data(), value, after_whole);
  return {room.data(), static_cast<std::size_t>(end - room.data())};
}

/// By the form whose number of decimals is known when it is compiled, as writers of holes do.
std::string fixed_as(double value, int n_decimals) {
  switch (n_decimals) {
    case 2:
      return fixed_as<2>(value);
    case 3:
      return fixed_as<3>(value);
    case 4:
      return fixed_as<4>(value);
    case 5:
      return fixed_as<5>(value);
    case 6:
      return fixed_as<6>(value);
    case 7:
      return fixed_as<7>(value);
    case 8:
      return fixed_as<8>(value);
    default:
      return fixed_as<9>(value);
  }
}

std::string fixed(double value, int n_decimals) {
  std::string text = "X";  // what is there already stays
  append_fixed(text, value, n_decimals);
  EXPECT_EQ(text[0], 'X');
  if (n_decimals >= 2) {
    EXPECT_EQ(text.substr(1), fixed_as(value, n_decimals));
  }
  return text.substr(1);
}

/// Rounded by the standard library, cut into digits by it, zeros removed one by one.
std::string slowly(double value, int n_decimals) {
  const double scaled = value * std::stod("1e" + std::to_string(n_decimals));
  if (!(std::abs(scaled) < kExactWhole)) return fmt::format("{}", value);
  const long long steps = std::llround(scaled);
  std::string text = std::to_string(std::llabs(steps));
  const auto n_behind = static_cast<std::size_t>(n_decimals);
  if (text.size() <= n_behind) text.insert(0, n_behind + 1 - text.size(), '0');
  text.insert(text.size() - n_behind, ".");
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return (steps < 0 ? "-" : "") + text;
}

TEST(AppendFixed, RandomValuesAgreeWithTheSlowWay) {
  Random random(kSeed);
  for (int n_decimals = 0; n_decimals <= kMostDecimals; ++n_decimals) {
    for (int i = 0; i < 50'000; ++i) {
      // Every magnitude from far below a step to beyond what is printed in fixed point.
      const double value = random.normal() * std::pow(10.0, random.uniform(-11, 17));
      ASSERT_EQ(fixed(value, n_decimals), slowly(value, n_decimals))
          << fmt::format("{} with {} decimals, seed {}", value, n_decimals, kSeed);
    }
  }
}

TEST(AppendFixed, CoordinatesAgreeWithTheSlowWay) {
  Random random(kSeed);
  for (int i = 0; i < 200'000; ++i) {
    const double corrected_mm = random.uniform(-1000, 1000);
    const double programmed_mm = std::round(corrected_mm * 1e3) / 1e3;
    ASSERT_EQ(fixed(corrected_mm, kMmDecimals), slowly(corrected_mm, kMmDecimals));
    ASSERT_EQ(fixed(programmed_mm, kMmDecimals), slowly(programmed_mm, kMmDecimals));
  }
}

TEST(AppendFixed, NeighborsOfTiesAgreeWithTheSlowWay) {
  for (int n_decimals = 0; n_decimals <= kMostDecimals; ++n_decimals) {
    const double step = std::pow(10.0, -n_decimals);
    for (int half_steps = 0; half_steps < 4100; ++half_steps) {
      const double tie = half_steps * step / 2;
      for (const double value : {tie, std::nextafter(tie, 1e9), std::nextafter(tie, -1e9)}) {
        ASSERT_EQ(fixed(value, n_decimals), slowly(value, n_decimals)) << value;
        ASSERT_EQ(fixed(-value, n_decimals), slowly(-value, n_decimals)) << -value;
      }
    }
  }
}

TEST(AppendFixed, EveryCountOfDigitsAgreesWithTheSlowWay) {
  for (int n_decimals = 0; n_decimals <= kMostDecimals; ++n_decimals) {
    for (double power = std::pow(10.0, -n_decimals); power < 1e17; power *= 10) {
      for (const double value :
           {power, 5 * power, power - std::pow(10.0, -n_decimals), std::nextafter(power, 0)}) {
        ASSERT_EQ(fixed(value, n_decimals), slowly(value, n_decimals)) << value;
      }
    }
  }
}

TEST(AppendFixed, ReadsBackWithinHalfAStep) {
  constexpr double kHalfStep = 0.5e-6 * (1 + 1e-9);
  Random random(kSeed);
  for (int i = 0; i < 50'000; ++i) {
    const double value = random.uniform(-1000, 1000);
    const std::string text = fixed(value, 6);
    double read = 0;
    std::from_chars(text.data(), text.data() + text.size(), read);
    ASSERT_LE(std::abs(read - value), kHalfStep) << text;
  }
}

TEST(AppendFixed, LeavesOffTrailingZerosAndALonePoint) {
  EXPECT_EQ(fixed(12.5, 6), "12.5");
  EXPECT_EQ(fixed(-0.000125, 6), "-0.000125");
  EXPECT_EQ(fixed(3, 6), "3");
  EXPECT_EQ(fixed(1000, 6), "1000");
  EXPECT_EQ(fixed(100.001, 6), "100.001");
  EXPECT_EQ(fixed(0.1, 1), "0.1");
  EXPECT_EQ(fixed(7.25, 0), "7");
  EXPECT_EQ(fixed(0.123456789, 9), "0.123456789");
}

TEST(AppendFixed, RoundsHalfAwayFromZero) {
  EXPECT_EQ(fixed(0.5, 0), "1");
  EXPECT_EQ(fixed(-0.5, 0), "-1");
  EXPECT_EQ(fixed(2.5, 0), "3");
  EXPECT_EQ(fixed(std::nextafter(0.5, 0), 0), "0");
  EXPECT_EQ(fixed(0.125, 2), "0.13");
  EXPECT_EQ(fixed(999.9999996, 6), "1000");
}

TEST(AppendFixed, ZeroHasNoSign) {
  EXPECT_EQ(fixed(0.0, 6), "0");
  EXPECT_EQ(fixed(-0.0, 6), "0");
  EXPECT_EQ(fixed(-4.9e-7, 6), "0");
}

TEST(AppendFixed, BeyondExactWholeNumbersPrintsTheShortestForm) {
  EXPECT_EQ(fixed(8'999'999'999.999998, 6), "8999999999.999998");
  EXPECT_EQ(fixed(9e9, 6), "9000000000");
  EXPECT_EQ(fixed(-1e300, 6), "-1e+300");
  EXPECT_EQ(fixed(std::numeric_limits<double>::quiet_NaN(), 6), "nan");
  EXPECT_EQ(fixed(std::numeric_limits<double>::infinity(), 6), "inf");
  EXPECT_EQ(fixed(-std::numeric_limits<double>::infinity(), 6), "-inf");
}

TEST(WriteFixed, TheLongestTextsFitIntoTheirRoom) {
  for (int n_decimals = 0; n_decimals <= kMostDecimals; ++n_decimals) {
    const double largest = std::nextafter(kExactWhole / std::pow(10.0, n_decimals), 0);
    for (const double value : {-largest, -std::numeric_limits<double>::max(), -1e-9}) {
      std::vector<char> room(kFixedChars);  // a sanitizer sees what is written behind it
      const char* const end = write_fixed(room.data(), value, n_decimals);
      EXPECT_EQ(std::string(room.data(), static_cast<std::size_t>(end - room.data())),
                slowly(value, n_decimals));
    }
  }
}

TEST(WriteFixed, ANumberWithoutAPointIsFollowedByWhatStandsForIt) {
  EXPECT_EQ(fixed_as<6>(12, ".0"), "12.0");
  EXPECT_EQ(fixed_as<6>(12.5, ".0"), "12.5");
  EXPECT_EQ(fixed_as<8>(-0.0, ".0"), "0.0");
  EXPECT_EQ(fixed_as<6>(1234, ".0"), "1234.0");
  EXPECT_EQ(fixed_as<6>(1234.25, ".0"), "1234.25");
  EXPECT_EQ(fixed_as<6>(-1e300, ".0"), "-1e+300.0");
}

TEST(WriteCount, IsTheNumber) {
  const auto count = [](std::uint32_t n) {
    std::vector<char> room(kCountChars);
    const char* const end = write_count(room.data(), n);
    return std::string(room.data(), static_cast<std::size_t>(end - room.data()));
  };
  Random random(kSeed);
  std::uint32_t power = 1;
  for (int n_digits = 1; n_digits <= 10; ++n_digits) {
    for (const std::uint32_t n : {power - 1, power, power + 1}) {
      ASSERT_EQ(count(n), std::to_string(n));
    }
    for (int i = 0; i < 10'000; ++i) {
      const double most = std::min(10.0 * power, 4294967295.0);
      const auto n = static_cast<std::uint32_t>(random.uniform(power, most));
      ASSERT_EQ(count(n), std::to_string(n));
    }
    power *= 10;
  }
  EXPECT_EQ(count(std::numeric_limits<std::uint32_t>::max()), "4294967295");
}

}  // namespace
}  // namespace panelcal
