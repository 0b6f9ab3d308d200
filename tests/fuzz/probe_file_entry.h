// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "surface/files/height_grid.h"
#include "surface/files/probe_file.h"
#include "surface/files/probe_text.h"

namespace panelcal::fuzz {

/// Complaint about a refusal: it must be of the right kind and in one printable line.
inline std::optional<std::string> probe_refusal_complaint(const Diagnostic& diagnostic) {
  constexpr std::array<Code, 3> kCodes = {
      Code::MeasurementFile, Code::MeasurementInvalid, Code::JsonSyntax};
  if (std::ranges::find(kCodes, diagnostic.code) == kCodes.end()) {
    return "refused as something else: " + diagnostic.text();
  }
  if (diagnostic.what.empty()) return "refused without a reason";
  const bool is_printable =
      std::ranges::all_of(diagnostic.text(), [](char c) { return c >= ' ' && c <= '~'; });
  if (!is_printable) return "refused in unprintable words";
  return std::nullopt;
}

/// Complaint about a file that was read; empty if all is well.
inline std::optional<std::string> probe_file_complaint(const ProbeFile& read) {
  if (read.points.empty()) return "read without any height";
  for (const ProbePoint& point : read.points) {
    if (!point.place.in_mm().allFinite() || !std::isfinite(point.measured.height.in_mm()) ||
        !(point.measured.sigma.in_mm() > 0)) {
      return "a point that is not finite or too far away";
    }
    if (point.name.empty() || point.from.line < 1) return "a point from nowhere";
  }
  const auto text = probe_file_text(ProbeFormat::RecordedProbes, read.points);
  if (!text) return "cannot be written: " + text.error().text();
  const auto again = parse_probe_file(*text, "again.jsonl");
  if (!again || again->points.size() != read.points.size()) return "reads back as something else";
  if (!read.grid) return std::nullopt;
  const auto n_nodes = static_cast<std::size_t>(read.grid->x.n_nodes * read.grid->y.n_nodes);
  if (read.points.size() + read.missing.size() != n_nodes) return "a node that is forgotten";
  const auto grid = height_grid(read);
  if (!grid) return "no grid: " + grid.error().text();
  const auto map = probe_file_text(ProbeFormat::OpenCncPilotMap, *grid);
  if (!map) return "cannot be written as a grid: " + map.error().text();
  const auto map_again = parse_probe_file(*map, "again.hmap");
  if (!map_again || height_grid(*map_again)->heights != grid->heights) {
    return "reads back as another grid";
  }
  return std::nullopt;
}

/// The first byte chooses how the others are read: `A` to `K` as a format, `L` as the text itself
/// tells, `M` as a Marlin console with places that it does not state.
inline std::optional<std::string> run_probe_file(std::string_view bytes) {
  constexpr unsigned kFormats = 11, kChoices = 13;
  if (bytes.empty()) return std::nullopt;
  const unsigned choice = static_cast<unsigned char>(bytes.front()) % kChoices;
  ProbeFileOptions options{.z_axis = 0};
  if (choice < kFormats) options.format = static_cast<ProbeFormat>(choice);
  if (choice > kFormats) {
    options.format = ProbeFormat::MarlinConsole;
    options.mesh = MeshCorners{{0, 0}, {40, 30}};
  }
  const auto read = parse_probe_file(bytes.substr(1), "fuzz", options);
  return read ? probe_file_complaint(*read) : probe_refusal_complaint(read.error());
}

}  // namespace panelcal::fuzz
