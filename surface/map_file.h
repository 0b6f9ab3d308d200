// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "panelcal/calib/base/expected.h"
#include "panelcal/surface/height_map.h"
#include "panelcal/surface/probe_point.h"

namespace panelcal {

/// A file that probes of a map came from.
struct MapSource {
  std::string file;
  std::string sha256;  ///< of its bytes; empty if nobody knows
};

/// A map with all that it was made of.
struct StoredMap {
  std::vector<ProbePoint> points;  ///< those that were left out as well
  HeightMap map;                   ///< of these points
  std::vector<MapSource> sources;
  std::string made_by;  ///< "panelcal 0.1.0"

  /// The probes that make the map.
  std::vector<ProbePoint> kept_points() const;
};

/// Larger files are refused unread.
inline constexpr std::size_t kMaxMapBytes = std::size_t{1} << 24;

/// Reads a map that map_file_text() wrote: the probes, the model with the shape that was found, and
/// what was left out. The surface is solved again from these, nothing is chosen or searched again;
/// so heights and sigmas are the same to the bit.
///
/// Fails  file-unreadable; json-syntax; measurement-file: keys, numbers or words that make no map;
///        grid-invalid: probes that make no surface
/// See    docs/formats/surface_map.md, tests/surface/map_file_test.cc
Expected<StoredMap> read_map_file(const std::filesystem::path& path);

/// The same from text; `file` stands in the diagnostics. Any bytes give a map or a diagnostic.
Expected<StoredMap> parse_map_file(std::string_view text, const std::string& file);

std::string map_file_text(const StoredMap& stored);

}  // namespace panelcal
