// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "surface/files/grid_reader.h"
#include "surface/files/height_map_figures.h"
#include "surface/files/probe_readers.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::string_view kVersionLine = "RepRapFirmware height map file v";

/// The three versions of the label line, oldest first.
constexpr std::array<std::string_view, 3> kLabels = {
    "xmin,xmax,ymin,ymax,radius,spacing,xnum,ynum",
    "xmin,xmax,ymin,ymax,radius,xspacing,yspacing,xnum,ynum",
    "axis0,axis1,min0,max0,min1,max1,radius,spacing0,spacing1,num0,num1"};

/// Rounding of the file's limits and spacings.
constexpr double kRounding = 0.005;

struct Header {
  LatticeAxis x, y;
  double radius = -1;  ///< nodes farther from (0, 0) are not probed; below 0: none
};

Diagnostic bad_line(const std::string& file, const TextField& line, std::string expected) {
  return unexpected_field(file, line, std::move(expected));
}

/// Labels and values, as one version has them.
class CsvColumns {
 public:
  CsvColumns(const std::string& file, std::string_view labels, std::vector<TextField> values)
      : file_(file), labels_(cells_of({labels})), values_(std::move(values)) {}

  std::size_t n_labels() const { return labels_.size(); }
  std::size_t n_values() const { return values_.size(); }
  /// Precondition: as many values as labels.
  const TextField& at(std::string_view either, std::string_view other) const {
    const auto found = std::ranges::find_if(labels_, [&](const TextField& label) {
      return label.text == either || label.text == other;
    });
    return values_[static_cast<std::size_t>(found - labels_.begin())];
  }

  Expected<LatticeAxis> axis(std::string_view name, std::string_view number) const {
    const auto label = [](std::string_view first, std::string_view second) {
      return std::string(first) + std::string(second);
    };
    LatticeAxis out;
    PANELCAL_TRY(out.first_mm, number_of(file_, at(label(name, "min"), label("min", number))));
    const TextField& last_field = at(label(name, "max"), label("max", number));
    PANELCAL_TRY(const double last, number_of(file_, last_field));
    const bool is_oldest = labels_.size() == kOldestLabels;
    PANELCAL_TRY(out.step_mm,
                 number_of(file_,
                           is_oldest ? at("spacing", "")
                                     : at(label(name, "spacing"), label("spacing", number))));
    constexpr int kMost = static_cast<int>(kMaxFileProbes);
    const TextField& n_field = at(label(name, "num"), label("num", number));
    PANELCAL_TRY(out.n_nodes, count_of(file_, n_field, 2, kMost));
    const double rest = last - out.last_mm();
    const double rounding = kRounding * (out.n_nodes + 1);
    if (rest > -rounding && rest < out.step_mm + rounding) return out;
    return failure(unexpected_field(
        file_,
        n_field,
        fmt::format(
            "as many nodes as fit from {:g} to {:g} every {:g}", out.first_mm, last, out.step_mm)));
  }

 private:
  static constexpr std::size_t kOldestLabels = 8;

  const std::string& file_;
  std::vector<TextField> labels_;
  std::vector<TextField> values_;
};

Expected<Header> read_header(TextLines& lines) {
  const std::string& file = lines.file();
  PANELCAL_TRY(const TextField labels, lines.require("the line of labels"));
  if (std::ranges::find(kLabels, labels.text) == kLabels.end()) {
    return failure(bad_line(file, labels, quoted(kLabels.back(), kLabels.back().size())));
  }
  PANELCAL_TRY(const TextField line, lines.require("the line of the grid"));
  const CsvColumns columns(file, labels.text, cells_of(line));
  if (columns.n_values() != columns.n_labels()) {
    return failure({Code::MeasurementFile,
                    {file, line.line, 1},
                    fmt::format("{} values", columns.n_values()),
                    fmt::format("{}, one for each label", columns.n_labels())});
  }
  if (labels.text == kLabels.back()) {
    for (const auto& [label, letter] : {std::pair("axis0", "X"), std::pair("axis1", "Y")}) {
      const TextField& axis = columns.at(label, "");
      if (axis.text != letter) return failure(unexpected_field(file, axis, quoted(letter)));
    }
  }
  Header out;
  PANELCAL_TRY(out.x, columns.axis("x", "0"));
  PANELCAL_TRY(out.y, columns.axis("y", "1"));
  PANELCAL_TRY(out.radius, number_of(file, columns.at("radius", "")));
  PANELCAL_CHECK(check_grid(file, line, out.x, out.y));
  return out;
}

Expected<void> read_row(TextLines& lines, const Header& header, int row, ReadGrid& grid) {
  const int n_columns = header.x.n_nodes;
  PANELCAL_TRY(const TextField line,
               lines.require(fmt::format("row {} of {}", row, header.y.n_nodes)));
  const std::vector<TextField> cells = cells_of(line);
  if (cells.size() != static_cast<std::size_t>(n_columns)) {
    return failure({Code::MeasurementFile,
                    {lines.file(), line.line, 1},
                    fmt::format("{} heights", cells.size()),
                    fmt::format("{}, one for each column", n_columns)});
  }
  for (int column = 0; column < n_columns; ++column) {
    const TextField& cell = cells[static_cast<std::size_t>(column)];
    ReadNode node;
    node.from = {lines.file(), cell.line, cell.column};
    if (cell.text == "0") {
      const double distance = std::hypot(header.x.at_mm(column), header.y.at_mm(row));
      if (header.radius > 0 && distance >= header.radius) {
        node.reason = fmt::format("beyond the probed radius of {:g}", header.radius);
      }
    } else {
      PANELCAL_TRY(node.height, number_of(lines.file(), cell));
    }
    grid.nodes.push_back(std::move(node));
  }
  return {};
}

}  // namespace

Expected<ProbeFile> parse_height_map_csv(std::string_view text,
                                         const std::string& file,
                                         const ProbeFileOptions& options) {
  TextLines lines(text, file);
  const std::string expected = fmt::format("\"{}1\" or \"{}2\"", kVersionLine, kVersionLine);
  PANELCAL_TRY(const TextField first, lines.require(expected));
  const std::string_view version =
      first.text.starts_with(kVersionLine) ? first.text.substr(kVersionLine.size()) : "";
  const bool is_known = version.starts_with('1') || version.starts_with('2');
  if (!is_known || (version.size() > 1 && version[1] != ' ' && version[1] != ',')) {
    return failure(bad_line(file, first, expected));
  }
  PANELCAL_TRY(const Header header, read_header(lines));
  ReadGrid grid{header.x, header.y, {}};
  for (int row = 0; row < header.y.n_nodes; ++row) {
    PANELCAL_CHECK(read_row(lines, header, row, grid));
  }
  PANELCAL_TRY(const std::optional<TextField> more, lines.next_filled());
  if (more) {
    return failure(
        bad_line(file, *more, fmt::format("the end of the file after {} rows", header.y.n_nodes)));
  }
  std::vector<double> heights;
  for (const ReadNode& node : grid.nodes) {
    if (node.height) heights.push_back(*node.height);
  }
  PANELCAL_CHECK(check_figures(file, first, heights));
  return file_of_grid(ProbeFormat::HeightMapCsv, file, grid, options);
}

}  // namespace panelcal::internal
