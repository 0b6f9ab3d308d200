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

/// The first byte chooses the format, the others are the file.
inline std::optional<std::string> run_probe_file(std::string_view bytes) {
  constexpr std::array<ProbeFormat, 5> kFormats = {ProbeFormat::HeightMapCsv,
                                                   ProbeFormat::LinuxCncLog,
                                                   ProbeFormat::BcncProbe,
                                                   ProbeFormat::OpenCncPilotMap,
                                                   ProbeFormat::RecordedProbes};
  if (bytes.empty()) return std::nullopt;
  const auto choice = static_cast<unsigned char>(bytes.front());
  const auto read = parse_probe_file(
      bytes.substr(1), "fuzz", {.format = kFormats[choice % kFormats.size()], .z_axis = 0});
  return read ? probe_file_complaint(*read) : probe_refusal_complaint(read.error());
}

}  // namespace panelcal::fuzz
