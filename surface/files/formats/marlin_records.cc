// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <utility>

#include "surface/files/formats/marlin_console.h"
#include "surface/files/probe_signs.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::string_view kTopography = "Bed Topography Report";
constexpr std::string_view kTouch = "Bed X:";
constexpr std::array<std::string_view, 2> kNumberedTables = {"Bilinear Leveling Grid:",
                                                             "Measured points:"};
constexpr std::array<std::string_view, 2> kMeshPoints = {"X-Axis Mesh Points at:",
                                                         "Y-Axis Mesh Points at:"};

/// Of a mesh along x or y.
constexpr int kMostMeshNodes = 1000;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// What the program that wrote the console put ahead of each line: the same text, but for digits.
class ConsolePrefix {
 public:
  explicit ConsolePrefix(std::string_view text) : text_(text) {}

  /// The line behind it; empty: another program's line.
  std::optional<TextField> body_of(const TextField& line) const {
    const std::size_t n = std::min(text_.size(), line.text.size());
    for (std::size_t i = 0; i < n; ++i) {
      const bool is_same =
          line.text[i] == text_[i] || (is_digit(line.text[i]) && is_digit(text_[i]));
      if (!is_same) return std::nullopt;
    }
    // Editors cut off the blanks at the end of an empty line.
    const std::string_view rest = text_.substr(n);
    if (rest.find_first_not_of(" \t") != std::string_view::npos) return std::nullopt;
    return trimmed(part_of(line, n));
  }

 private:
  std::string_view text_;
};

/// Words, of which brackets are no part: `[+0.279]` is where the nozzle stands.
std::vector<TextField> mesh_words(const TextField& body) {
  std::vector<TextField> out;
  constexpr std::string_view kBetween = " \t[]";
  std::size_t begin = body.text.find_first_not_of(kBetween);
  while (begin != std::string_view::npos) {
    const std::size_t end = std::min(body.text.find_first_of(kBetween, begin), body.text.size());
    out.push_back(part_of(body, begin, end));
    begin = body.text.find_first_not_of(kBetween, end);
  }
  return out;
}

std::optional<int> whole(std::string_view word) {
  int value = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool is_whole = error == std::errc() && stop == word.data() + word.size();
  return is_whole ? std::optional(value) : std::nullopt;
}

/// True for 0 1 2 ...
bool is_column_line(const std::vector<TextField>& words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (whole(words[i].text) != static_cast<int>(i)) return false;
  }
  return words.size() >= 2;
}

/// Two pairs in one line, such as `(  1,229)    (229,229)`.
std::optional<std::array<Eigen::Vector2d, 2>> corner_pairs(const TextField& body) {
  std::string text(body.text);
  const bool is_pairs = std::ranges::count(text, '(') == 2 && std::ranges::count(text, ')') == 2 &&
                        text.starts_with('(') && text.ends_with(')');
  if (!is_pairs) return std::nullopt;
  std::ranges::replace_if(
      text, [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
  std::array<double, 4> numbers{};
  const auto words = words_of({text});
  if (words.size() != numbers.size()) return std::nullopt;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto number = whole(words[i].text);
    if (!number) return std::nullopt;
    numbers[i] = *number;
  }
  return std::array{Eigen::Vector2d(numbers[0], numbers[1]),
                    Eigen::Vector2d(numbers[2], numbers[3])};
}

class MarlinReader {
 public:
  MarlinReader(std::string_view text, const std::string& file) : lines_(text, file), file_(file) {}

  Expected<MarlinRecords> read() {
    while (true) {
      PANELCAL_TRY(const std::optional<TextField> line, lines_.next());
      if (!line) return std::move(out_);
      PANELCAL_CHECK(read_line(*line));
    }
  }

 private:
  Expected<void> read_line(const TextField& line) {
    const auto at = [&](std::string_view word) { return line.text.find(word); };
    for (std::size_t axis = 0; axis < kMeshPoints.size(); ++axis) {
      const std::size_t begin = at(kMeshPoints[axis]);
      if (begin != std::string_view::npos) {
        return read_mesh_points(part_of(line, begin + kMeshPoints[axis].size()), axis);
      }
    }
    if (at(kTopography) != std::string_view::npos) return read_topography(line, at(kTopography));
    for (const std::string_view title : kNumberedTables) {
      if (at(title) != std::string_view::npos) return read_numbered(line, at(title));
    }
    if (at(kTouch) != std::string_view::npos) return read_touch(part_of(line, at(kTouch)));
    return {};
  }

  /// A title that something else than the console's prefix stands ahead of is another's.
  Expected<ConsolePrefix> prefix_of(const TextField& line, std::size_t begin) const {
    const std::string_view ahead = trimmed(part_of(line, 0, begin)).text;
    const char last = ahead.empty() ? ':' : ahead.back();
    const bool is_word = (last >= 'a' && last <= 'z') || (last >= 'A' && last <= 'Z');
    if (!is_word) return ConsolePrefix(line.text.substr(0, begin));
    return failure(unexpected_field(file_, trimmed(line), "a title that Marlin itself prints"));
  }

  /// The next line of the same console.
  Expected<TextField> next_body(const ConsolePrefix& prefix, std::string_view expected) {
    while (true) {
      PANELCAL_TRY(const TextField line, lines_.require(expected));
      const auto body = prefix.body_of(line);
      if (body) return *body;
    }
  }
  Expected<TextField> next_filled_body(const ConsolePrefix& prefix, std::string_view expected) {
    while (true) {
      PANELCAL_TRY(const TextField body, next_body(prefix, expected));
      if (!body.text.empty()) return body;
    }
  }

  Expected<std::vector<ReadNode>> nodes_of(std::span<const TextField> words, int n_columns) const {
    if (words.size() != static_cast<std::size_t>(n_columns)) {
      const Place at =
          words.empty() ? Place{file_, 0, 0} : Place{file_, words[0].line, words[0].column};
      return failure({Code::MeasurementFile,
                      at,
                      fmt::format("{} heights", words.size()),
                      fmt::format("{}, one for each column", n_columns)});
    }
    std::vector<ReadNode> out;
    for (const TextField& word : words) {
      ReadNode node;
      node.from = {file_, word.line, word.column};
      const bool is_missing =
          word.text == "." || word.text.find_first_not_of('=') == std::string_view::npos;
      if (!is_missing) {
        PANELCAL_TRY(node.height, signed_number_of(file_, word));
      }
      out.push_back(std::move(node));
    }
    return out;
  }

  /// Numbers of the columns, then each row behind its number, from low y; the line behind it tells
  /// that no row is cut off.
  Expected<void> read_numbered(const TextField& line, std::size_t begin) {
    PANELCAL_TRY(const ConsolePrefix prefix, prefix_of(line, begin));
    PANELCAL_TRY(const TextField head, next_filled_body(prefix, "the numbers of the columns"));
    const auto columns = words_of(head);
    if (!is_column_line(columns)) {
      return failure(unexpected_field(file_, head, "the numbers of the columns, 0 1 2 ..."));
    }
    MarlinTable table{part_of(line, begin), static_cast<int>(columns.size()), {}, {}, {}};
    while (true) {
      PANELCAL_TRY(const TextField body,
                   next_body(prefix, "the line behind the table, such as ok or an empty one"));
      const auto words = words_of(body);
      const int row = static_cast<int>(table.rows.size());
      if (words.empty() || whole(words[0].text) != row) break;
      PANELCAL_TRY(table.rows.emplace_back(),
                   nodes_of(std::span(words).subspan(1), table.n_columns));
    }
    out_.tables.push_back(std::move(table));
    return {};
  }

  /// Corners, columns, rows from high y, columns and corners, as unified bed leveling prints them.
  /// Marlin 1.1.8 and older have no numbers of columns and rows, but corners in nodes.
  Expected<void> read_topography(const TextField& line, std::size_t begin) {
    const TextField title = trimmed(part_of(line, begin));
    if (title.text.substr(kTopography.size()) != ":") {
      return failure(
          unexpected_field(file_, title, "the report of G29 T0, which says where it ends"));
    }
    PANELCAL_TRY(const ConsolePrefix prefix, prefix_of(line, begin));
    MarlinTable table{title, 0, {}, {}, {}};
    PANELCAL_TRY(const TextField first, next_filled_body(prefix, "the corners above the table"));
    auto top = corner_pairs(first);
    if (!top) return failure(unexpected_field(file_, first, "two corners, such as (0,9) (9,9)"));
    PANELCAL_TRY(TextField body, next_filled_body(prefix, "the columns of the table"));
    const auto older = corner_pairs(body);
    std::optional<int> n_rows;
    if (older) {
      const Eigen::Vector2d& last = (*top)[1];
      const bool is_top = (*top)[0].x() == 0 && (*top)[0].y() == last.y() && last.minCoeff() >= 1 &&
                          last.maxCoeff() < kMostMeshNodes;
      if (!is_top) return failure(unexpected_field(file_, first, "corners such as (0,9) (9,9)"));
      table.n_columns = static_cast<int>((*top)[1].x()) + 1;
      n_rows = static_cast<int>((*top)[1].y()) + 1;
      top = older;
      PANELCAL_TRY(body, next_filled_body(prefix, "the rows of the table"));
    } else {
      if (!is_column_line(words_of(body))) {
        return failure(unexpected_field(file_, body, "the numbers of the columns, 0 1 2 ..."));
      }
      table.n_columns = static_cast<int>(words_of(body).size());
      PANELCAL_TRY(body, next_filled_body(prefix, "the rows of the table"));
    }
    PANELCAL_CHECK(read_topography_rows(prefix, table, body, n_rows));
    PANELCAL_CHECK(read_bottom(prefix, table, body, *top));
    std::ranges::reverse(table.rows);
    out_.tables.push_back(std::move(table));
    return {};
  }

  /// Leaves the line behind the rows in `body`.
  Expected<void> read_topography_rows(const ConsolePrefix& prefix,
                                      MarlinTable& table,
                                      TextField& body,
                                      std::optional<int> n_rows) {
    const bool is_numbered = !n_rows;
    NextRow next{n_rows.has_value(), n_rows.value_or(0) - 1};
    while (!next.is_known || next.row >= 0) {
      std::optional<TextField> values = body;
      if (is_numbered) {
        PANELCAL_TRY(values, numbered_row(body, next));
      }
      if (values) {
        PANELCAL_TRY(table.rows.emplace_back(), nodes_of(mesh_words(*values), table.n_columns));
        --next.row;
      }
      PANELCAL_TRY(body, next_filled_body(prefix, "the lines below the table"));
    }
    return {};
  }

  struct NextRow {
    bool is_known = false;  ///< false ahead of the highest, which says its number itself
    int row = 0;
  };

  /// The heights behind ` 3 |`; empty: a line between two rows.
  Expected<std::optional<TextField>> numbered_row(const TextField& body, NextRow& next) const {
    const std::size_t bar = std::min(body.text.find('|'), body.text.size());
    const TextField label = trimmed(part_of(body, 0, bar));
    const TextField values = part_of(body, std::min(bar + 1, body.text.size()));
    if (label.text.empty() && trimmed(values).text.empty()) return std::nullopt;
    const int number = whole(label.text).value_or(-1);
    if (next.is_known ? number == next.row : number >= 1) {
      next = {true, number};
      return values;
    }
    return failure(unexpected_field(file_,
                                    label,
                                    next.is_known ? fmt::format("row {}", next.row)
                                                  : std::string("the number of the highest row")));
  }

  Expected<void> read_bottom(const ConsolePrefix& prefix,
                             MarlinTable& table,
                             TextField& body,
                             const std::array<Eigen::Vector2d, 2>& top) {
    if (is_column_line(words_of(body))) {
      PANELCAL_TRY(body, next_filled_body(prefix, "the corners below the table"));
    }
    const auto bottom = corner_pairs(body);
    const bool agrees = bottom && (*bottom)[0].x() == top[0].x() &&
                        (*bottom)[1].x() == top[1].x() && top[0].y() == top[1].y() &&
                        (*bottom)[0].y() == (*bottom)[1].y();
    if (!agrees) {
      return failure(unexpected_field(
          file_, body, "the corners below the table, at the same x as those above it"));
    }
    table.low_mm = (*bottom)[0];
    table.high_mm = top[1];
    return {};
  }

  Expected<void> read_touch(const TextField& record) {
    constexpr std::array<std::string_view, 7> kWords = {"Bed", "X:", "", "Y:", "", "Z:", ""};
    const auto words = words_of(record);
    std::array<double, 3> numbers{};
    for (std::size_t i = 0; i < kWords.size(); ++i) {
      if (i >= words.size() || (!kWords[i].empty() && words[i].text != kWords[i])) {
        return failure(unexpected_field(file_, record, "\"Bed X: 1.000 Y: 2.000 Z: 0.010\""));
      }
      if (kWords[i].empty()) {
        PANELCAL_TRY(numbers[i / 2 - 1], signed_number_of(file_, words[i]));
      }
    }
    if (out_.touches.size() == kMaxFileProbes) {
      return failure({Code::MeasurementFile,
                      {file_, record.line, 1},
                      "the console is too long",
                      fmt::format("at most {} probes", kMaxFileProbes)});
    }
    out_.touches.push_back({{numbers[0], numbers[1]}, numbers[2], record});
    return {};
  }

  Expected<void> read_mesh_points(const TextField& list, std::size_t axis) {
    std::vector<double> points_mm;
    for (const TextField& word : words_of(list)) {
      PANELCAL_TRY(points_mm.emplace_back(), number_of(file_, word));
    }
    std::vector<double>& known_mm = axis == 0 ? out_.x_mm : out_.y_mm;
    if (!known_mm.empty() && known_mm != points_mm) {
      return failure(unexpected_field(file_, trimmed(list), "the points that the file had before"));
    }
    known_mm = std::move(points_mm);
    return {};
  }

  TextLines lines_;
  const std::string& file_;
  MarlinRecords out_;
};

}  // namespace

bool is_marlin_console(std::string_view text) {
  const auto has = [&](std::string_view word) { return text.find(word) != std::string_view::npos; };
  return has(kTopography) || has(kTouch) || std::ranges::any_of(kNumberedTables, has);
}

Expected<MarlinRecords> read_marlin_records(std::string_view text, const std::string& file) {
  return MarlinReader(text, file).read();
}

}  // namespace panelcal::internal
