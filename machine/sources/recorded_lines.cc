// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/recorded_lines.h"

#include <cstddef>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::size_t kMaxLineBytes = std::size_t{1} << 16;

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

}  // namespace panelcal::internal
