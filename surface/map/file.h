// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "surface/fit/probe_point.h"
#include "surface/map/height_map.h"
#include "surface/map/source.h"
#include "surface/map/zoned_map.h"

namespace panelcal {

/// A map with all that it was made of.
struct StoredMap {
  std::vector<ProbePoint> points;  ///< those that were left out as well
  HeightMap map;                   ///< of these points
  std::vector<MapSource> sources;
  std::string made_by;  ///< "panelcal 0.1.0"
  /// Of a machine with several, from 0: whose heights they are; empty: it has one, or it is
  /// unknown.
  std::optional<int> z_axis = std::nullopt;

  /// The probes that make the map.
  std::vector<ProbePoint> kept_points() const;
};

/// A map of zones and voids with all that it was made of.
struct StoredZones {
  std::vector<ProbePoint> points;  ///< those that no zone has as well
  ZonedMap map;                    ///< of these points
  std::vector<MapSource> sources;
  std::string made_by;
  std::optional<int> z_axis = std::nullopt;  ///< as in StoredMap

  /// The map of one zone, or of all without zones, with its own probes alone.
  StoredMap zone(std::size_t i_zone) const;
};

/// Larger files are refused unread. A hole is some 20 bytes.
inline constexpr std::size_t kMaxMapBytes = std::size_t{1} << 26;

/// Reads a map that map_file_text() wrote: the probes, the model with the shape that was found, and
/// what was left out. The surface is solved again from these, nothing is chosen or searched again;
/// so heights and sigmas are the same to the bit.
///
/// Fails  file-unreadable; json-syntax; measurement-file: keys, numbers or words that make no map;
///        more probes of a zone than its model takes; config-value: as check_area() and
///        Voids::make(); grid-invalid: probes that make no surface
/// Cost   as that of surfaces of that number of probes; a second for 500,000 holes
/// See    docs/formats/surface_map.md, tests/surface/map/file_test.cc
Expected<StoredZones> read_zoned_map_file(const std::filesystem::path& path);

/// The same from text; `file` stands in the diagnostics. Any bytes give a map or a diagnostic.
Expected<StoredZones> parse_zoned_map_file(std::string_view text, const std::string& file);

/// A map without zones and voids.
///
/// Fails  as above; not-supported: a map of zones or with voids, which a user of one map alone
///        would overlook
Expected<StoredMap> read_map_file(const std::filesystem::path& path);
Expected<StoredMap> parse_map_file(std::string_view text, const std::string& file);

/// Version 1 without zones and voids, else version 2.
std::string map_file_text(const StoredZones& stored);
std::string map_file_text(const StoredMap& stored);

}  // namespace panelcal
