// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "surface/files/grid_reader.h"
#include "surface/files/probe_readers.h"
#include "surface/files/probe_signs.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// The three lines ahead of the heights.
constexpr std::array<std::string_view, 3> kCandleHead = {
    "x; y; width; height of the border", "columns; rows; bottom; top", "interpolation; x; y"};
constexpr std::array<std::size_t, 3> kCandleCells = {4, 4, 3};

Expected<std::vector<double>> read_candle_line(const std::string& file,
                                               const TextField& line,
                                               std::size_t i) {
  const auto cells = cells_of(line, ';');
  if (cells.size() != kCandleCells[i]) {
    return failure({Code::MeasurementFile,
                    {file, line.line, 1},
                    fmt::format("a line of {} cells", cells.size()),
                    fmt::format("{}: {}", kCandleCells[i], kCandleHead[i])});
  }
  std::vector<double> out;
  for (const TextField& cell : cells) {
    PANELCAL_TRY(out.emplace_back(), number_of(file, cell));
  }
  return out;
}

/// Candle's fields of counts have decimals.
Expected<LatticeAxis> candle_axis(
    const std::string& file, const TextField& line, double first, double size, double n_nodes) {
  if (n_nodes != std::round(n_nodes) || n_nodes < 2 || n_nodes > kMaxFileProbes) {
    return failure(unexpected_field(file, line, "whole numbers of columns and rows, 2 or more"));
  }
  return LatticeAxis{first, size / (n_nodes - 1), static_cast<int>(n_nodes)};
}

Expected<void> read_candle_row(const std::string& file, const TextField& line, ReadGrid& grid) {
  const auto cells = cells_of(line, ';');
  if (cells.size() != static_cast<std::size_t>(grid.x.n_nodes)) {
    return failure({Code::MeasurementFile,
                    {file, line.line, 1},
                    fmt::format("{} heights", cells.size()),
                    fmt::format("{}, one for each column", grid.x.n_nodes)});
  }
  for (const TextField& cell : cells) {
    ReadNode node;
    node.from = {file, cell.line, cell.column};
    if (cell.text != "nan") {
      PANELCAL_TRY(node.height, number_of(file, cell));
    }
    grid.nodes.push_back(std::move(node));
  }
  return {};
}

}  // namespace

bool is_candle_map(std::string_view text) {
  const auto lines = first_lines(text, kCandleCells.size());
  if (lines.size() < kCandleCells.size()) return false;
  for (std::size_t i = 0; i < kCandleCells.size(); ++i) {
    const auto cells = cells_of(lines[i], ';');
    if (cells.size() != kCandleCells[i] || !are_numbers(cells)) return false;
  }
  return true;
}

Expected<ProbeFile> parse_candle_map(std::string_view text,
                                     const std::string& file,
                                     const ProbeFileOptions& options) {
  TextLines lines(text, file);
  std::array<std::vector<double>, 3> head;
  TextField counts;
  for (std::size_t i = 0; i < head.size(); ++i) {
    PANELCAL_TRY(const TextField line, lines.require(kCandleHead[i]));
    PANELCAL_TRY(head[i], read_candle_line(file, line, i));
    if (i == 1) counts = line;
  }
  ReadGrid grid;
  PANELCAL_TRY(grid.x, candle_axis(file, counts, head[0][0], head[0][2], head[1][0]));
  PANELCAL_TRY(grid.y, candle_axis(file, counts, head[0][1], head[0][3], head[1][1]));
  PANELCAL_CHECK(check_grid(file, counts, grid.x, grid.y));
  for (int row = 0; row < grid.y.n_nodes; ++row) {
    PANELCAL_TRY(const TextField line,
                 lines.require(fmt::format("row {} of {}", row, grid.y.n_nodes)));
    PANELCAL_CHECK(read_candle_row(file, line, grid));
  }
  PANELCAL_TRY(const std::optional<TextField> more, lines.next_filled());
  if (more) {
    return failure(unexpected_field(
        file, *more, fmt::format("the end of the file after {} rows", grid.y.n_nodes)));
  }
  PANELCAL_CHECK(check_line_end(text, file));
  return file_of_grid(ProbeFormat::CandleMap, file, grid, options);
}

}  // namespace panelcal::internal
