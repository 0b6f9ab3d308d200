// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "surface/files/grid_reader.h"
#include "surface/files/probe_readers.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Of a step: how far a probe may stand off its node.
constexpr double kOffNode = 0.1;

using Numbers = std::array<double, 3>;

struct Line {
  std::vector<TextField> words;
  Numbers numbers;
};

/// The next line of three numbers.
Expected<Line> read_three(TextLines& lines, const std::string& expected) {
  PANELCAL_TRY(const std::optional<TextField> line, lines.next_filled());
  if (!line) {
    return failure(
        {Code::MeasurementFile, {lines.file(), 0, 0}, "the file ends too early", expected});
  }
  Line out{words_of(*line), {}};
  if (out.words.size() != out.numbers.size()) {
    return failure({Code::MeasurementFile,
                    {lines.file(), line->line, out.words.front().column},
                    fmt::format("a line of {} words", out.words.size()),
                    expected});
  }
  for (std::size_t i = 0; i < out.numbers.size(); ++i) {
    PANELCAL_TRY(out.numbers[i], number_of(lines.file(), out.words[i]));
  }
  return out;
}

Expected<LatticeAxis> read_bcnc_axis(TextLines& lines, char name) {
  PANELCAL_TRY(const Line line, read_three(lines, fmt::format("{0}min {0}max {0}n", name)));
  constexpr int kMost = static_cast<int>(kMaxFileProbes);
  PANELCAL_TRY(const int n_nodes, count_of(lines.file(), line.words[2], 2, kMost));
  return LatticeAxis{line.numbers[0], (line.numbers[1] - line.numbers[0]) / (n_nodes - 1), n_nodes};
}

/// The node that a coordinate belongs to; empty if it belongs to none.
std::optional<int> bcnc_node(const LatticeAxis& axis, double value) {
  const double i = std::round((value - axis.first_mm) / axis.step_mm);
  if (!(i >= 0 && i < axis.n_nodes)) return std::nullopt;
  const int i_node = static_cast<int>(i);
  if (std::abs(value - axis.at_mm(i_node)) > kOffNode * axis.step_mm) return std::nullopt;
  return i_node;
}

}  // namespace

Expected<ProbeFile> parse_bcnc_probe(std::string_view text,
                                     const std::string& file,
                                     const ProbeFileOptions& options) {
  TextLines lines(text, file);
  ReadGrid grid;
  PANELCAL_TRY(grid.x, read_bcnc_axis(lines, 'x'));
  PANELCAL_TRY(grid.y, read_bcnc_axis(lines, 'y'));
  PANELCAL_CHECK(check_grid(file, {"", 1, 1}, grid.x, grid.y));
  PANELCAL_CHECK(read_three(lines, "zmin zmax feed"));
  const auto n_columns = static_cast<std::size_t>(grid.x.n_nodes);
  grid.nodes.resize(n_columns * static_cast<std::size_t>(grid.y.n_nodes));
  for (std::size_t k = 0; k < grid.nodes.size(); ++k) {
    PANELCAL_TRY(const Line line,
                 read_three(lines, fmt::format("x y z of {} nodes, has {}", grid.nodes.size(), k)));
    const auto column = bcnc_node(grid.x, line.numbers[0]);
    const auto row = bcnc_node(grid.y, line.numbers[1]);
    if (!column || !row) {
      return failure(unexpected_field(
          file, line.words[column ? 1 : 0], "a node of the grid, but for a tenth of a step"));
    }
    ReadNode& node =
        grid.nodes[static_cast<std::size_t>(*row) * n_columns + static_cast<std::size_t>(*column)];
    if (node.height) {
      return failure({Code::MeasurementFile,
                      {file, line.words[0].line, line.words[0].column},
                      fmt::format("column {} row {} again", *column, *row),
                      fmt::format("each node once; line {} has this one", node.from.line)});
    }
    node.height = line.numbers[2];
    node.from = {file, line.words[2].line, line.words[2].column};
  }
  PANELCAL_TRY(const std::optional<TextField> more, lines.next_filled());
  if (more) {
    return failure(unexpected_field(
        file, words_of(*more).front(), "the end of the file: all nodes have a height"));
  }
  return file_of_grid(ProbeFormat::BcncProbe, file, grid, options);
}

}  // namespace panelcal::internal
