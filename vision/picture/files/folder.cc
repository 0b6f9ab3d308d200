// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/files/folder.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <system_error>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::string_view kListName = "images.csv";
constexpr std::size_t kMaxListBytes = std::size_t{1} << 28;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

enum Column { kFile, kX, kY, kZ, kTool, kLamp, kZoom, kSeq, kTime, kColumnCount };
constexpr std::array<std::string_view, kColumnCount> kColumnNames = {
    "file", "x", "y", "z", "tool", "lamp", "zoom", "seq", "time"};
constexpr std::string_view kColumnsExpected =
    "file,x,y and optional z,tool,lamp,zoom,seq,time in any order";

/// A piece of a line and where it starts, counted from 1.
struct Field {
  std::string_view text;
  int column = 1;
};

std::string_view trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<Field> split_fields(std::string_view line) {
  std::vector<Field> fields;
  std::size_t start = 0;
  while (true) {
    const std::size_t end = std::min(line.find(',', start), line.size());
    const std::string_view text = trimmed(line.substr(start, end - start));
    const std::size_t at =
        text.empty() ? start : static_cast<std::size_t>(text.data() - line.data());
    fields.push_back({text, static_cast<int>(at) + 1});
    if (end == line.size()) return fields;
    start = end + 1;
  }
}

/// Reads the lines of one images.csv; stops at the first error.
class Parser {
 public:
  Parser(std::string_view text, std::string_view name) : rest_(text), name_(name) {
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
  }

  Expected<std::vector<PictureRow>> parse() {
    if (trimmed(rest_).empty())
      return error(1, 1, "the file is empty", std::string(kColumnsExpected));
    if (const std::size_t at = rest_.find('\0'); at != std::string_view::npos) {
      return error(
          1, 1, fmt::format("a zero byte at offset {}: this is no text", at), "a CSV file");
    }
    PANELCAL_CHECK(read_header());
    std::vector<PictureRow> rows;
    std::string_view line;
    while (next_line(line)) {
      if (trimmed(line).empty()) continue;
      PANELCAL_TRY(PictureRow row, read_row(line));
      rows.push_back(std::move(row));
    }
    if (rows.empty()) return error(line_, 1, "no picture is listed", "at least one row");
    return rows;
  }

 private:
  bool next_line(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    ++line_;
    return true;
  }

  tl::unexpected<Diagnostic> error(int line,
                                   int column,
                                   std::string what,
                                   std::string expected) const {
    return failure({Code::ImagesCsv, {name_, line, column}, std::move(what), std::move(expected)});
  }
  tl::unexpected<Diagnostic> error(const Field& field,
                                   std::string what,
                                   std::string expected) const {
    return error(line_, field.column, std::move(what), std::move(expected));
  }

  Expected<void> read_header() {
    std::string_view line;
    next_line(line);
    for (const Field& field : split_fields(line)) {
      const auto found = std::find(kColumnNames.begin(), kColumnNames.end(), field.text);
      if (found == kColumnNames.end()) return unknown_column(field);
      const auto column = static_cast<Column>(found - kColumnNames.begin());
      if (std::find(columns_.begin(), columns_.end(), column) != columns_.end()) {
        return error(
            field, fmt::format("column \"{}\" comes twice", field.text), "each column once");
      }
      columns_.push_back(column);
    }
    for (const Column needed : {kFile, kX, kY}) {
      if (std::find(columns_.begin(), columns_.end(), needed) != columns_.end()) continue;
      return error(line_,
                   1,
                   fmt::format("missing column \"{}\"", kColumnNames[needed]),
                   std::string(kColumnsExpected));
    }
    return {};
  }

  Expected<void> unknown_column(const Field& field) const {
    const std::string_view near = nearest_word(field.text, kColumnNames);
    return error(field,
                 fmt::format("unknown column {}", panelcal::quoted(field.text)),
                 near.empty() ? std::string(kColumnsExpected)
                              : fmt::format("did you mean {}?", panelcal::quoted(near)));
  }

  Expected<PictureRow> read_row(std::string_view line) {
    const std::vector<Field> fields = split_fields(line);
    if (fields.size() != columns_.size()) {
      return error(line_,
                   1,
                   fmt::format("{} fields", fields.size()),
                   fmt::format("{}, as in the header", columns_.size()));
    }
    PictureRow row;
    row.line = line_;
    x_mm_ = y_mm_ = 0;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      PANELCAL_CHECK(read_field(fields[i], columns_[i], row));
    }
    row.axis = position_mm<frame::Machine>(x_mm_, y_mm_);
    return row;
  }

  Expected<void> read_field(const Field& field, Column column, PictureRow& row) {
    if (field.text.empty()) {
      if (column > kY) return {};
      return error(field, fmt::format("\"{}\" is empty", kColumnNames[column]), "a value");
    }
    if (field.text.find('"') != std::string_view::npos) {
      return error(field, "a quotation mark", "plain fields; a file name cannot hold a comma");
    }
    switch (column) {
      case kFile:
        return read_file_name(field, row);
      case kX:
        return read_number(field, column, x_mm_);
      case kY:
        return read_number(field, column, y_mm_);
      case kZ: {
        double z_mm = 0;
        PANELCAL_CHECK(read_number(field, column, z_mm));
        row.z = mm(z_mm);
        return {};
      }
      case kZoom:
        return read_number(field, column, row.zoom.emplace());
      case kTool:
        return read_count(field, column, row.tool.emplace());
      case kSeq:
        return read_seq(field, row);
      case kLamp:
        row.lamp = std::string(field.text);
        return {};
      case kTime:
        row.time = std::string(field.text);
        return {};
      case kColumnCount:
        break;
    }
    return {};
  }

  Expected<void> read_file_name(const Field& field, PictureRow& row) const {
    const std::filesystem::path path(field.text);
    const bool leaves =
        std::any_of(path.begin(), path.end(), [](const auto& p) { return p == ".."; });
    if (path.is_absolute() || leaves || !path.has_filename()) {
      return error(field,
                   fmt::format("file name {} leaves the folder", panelcal::quoted(field.text)),
                   "a name relative to the folder of images.csv, without '..'");
    }
    row.file = std::string(field.text);
    return {};
  }

  Expected<void> read_number(const Field& field, Column column, double& value) const {
    const char* end = field.text.data() + field.text.size();
    const auto [stop, status] = std::from_chars(field.text.data(), end, value);
    if (status == std::errc() && stop == end && std::isfinite(value)) return {};
    return error(field,
                 fmt::format("{} {}", kColumnNames[column], panelcal::quoted(field.text)),
                 "a number with a decimal point");
  }

  Expected<void> read_count(const Field& field, Column column, int& value) const {
    const char* end = field.text.data() + field.text.size();
    const auto [stop, status] = std::from_chars(field.text.data(), end, value);
    if (status == std::errc() && stop == end && value >= 0) return {};
    return error(field,
                 fmt::format("{} {}", kColumnNames[column], panelcal::quoted(field.text)),
                 "a whole number from 0");
  }

  Expected<void> read_seq(const Field& field, PictureRow& row) {
    return read_count(field, kSeq, row.seq.emplace());
  }

  std::string_view rest_;
  std::string name_;
  int line_ = 0;
  std::vector<Column> columns_;
  double x_mm_ = 0;
  double y_mm_ = 0;
};

/// The shortest text that reads back as the same number.
std::string shortest(double value) {
  std::array<char, 32> buffer{};
  const auto [end, status] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return status == std::errc() ? std::string(buffer.data(), end) : std::string();
}

std::string text_of(const PictureRow& row, Column column) {
  switch (column) {
    case kFile:
      return row.file;
    case kX:
      return shortest(row.axis.in_mm().x());
    case kY:
      return shortest(row.axis.in_mm().y());
    case kZ:
      return row.z ? shortest(row.z->in_mm()) : "";
    case kTool:
      return row.tool ? std::to_string(*row.tool) : "";
    case kLamp:
      return row.lamp.value_or("");
    case kZoom:
      return row.zoom ? shortest(*row.zoom) : "";
    case kSeq:
      return row.seq ? std::to_string(*row.seq) : "";
    case kTime:
      return row.time.value_or("");
    case kColumnCount:
      break;
  }
  return "";
}

}  // namespace

Expected<std::vector<PictureRow>> parse_images_csv(std::string_view text, std::string_view name) {
  return Parser(text, name).parse();
}

Expected<PictureFolder> read_picture_folder(const std::filesystem::path& folder) {
  const std::filesystem::path list = folder / kListName;
  PANELCAL_TRY(const std::string text, read_file(list, kMaxListBytes));
  PANELCAL_TRY(std::vector<PictureRow> rows, parse_images_csv(text, list.string()));
  return PictureFolder{folder, std::move(rows)};
}

std::string format_images_csv(std::span<const PictureRow> rows) {
  std::vector<Column> columns;
  for (int i = 0; i < kColumnCount; ++i) {
    const auto column = static_cast<Column>(i);
    const bool is_used = std::any_of(rows.begin(), rows.end(), [&](const PictureRow& row) {
      return !text_of(row, column).empty();
    });
    if (is_used || column <= kY) columns.push_back(column);
  }
  std::string text;
  const auto add_line = [&](const auto& field_of) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (i > 0) text += ',';
      text += field_of(columns[i]);
    }
    text += '\n';
  };
  add_line([](Column column) { return std::string(kColumnNames[column]); });
  for (const PictureRow& row : rows) {
    add_line([&](Column column) { return text_of(row, column); });
  }
  return text;
}

}  // namespace panelcal
