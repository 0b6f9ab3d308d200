// SPDX-License-Identifier: Apache-2.0
#include "surface/files/text_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::size_t kMaxLineBytes = std::size_t{1} << 16;
constexpr double kLargest = 1e6;
constexpr std::string_view kFieldBlanks = " \t";

TextField part_of(const TextField& line, std::size_t begin, std::size_t end) {
  return {line.text.substr(begin, end - begin), line.line, line.column + static_cast<int>(begin)};
}

}  // namespace

TextLines::TextLines(std::string_view text, std::string file)
    : rest_(text), file_(std::move(file)) {
  constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
  if (rest_.starts_with(kUtf8Mark)) rest_.remove_prefix(kUtf8Mark.size());
}

Expected<std::optional<TextField>> TextLines::next() {
  if (rest_.empty()) return std::nullopt;
  ++number_;
  const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
  const TextField line{rest_.substr(0, end), number_, 1};
  const std::size_t ends = rest_.substr(end).starts_with("\r\n") ? 2 : 1;
  rest_.remove_prefix(std::min(end + ends, rest_.size()));
  if (line.text.size() <= kMaxLineBytes) return line;
  return failure({Code::MeasurementFile,
                  {file_, number_, 1},
                  fmt::format("a line of {} bytes", line.text.size()),
                  fmt::format("at most {}", kMaxLineBytes)});
}

Expected<std::optional<TextField>> TextLines::next_filled() {
  while (true) {
    PANELCAL_TRY(const std::optional<TextField> line, next());
    if (!line || line->text.find_first_not_of(kFieldBlanks) != std::string_view::npos) return line;
  }
}

Expected<TextField> TextLines::require(std::string_view expected) {
  PANELCAL_TRY(const std::optional<TextField> line, next());
  if (line) return *line;
  return failure({Code::MeasurementFile,
                  {file_, number_ + 1, 1},
                  "the file ends here",
                  std::string(expected)});
}

std::vector<TextField> words_of(const TextField& line) {
  std::vector<TextField> out;
  std::size_t begin = line.text.find_first_not_of(kFieldBlanks);
  while (begin != std::string_view::npos) {
    const std::size_t end =
        std::min(line.text.find_first_of(kFieldBlanks, begin), line.text.size());
    out.push_back(part_of(line, begin, end));
    begin = line.text.find_first_not_of(kFieldBlanks, end);
  }
  return out;
}

std::vector<TextField> cells_of(const TextField& line) {
  std::vector<TextField> out;
  std::size_t from = 0;
  while (true) {
    const std::size_t comma = std::min(line.text.find(',', from), line.text.size());
    const std::size_t begin = std::min(line.text.find_first_not_of(kFieldBlanks, from), comma);
    std::size_t end = comma;
    while (end > begin && kFieldBlanks.find(line.text[end - 1]) != std::string_view::npos) --end;
    out.push_back(part_of(line, begin, end));
    if (comma == line.text.size()) return out;
    from = comma + 1;
  }
}

Diagnostic unexpected_field(const std::string& file, const TextField& at, std::string expected) {
  return {Code::MeasurementFile,
          {file, at.line, at.column},
          at.text.empty() ? "there is nothing" : quoted(at.text),
          std::move(expected)};
}

Expected<double> number_of(const std::string& file, const TextField& field) {
  double value = 0;
  const char* const end = field.text.data() + field.text.size();
  const auto [stop, error] = std::from_chars(field.text.data(), end, value);
  if (error == std::errc() && stop == end && std::abs(value) <= kLargest) return value;
  return failure(unexpected_field(file, field, fmt::format("a number up to {:g}", kLargest)));
}

Expected<int> count_of(const std::string& file, const TextField& field, int low, int high) {
  int value = 0;
  const char* const end = field.text.data() + field.text.size();
  const auto [stop, error] = std::from_chars(field.text.data(), end, value);
  if (error == std::errc() && stop == end && value >= low && value <= high) return value;
  return failure(
      unexpected_field(file, field, fmt::format("a whole number from {} to {}", low, high)));
}

}  // namespace panelcal::internal
