// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "surface/files/formats/xml_scanner.h"
#include "surface/files/grid_reader.h"
#include "surface/files/probe_readers.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

Expected<void> check_tag(const std::string& file,
                         const XmlTag& tag,
                         std::string_view name,
                         std::span<const std::string_view> keys) {
  if (tag.name.text != name) {
    return failure(unexpected_field(file, tag.name, fmt::format("<{}>", name)));
  }
  for (const auto& [key, value] : tag.attributes) {
    if (std::ranges::find(keys, key.text) != keys.end()) continue;
    return failure(unexpected_field(file, key, fmt::format("{}", fmt::join(keys, ", "))));
  }
  return {};
}

Expected<LatticeAxis> read_pilot_axis(const std::string& file, const XmlTag& tag, char name) {
  PANELCAL_TRY(const TextField low_field, tag.attribute(file, fmt::format("Min{}", name)));
  PANELCAL_TRY(const TextField high_field, tag.attribute(file, fmt::format("Max{}", name)));
  PANELCAL_TRY(const TextField size_field, tag.attribute(file, fmt::format("Size{}", name)));
  PANELCAL_TRY(const double low, number_of(file, low_field));
  PANELCAL_TRY(const double high, number_of(file, high_field));
  PANELCAL_TRY(const int n_nodes, count_of(file, size_field, 2, static_cast<int>(kMaxFileProbes)));
  return LatticeAxis{low, (high - low) / (n_nodes - 1), n_nodes};
}

Expected<void> read_point(XmlScanner& scanner, ReadGrid& grid) {
  constexpr std::array<std::string_view, 2> kKeys = {"X", "Y"};
  const std::string& file = scanner.file();
  PANELCAL_TRY(const XmlTag tag, scanner.start_tag());
  PANELCAL_CHECK(check_tag(file, tag, "point", kKeys));
  PANELCAL_TRY(const TextField column_field, tag.attribute(file, "X"));
  PANELCAL_TRY(const TextField row_field, tag.attribute(file, "Y"));
  PANELCAL_TRY(const int column, count_of(file, column_field, 0, grid.x.n_nodes - 1));
  PANELCAL_TRY(const int row, count_of(file, row_field, 0, grid.y.n_nodes - 1));
  ReadNode& node = grid.nodes[static_cast<std::size_t>(row * grid.x.n_nodes + column)];
  if (node.height) {
    return failure({Code::MeasurementFile,
                    {file, tag.name.line, tag.name.column},
                    fmt::format("column {} row {} again", column, row),
                    fmt::format("each node once; line {} has this one", node.from.line)});
  }
  TextField height_field = tag.name;
  height_field.text = {};
  if (!tag.is_empty) {
    PANELCAL_TRY(height_field, scanner.text());
    PANELCAL_CHECK(scanner.end_tag("point"));
  }
  PANELCAL_TRY(node.height, number_of(file, height_field));
  node.from = {file, height_field.line, height_field.column};
  return {};
}

}  // namespace

Expected<ProbeFile> parse_opencncpilot_map(std::string_view text,
                                           const std::string& file,
                                           const ProbeFileOptions& options) {
  constexpr std::array<std::string_view, 6> kKeys = {
      "MinX", "MinY", "MaxX", "MaxY", "SizeX", "SizeY"};
  XmlScanner scanner(text, file);
  PANELCAL_TRY(const XmlTag tag, scanner.start_tag());
  PANELCAL_CHECK(check_tag(file, tag, "heightmap", kKeys));
  ReadGrid grid;
  PANELCAL_TRY(grid.x, read_pilot_axis(file, tag, 'X'));
  PANELCAL_TRY(grid.y, read_pilot_axis(file, tag, 'Y'));
  PANELCAL_CHECK(check_grid(file, tag.name, grid.x, grid.y));
  ReadNode none;
  none.from = {file, tag.name.line, tag.name.column};
  grid.nodes.assign(static_cast<std::size_t>(grid.x.n_nodes * grid.y.n_nodes), none);
  while (!tag.is_empty) {
    PANELCAL_TRY(const bool is_over, scanner.at_end_tag());
    if (is_over) {
      PANELCAL_CHECK(scanner.end_tag("heightmap"));
      break;
    }
    PANELCAL_CHECK(read_point(scanner, grid));
  }
  PANELCAL_CHECK(scanner.end());
  return file_of_grid(ProbeFormat::OpenCncPilotMap, file, grid, options);
}

}  // namespace panelcal::internal
