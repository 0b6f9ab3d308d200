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

}  // namespace

TextField part_of(const TextField& line, std::size_t begin, std::size_t end) {
  return {line.text.substr(begin, end - begin), line.line, line.column + static_cast<int>(begin)};
}

TextField trimmed(const TextField& field) {
  const std::size_t begin = std::min(field.text.find_first_not_of(kFieldBlanks), field.text.size());
  const std::size_t last = field.text.find_last_not_of(kFieldBlanks);
  return part_of(field, begin, last == std::string_view::npos ? begin : last + 1);
}

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

std::vector<TextField> cells_of(const TextField& line, char separator) {
  std::vector<TextField> out;
  std::size_t from = 0;
  while (true) {
    const std::size_t end = std::min(line.text.find(separator, from), line.text.size());
    out.push_back(trimmed(part_of(line, from, end)));
    if (end == line.text.size()) return out;
    from = end + 1;
  }
}

Expected<void> check_line_end(std::string_view text, const std::string& file) {
  if (text.empty() || text.ends_with('\n') || text.ends_with('\r')) return {};
  const std::size_t line_break = text.find_last_of("\r\n");
  const std::size_t begin = line_break == std::string_view::npos ? 0 : line_break + 1;
  const auto n_lines = std::ranges::count(text, '\n') + 1;
  return failure({Code::MeasurementFile,
                  {file, static_cast<int>(n_lines), 1},
                  quoted(text.substr(begin)),
                  "a line end behind it: the file is cut off"});
}

std::vector<TextField> first_lines(std::string_view text, std::size_t n_most) {
  TextLines lines(text, "");
  std::vector<TextField> out;
  while (out.size() < n_most) {
    const auto line = lines.next_filled();
    if (!line || !*line) break;
    out.push_back(**line);
  }
  return out;
}

bool is_number(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  double value = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && stop == word.data() + word.size() && std::isfinite(value);
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

Expected<double> signed_number_of(const std::string& file, const TextField& field) {
  const bool has_plus = field.text.starts_with('+') && !field.text.starts_with("+-");
  return number_of(file, has_plus ? part_of(field, 1) : field);
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
