// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "surface/files/probe_readers.h"
#include "surface/files/probe_signs.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// What a column may hold, in the order that a table without names has.
enum CsvRole : std::size_t { kCsvX, kCsvY, kCsvHeight, kCsvSigma, kCsvRoles };
constexpr std::array<std::string_view, kCsvRoles> kCsvRoleNames = {"x", "y", "height", "sigma"};
constexpr std::size_t kCsvPlaceCells = 2;

struct CsvUnit {
  std::string_view name;  ///< in a header, in lower case
  std::string_view word;  ///< in messages
  Length length;
};
constexpr std::array<CsvUnit, 25> kCsvUnits = {{
    {"mm", "mm", mm(1)},           {"millimeter", "mm", mm(1)},  {"millimeters", "mm", mm(1)},
    {"millimetre", "mm", mm(1)},   {"millimetres", "mm", mm(1)}, {"um", "um", um(1)},
    {"\xC2\xB5m", "um", um(1)},  // the sign for micro
    {"\xCE\xBCm", "um", um(1)},  // the Greek letter
    {"\xB5m", "um", um(1)},      // the sign in Latin 1
    {"\xC2\xB5", "um", um(1)},     {"\xCE\xBC", "um", um(1)},    {"\xB5", "um", um(1)},
    {"micron", "um", um(1)},       {"microns", "um", um(1)},     {"micrometer", "um", um(1)},
    {"micrometers", "um", um(1)},  {"micrometre", "um", um(1)},  {"micrometres", "um", um(1)},
    {"in", "inch", inch(1)},       {"inch", "inch", inch(1)},    {"inches", "inch", inch(1)},
    {"mil", "mil", inch(0.001)},   {"mils", "mil", inch(0.001)}, {"thou", "mil", inch(0.001)},
    {"thous", "mil", inch(0.001)},
}};
/// What other tables count in: never to be taken for a part of a name.
constexpr std::array<std::string_view, 27> kOtherUnits = {
    "m",           "cm",     "dm",         "km",          "nm",         "meter",       "meters",
    "metre",       "metres", "centimeter", "centimeters", "centimetre", "centimetres", "ft",
    "foot",        "feet",   "yd",         "yard",        "yards",      "uin",         "microinch",
    "microinches", "tenth",  "tenths",     "steps",       "counts",     "pulses"};

/// A cell of the header: words in lower case, and a unit at their end.
struct CsvTitle {
  std::optional<CsvRole> role;
  const CsvUnit* unit = nullptr;  ///< empty: none
  bool is_unclear = false;        ///< has a unit that is not known, or one not at its end
};

struct CsvColumn {
  std::optional<std::size_t> i_cell;  ///< empty: the table has none
  double unit_mm = 1;
  std::string_view unit_word;  ///< empty: the header says none
};

std::vector<TextField> split_csv(const TextField& line, char separator) {
  return separator == ' ' ? words_of(line) : cells_of(line, separator);
}

char csv_separator(std::span<const TextField> lines) {
  for (const char separator : {';', '\t', ','}) {
    for (const TextField& line : lines) {
      if (trimmed(line).text.find(separator) != std::string_view::npos) return separator;
    }
  }
  return ' ';
}

bool has_decimal_comma(std::string_view word, char separator) {
  return (separator == ';' || separator == '\t') && word.find(',') != std::string_view::npos;
}

bool is_missing_height(std::string_view word) {
  return word.empty() || word == "nan" || word == "NaN" || word == "NAN";
}

bool is_csv_value(std::string_view word, char separator) {
  if (is_missing_height(word)) return true;
  std::string text(word);
  if (has_decimal_comma(word, separator)) text[text.find(',')] = '.';
  return is_number(text);
}

std::vector<std::string> lower_words(std::string_view text) {
  std::vector<std::string> out(1);
  for (char c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    const bool is_letter = (c >= 'a' && c <= 'z') || static_cast<unsigned char>(c) >= 0x80;
    if (is_letter) {
      out.back() += c;
    } else if (!out.back().empty()) {
      out.emplace_back();
    }
  }
  if (out.back().empty()) out.pop_back();
  return out;
}

const CsvUnit* csv_unit(std::string_view word) {
  for (const CsvUnit& unit : kCsvUnits) {
    if (unit.name == word) return &unit;
  }
  return nullptr;
}

bool is_other_unit(std::string_view word) {
  return std::ranges::find(kOtherUnits, word) != kOtherUnits.end();
}

bool is_unit(std::string_view word) {
  return csv_unit(word) != nullptr || is_other_unit(word);
}

/// Brackets at a title's end hold a unit that is known, or what the column is.
bool has_odd_brackets(std::string_view cell) {
  const std::size_t end = cell.find_last_of(")]}>");
  if (end == std::string_view::npos || !lower_words(cell.substr(end)).empty()) return false;
  const std::size_t begin = cell.substr(0, end).find_last_of("([{<");
  if (begin == std::string_view::npos) return true;
  const TextField inside = trimmed(TextField{cell.substr(begin + 1, end - begin - 1)});
  const std::vector<std::string> words = lower_words(inside.text);
  // With a number it is a multiple of a unit.
  if (words.size() != 1 || words[0].size() != inside.text.size()) return true;
  return csv_unit(words[0]) == nullptr && words[0] != "z" &&
         std::ranges::find(kCsvRoleNames, words[0]) == kCsvRoleNames.end();
}

/// `um_z`, `z_um_raw` and `zum`: there is a unit, but not as the last word.
bool has_misplaced_unit(const std::vector<std::string>& words) {
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const bool may_be_other = words[i] == "m" || (words[i] == "in" && i > 0);
    if (is_unit(words[i]) && !may_be_other) return true;
  }
  if (words.size() != 1) return false;
  constexpr std::array<std::string_view, 4> kNames = {"x", "y", "z", "height"};
  return std::ranges::any_of(kNames, [&](std::string_view name) {
    return words[0].starts_with(name) && is_unit(std::string_view(words[0]).substr(name.size()));
  });
}

CsvTitle csv_title(std::string_view cell) {
  const std::vector<std::string> words = lower_words(cell);
  const auto has = [&](std::string_view word) {
    return std::ranges::find(words, word) != words.end();
  };
  CsvTitle out;
  if (words.size() > 1) out.unit = csv_unit(words.back());
  out.is_unclear = (words.size() > 1 && is_other_unit(words.back())) || has_odd_brackets(cell) ||
                   has_misplaced_unit(words);
  if (has("sigma") || has("stddev")) {
    out.role = kCsvSigma;
  } else if (has("x") + has("y") + (has("z") || has("height")) == 1) {
    out.role = has("x") ? kCsvX : has("y") ? kCsvY : kCsvHeight;
  }
  return out;
}

/// The header without the mark of a comment ahead of it.
TextField csv_header(const TextField& line) {
  const TextField text = trimmed(line);
  return text.text.starts_with('#') ? trimmed(part_of(text, 1)) : text;
}

bool are_csv_values(const std::vector<TextField>& cells, char separator) {
  return std::ranges::all_of(
      cells, [&](const TextField& cell) { return is_csv_value(cell.text, separator); });
}

bool has_csv_number(const std::vector<TextField>& cells, char separator) {
  return std::ranges::any_of(cells, [&](const TextField& cell) {
    return !is_missing_height(cell.text) && is_csv_value(cell.text, separator);
  });
}

class CsvReader {
 public:
  CsvReader(std::string_view text, const std::string& file, const ProbeFileOptions& options)
      : lines_(text, file),
        file_(file),
        options_(options),
        separator_(csv_separator(first_lines(text, 2))) {}

  Expected<ProbeFile> read() {
    out_.format = ProbeFormat::PlainCsv;
    out_.file = file_;
    PANELCAL_TRY(const std::optional<TextField> first, lines_.next_filled());
    if (!first) return std::move(out_);
    const TextField header = csv_header(*first);
    const std::vector<TextField> cells = split_csv(header, separator_);
    n_cells_ = cells.size();
    if (are_csv_values(cells, separator_)) {
      PANELCAL_CHECK(count_columns(header));
      PANELCAL_CHECK(read_row(*first));
    } else {
      PANELCAL_CHECK(check_header(cells));
      PANELCAL_CHECK(find_columns(header, cells));
    }
    while (true) {
      PANELCAL_TRY(const std::optional<TextField> line, lines_.next_filled());
      if (!line) break;
      if (trimmed(*line).text.starts_with('#')) continue;
      PANELCAL_CHECK(read_row(*line));
    }
    out_.unit = unit_text();
    return std::move(out_);
  }

 private:
  Expected<void> count_columns(const TextField& line) {
    if (n_cells_ != kCsvSigma) {
      return failure({Code::MeasurementFile,
                      {file_, line.line, 1},
                      fmt::format("{} columns without names", n_cells_),
                      "3: x, y and the height, or a line of names ahead of them"});
    }
    for (std::size_t i = 0; i < kCsvSigma; ++i) columns_[i] = {i, options_.unit_mm(), {}};
    return {};
  }

  /// A row with one bad cell is no line of names.
  Expected<void> check_header(const std::vector<TextField>& cells) const {
    if (!has_csv_number(cells, separator_)) return {};
    const auto odd = std::ranges::find_if(
        cells, [&](const TextField& cell) { return !is_csv_value(cell.text, separator_); });
    return failure(
        unexpected_field(file_, *odd, "a number as beside it, or a line of names alone"));
  }

  /// Makes a cell's column that of a role, in the unit that its title states.
  Expected<void> take_column(std::size_t role, std::size_t i_cell, const TextField& cell) {
    const CsvTitle title = csv_title(cell.text);
    if (title.is_unclear) {
      return failure(
          unexpected_field(file_, cell, "mm, um, mil or inch as its last word, or no unit"));
    }
    CsvColumn& column = columns_[role];
    column = {i_cell, options_.unit_mm(), {}};
    if (title.unit == nullptr) return {};
    column.unit_mm = title.unit->length.in_mm();
    column.unit_word = title.unit->word;
    if (options_.unit && role < kCsvHeight && title.unit->length != *options_.unit) {
      return failure(unexpected_field(file_, cell, "the unit that --unit says, or no --unit"));
    }
    return {};
  }

  Expected<void> find_columns(const TextField& header, const std::vector<TextField>& cells) {
    header_line_ = header.line;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const CsvTitle title = csv_title(cells[i].text);
      if (!title.role) continue;
      if (columns_[*title.role].i_cell) {
        return failure(unexpected_field(
            file_, cells[i], fmt::format("one column of {}", kCsvRoleNames[*title.role])));
      }
      PANELCAL_CHECK(take_column(*title.role, i, cells[i]));
    }
    return complete_columns(header, cells);
  }

  /// What the names leave open: a plan whose heights were written behind it, and three columns of
  /// which no name is known.
  Expected<void> complete_columns(const TextField& header, const std::vector<TextField>& cells) {
    const bool has_x = columns_[kCsvX].i_cell.has_value(),
               has_y = columns_[kCsvY].i_cell.has_value();
    const bool has_height = columns_[kCsvHeight].i_cell.has_value();
    if (has_x && has_y && has_height) return {};
    const bool is_plan = has_x && has_y && cells.size() == kCsvPlaceCells;
    const bool is_unknown =
        !has_x && !has_y && !has_height && cells.size() == kCsvSigma && !columns_[kCsvSigma].i_cell;
    if (is_plan) {
      may_lack_height_ = true;
      n_cells_ = kCsvPlaceCells + 1;
      columns_[kCsvHeight] = {kCsvPlaceCells, options_.unit_mm(), {}};
      return {};
    }
    if (is_unknown) {
      for (std::size_t i = 0; i < kCsvSigma; ++i) PANELCAL_CHECK(take_column(i, i, cells[i]));
      return {};
    }
    return failure(unexpected_field(
        file_, header, "one column each of x, y and z (or height); sigma if it has one"));
  }

  Expected<double> value_of(const TextField& cell, std::size_t role) {
    const bool is_comma = has_decimal_comma(cell.text, separator_);
    if (is_comma || cell.text.find('.') != std::string_view::npos) {
      if (!decimal_comma_) decimal_comma_ = is_comma;
      if (*decimal_comma_ != is_comma) {
        return failure(unexpected_field(
            file_,
            cell,
            *decimal_comma_ ? "a decimal comma, as before" : "a decimal point, as before"));
      }
    }
    std::string text(cell.text);
    if (is_comma) text[text.find(',')] = '.';
    const auto value = signed_number_of(file_, {text, cell.line, cell.column});
    if (!value) return failure(unexpected_field(file_, cell, value.error().expected));
    return *value * columns_[role].unit_mm;
  }

  Expected<void> read_row(const TextField& line) {
    const std::vector<TextField> cells = split_csv(trimmed(line), separator_);
    const bool lacks_height = may_lack_height_ && cells.size() == kCsvPlaceCells;
    if (cells.size() != n_cells_ && !lacks_height) {
      return failure({Code::MeasurementFile,
                      {file_, line.line, 1},
                      fmt::format("{} columns", cells.size()),
                      fmt::format("{}, as in the lines before", n_cells_)});
    }
    if (out_.points.size() + out_.missing.size() == kMaxFileProbes) {
      return failure({Code::MeasurementFile,
                      {file_, line.line, 1},
                      "the table is too long",
                      fmt::format("at most {} lines", kMaxFileProbes)});
    }
    PANELCAL_TRY(const double x_mm, value_of(cells[*columns_[kCsvX].i_cell], kCsvX));
    PANELCAL_TRY(const double y_mm, value_of(cells[*columns_[kCsvY].i_cell], kCsvY));
    const auto place = position_mm<frame::Nominal>(x_mm, y_mm);
    std::string name = fmt::format("probe of line {}", line.line);
    const Place from = {file_, line.line, cells.front().column};
    if (lacks_height || is_missing_height(cells[*columns_[kCsvHeight].i_cell].text)) {
      out_.missing.push_back({place, std::move(name), "no height in the table", from});
      return {};
    }
    const TextField& height = cells[*columns_[kCsvHeight].i_cell];
    PANELCAL_TRY(const double height_mm, value_of(height, kCsvHeight));
    Length sigma = options_.scatter();
    if (columns_[kCsvSigma].i_cell) {
      const TextField& cell = cells[*columns_[kCsvSigma].i_cell];
      PANELCAL_TRY(const double sigma_mm, value_of(cell, kCsvSigma));
      if (!(sigma_mm > 0)) return failure(unexpected_field(file_, cell, "a sigma above 0"));
      sigma = mm(sigma_mm);
      out_.states_sigma = true;
    }
    out_.points.push_back({place, {mm(height_mm), sigma}, std::move(name), from});
    return {};
  }

  std::string unit_text() const {
    std::string stated;
    for (std::size_t i = 0; i < kCsvRoles; ++i) {
      if (columns_[i].unit_word.empty()) continue;
      stated += fmt::format(
          "{}{} in {}", stated.empty() ? "" : ", ", kCsvRoleNames[i], columns_[i].unit_word);
    }
    if (stated.empty()) return {};
    return fmt::format("{} (line {})", stated, header_line_);
  }

  TextLines lines_;
  const std::string& file_;
  const ProbeFileOptions& options_;
  char separator_;
  std::array<CsvColumn, kCsvRoles> columns_;
  std::size_t n_cells_ = 0;
  int header_line_ = 0;
  bool may_lack_height_ = false;
  std::optional<bool> decimal_comma_;
  ProbeFile out_;
};

}  // namespace

bool is_plain_csv(std::string_view text) {
  const auto lines = first_lines(text, 2);
  if (lines.empty() || is_candle_map(text)) return false;
  const char separator = csv_separator(lines);
  const auto first = split_csv(csv_header(lines[0]), separator);
  const bool has_header = !are_csv_values(first, separator);
  if (has_header && lines.size() < 2) return false;
  // Such lines of numbers alone are a log.
  if (!has_header && are_numbers(words_of(lines[0]))) return false;
  const auto cells = has_header ? split_csv(trimmed(lines[1]), separator) : first;
  const bool is_plan = first.size() == kCsvPlaceCells && cells.size() == kCsvPlaceCells + 1;
  if (cells.size() < kCsvPlaceCells || (cells.size() != first.size() && !is_plan)) return false;
  if (has_header) {
    return std::ranges::count_if(cells, [&](const TextField& cell) {
             return is_csv_value(cell.text, separator);
           }) >= static_cast<std::ptrdiff_t>(kCsvPlaceCells);
  }
  return true;
}

Expected<ProbeFile> parse_plain_csv(std::string_view text,
                                    const std::string& file,
                                    const ProbeFileOptions& options) {
  PANELCAL_CHECK(check_line_end(text, file));
  PANELCAL_TRY(ProbeFile out, CsvReader(text, file, options).read());
  if (out.points.empty() && !out.missing.empty()) {
    return failure({Code::MeasurementFile,
                    out.missing.front().from,
                    "places without heights",
                    "a third column with the heights that were probed there"});
  }
  return out;
}

}  // namespace panelcal::internal
