// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <span>
#include <utility>

#include "machine/align/pad_readers.h"
#include "program/text/source_text.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

std::string lower_case(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return out;
}

std::string_view without_spaces(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
}

/// The cells of a row: of CSV by its separator, outside of quotes; else by blanks.
std::vector<std::string> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells;
  std::string cell;
  bool is_quoted = false;
  bool has_cell = false;
  const auto end_cell = [&] {
    cells.emplace_back(without_spaces(cell));
    cell.clear();
    has_cell = false;
  };
  for (const char c : line) {
    const bool is_blank = c == ' ' || c == '\t';
    if (c == '"') {
      is_quoted = !is_quoted;
      has_cell = true;
    } else if (!is_quoted && (separator == ' ' ? is_blank : c == separator)) {
      if (separator != ' ' || has_cell) end_cell();
    } else {
      cell += c;
      has_cell = true;
    }
  }
  if (separator != ' ' || has_cell) end_cell();
  return cells;
}

/// The columns that count, by the words of KiCad, Altium, Eagle and board houses.
struct Columns {
  std::size_t reference = 0;
  std::size_t x = 0;
  std::size_t y = 0;
  std::optional<std::size_t> side;
  Length unit = mm(1);
};

std::optional<std::size_t> column_named(const std::vector<std::string>& header,
                                        std::span<const std::string_view> names) {
  const auto is_one = [&](const std::string& cell) {
    const std::string word = lower_case(cell);
    // "Center-X(mm)" names its unit.
    const std::string_view name = without_spaces(std::string_view(word).substr(0, word.find('(')));
    return std::ranges::find(names, name) != names.end();
  };
  const auto found = std::ranges::find_if(header, is_one);
  if (found == header.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header.begin());
}

std::optional<Columns> columns_of(const std::vector<std::string>& header) {
  constexpr std::array<std::string_view, 5> kReference = {
      "ref", "designator", "refdes", "reference", "name"};
  constexpr std::array<std::string_view, 6> kX = {
      "posx", "mid x", "center-x", "x", "center x", "pos x"};
  constexpr std::array<std::string_view, 6> kY = {
      "posy", "mid y", "center-y", "y", "center y", "pos y"};
  constexpr std::array<std::string_view, 3> kSide = {"side", "layer", "tb"};
  const auto reference = column_named(header, kReference);
  const auto x = column_named(header, kX);
  const auto y = column_named(header, kY);
  if (!reference || !x || !y) return std::nullopt;
  Columns columns{*reference, *x, *y, column_named(header, kSide)};
  const std::string unit = lower_case(header[*x]);
  if (unit.find("(mil") != std::string::npos) columns.unit = inch(1e-3);
  if (unit.find("(in") != std::string::npos) columns.unit = inch(1);
  return columns;
}

/// The header of a file, and how it separates cells.
struct PlacementForm {
  Columns columns;
  char separator = ' ';
  LinePlace body;  ///< the first line behind the header
};

std::optional<PlacementForm> form_of(std::string_view bytes) {
  LineCursor cursor(bytes);
  std::optional<Length> unit;
  // A header stands at the top; KiCad's has four lines ahead of it.
  for (int i = 0; i < 20 && !cursor.at_end(); ++i) {
    std::string_view text = without_spaces(cursor.next().text);
    const std::string words = lower_case(text);
    if (words.find("unit = inch") != std::string::npos) unit = inch(1);
    if (words.starts_with("# ref")) text.remove_prefix(1);
    for (const char separator : {',', ';', '\t', ' '}) {
      auto columns = columns_of(cells_of(text, separator));
      if (!columns || (separator == ' ' && !words.starts_with("# ref"))) continue;
      if (unit) columns->unit = *unit;
      return PlacementForm{*columns, separator, cursor.place()};
    }
  }
  return std::nullopt;
}

bool is_fiducial(std::string_view reference) {
  const std::string word = lower_case(reference);
  return word.starts_with("fid") && word.size() > 3 &&
         std::ranges::all_of(word.substr(3), [](char c) { return c >= '0' && c <= '9'; });
}

bool is_bottom(std::string_view side) {
  return lower_case(side).starts_with('b');
}

/// "107.5", "107.5mm", "4232mil"; empty for any other text.
std::optional<Length> coordinate(std::string_view text, Length unit) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  const std::string_view rest = without_spaces({stop, static_cast<std::size_t>(end - stop)});
  if (rest == "mm") return mm(value);
  if (rest == "mil") return inch(value * 1e-3);
  if (rest == "in") return inch(value);
  if (!rest.empty()) return std::nullopt;
  return value * unit;
}

}  // namespace

bool is_placement(std::string_view bytes) {
  return form_of(bytes).has_value();
}

Expected<FoundPads> pads_of_placement(std::string_view bytes, const std::string& file) {
  const PlacementForm form = *form_of(bytes);
  const Columns& columns = form.columns;
  FoundPads top{{}, "fiducials FID* of the top side"};
  FoundPads bottom{{}, "fiducials FID* of the bottom side"};
  for (LineCursor cursor(bytes, form.body); !cursor.at_end();) {
    const SourceLine line = cursor.next();
    const std::vector<std::string> cells = cells_of(without_spaces(line.text), form.separator);
    if (columns.reference >= cells.size() || !is_fiducial(cells[columns.reference])) continue;
    const bool is_whole = std::max(columns.x, columns.y) < cells.size();
    const auto x = is_whole ? coordinate(cells[columns.x], columns.unit) : std::nullopt;
    const auto y = is_whole ? coordinate(cells[columns.y], columns.unit) : std::nullopt;
    if (!x || !y) {
      return failure({Code::NumberMalformed,
                      {file, line.number, 1},
                      quoted(line.text),
                      "a reference with both coordinates"});
    }
    const bool is_below =
        columns.side && *columns.side < cells.size() && is_bottom(cells[*columns.side]);
    FoundPads& side = is_below ? bottom : top;
    side.pads.push_back({{.nominal = position_mm<frame::Nominal>(x->in_mm(), y->in_mm()),
                          .line = line.number,
                          .name = cells[columns.reference]},
                         std::nullopt});
  }
  if (!top.pads.empty()) return top;
  if (!bottom.pads.empty()) return bottom;
  return failure({Code::Usage,
                  {file, 0, 0},
                  "no reference begins with FID",
                  "a placement file with FID1, FID2 ..., or the pads as a list \"X,Y;X,Y\""});
}

}  // namespace panelcal::internal
