// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/json/strict_json.h"
#include "surface/fit/probe_point.h"
#include "surface/map/height_map.h"
#include "surface/map/source.h"
#include <nlohmann/json.hpp>

// Not installed: part of surface/map/file.h, what its versions have in common.
namespace panelcal::internal {

inline constexpr Code kMapFileCode = Code::MeasurementFile;
/// Farther away or higher nothing is probed: a wrong unit.
inline constexpr double kMostInMap_mm = 3e7;

/// The flaw of a map's file.
Diagnostic map_file_problem(const std::string& file, std::string what, std::string expected);

std::string json_text(const std::string& text);

/// Elements on lines of their own: `"key": [...]`.
std::string list_text(std::string_view key,
                      const std::vector<std::string>& elements,
                      std::string_view indent);

/// The elements of an array of objects, each of which has the same keys.
Expected<std::vector<StrictObject>> read_objects(const StrictObject& top,
                                                 std::string_view key,
                                                 std::string_view what,
                                                 std::span<const std::string_view> keys,
                                                 const std::string& file);

Expected<std::vector<MapSource>> read_sources(const StrictObject& top, const std::string& file);
std::vector<std::string> source_texts(const std::vector<MapSource>& sources);

Expected<std::vector<ProbePoint>> read_probes(const StrictObject& top,
                                              const std::vector<MapSource>& sources,
                                              const std::string& file);
std::vector<std::string> probe_texts(const std::vector<ProbePoint>& points,
                                     const std::vector<MapSource>& sources);

/// Makes the surface that `model`, `reason`, `shape`, `options` and `left_out` of an object say.
///
/// In     points: all of the file; own: indices of those that the surface is of, rising
/// Fails  measurement-file; as fit_surface() and HeightMap::of_surface(), at the file
Expected<HeightMap> read_surface(const StrictObject& object,
                                 std::span<const ProbePoint> points,
                                 std::span<const std::size_t> own,
                                 const std::string& file);

/// These keys but `left_out`, each on a line of its own.
std::string surface_text(const HeightMap& map, std::string_view indent);
std::vector<std::string> left_out_texts(const HeightMap& map, std::span<const std::size_t> own);

}  // namespace panelcal::internal
