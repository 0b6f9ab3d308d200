// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/recorded_ranges.h"

#include <algorithm>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

bool holds(const RecordedRange& range, double number) {
  return number >= range.low && number <= range.high;
}

}  // namespace

Expected<double> recorded_number(const JsonLine& line,
                                 std::string_view key,
                                 const RecordedRange& range,
                                 Code code) {
  PANELCAL_TRY(const double number, line.number(key, code));
  if (holds(range, number)) return number;
  return failure(
      line.problem(key, code, fmt::format("a number from {:g} to {:g}", range.low, range.high)));
}

Expected<std::vector<double>> recorded_numbers(const JsonLine& line,
                                               std::string_view key,
                                               std::size_t n,
                                               const RecordedRange& range,
                                               Code code) {
  PANELCAL_TRY(std::vector<double> numbers, line.numbers(key, n, code));
  if (std::ranges::all_of(numbers, [&](double number) { return holds(range, number); })) {
    return numbers;
  }
  return failure(line.problem(
      key, code, fmt::format("{} numbers from {:g} to {:g}", n, range.low, range.high)));
}

Expected<Eigen::Vector2d> recorded_place(const JsonLine& line, std::string_view key, Code code) {
  PANELCAL_TRY(const std::vector<double> xy_mm,
               recorded_numbers(line, key, 2, kRecordedPlace, code));
  return Eigen::Vector2d(xy_mm[0], xy_mm[1]);
}

}  // namespace panelcal::internal
