// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/recorded_lines.h"

#include <cstddef>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::size_t kMaxLineBytes = std::size_t{1} << 16;
/// Step and repeat nests at most 64 deep (nesting-too-deep), in the program and again in a stored
/// pattern or subprogram.
constexpr std::size_t kMaxPath = 128;

}  // namespace

Expected<void> read_recorded_lines(
    std::string_view text,
    const std::string& file,
    const std::function<Expected<void>(const JsonLine& line, int number)>& take) {
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const Place place{file, number, 1};
    if (line.size() > kMaxLineBytes) {
      return failure({Code::MeasurementFile,
                      place,
                      "the line is too long",
                      fmt::format("at most {} bytes", kMaxLineBytes)});
    }
    PANELCAL_TRY(const JsonLine parsed, JsonLine::parse(line, place));
    PANELCAL_CHECK(take(parsed, number));
  }
  return {};
}

Expected<int> recorded_int(const JsonLine& line, std::string_view key, int high) {
  PANELCAL_TRY(const std::int64_t value, line.integer(key, 0, high, Code::MeasurementFile));
  return static_cast<int>(value);
}

Expected<InstancePath> recorded_path(const JsonLine& line) {
  return line.integers("path", 0, std::numeric_limits<int>::max(), kMaxPath, Code::MeasurementFile);
}

}  // namespace panelcal::internal
