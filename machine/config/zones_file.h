// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "surface/map/voids.h"
#include "surface/map/zoned_map.h"

namespace panelcal {

/// A description of a table before its map is made: the surfaces on it, and the areas without one.
struct ZonesFile {
  std::vector<Zone> zones;  ///< in the order of the file: the first one that holds a place has it
  std::vector<Void> voids;  ///< the area beyond the panel's edge comes last
  std::optional<Length> probe_tip;  ///< diameter
};

/// Larger files are refused unread.
inline constexpr std::size_t kMaxZonesBytes = std::size_t{1} << 20;

/// Reads a zones.toml: `[[zone]]`, `[[void]]`, `[panel]` and `probe_tip_mm`.
///
/// In     defaults: of zones that do not say their own model or max_extrapolation_mm
/// Fails  file-unreadable; toml-syntax; config-key-unknown; config-value: an area that is not
///        valid, or not exactly one; a zone without a name or with that of another one
/// See    docs/formats/zones.md, tests/machine/config/zones_file_test.cc
Expected<ZonesFile> read_zones_file(const std::filesystem::path& path,
                                    const HeightMapOptions& defaults = {});
Expected<ZonesFile> parse_zones_file(std::string_view text,
                                     const std::filesystem::path& file,
                                     const HeightMapOptions& defaults = {});

}  // namespace panelcal
