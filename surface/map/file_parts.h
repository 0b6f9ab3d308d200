// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "surface/map/height_map.h"
#include "surface/map/source.h"
#include "surface/map/voids.h"

// Not installed: part of surface/map/file.h, what a file holds as it is written, and the parts of
// a map that are made of it.
namespace panelcal::internal {

inline constexpr Code kMapFileCode = Code::MeasurementFile;

struct MapSurface {
  SurfaceModel model = SurfaceModel::Plane;
  std::string reason;
  std::vector<ShapeShare> shapes;
  HeightMapOptions options;
  std::vector<SurfaceOutlier> left_out;  ///< i_point counts all probes of the file
};

/// An area of one form: those members that it has.
struct MapArea {
  using Corners = std::vector<Position<frame::Nominal>>;
  std::optional<Corners> polygon;
  std::optional<Position<frame::Nominal>> center;
  std::optional<Length> diameter;
  std::optional<Corners> track;
  std::optional<Length> width;
  std::optional<Corners> outside;
};

/// A void, or circles of one name and size.
struct MapVoid {
  std::string name;
  std::string file;
  std::optional<int> line;
  MapArea area;
  std::vector<double> circles;  ///< x mm, y mm, line of each
};

struct MapZone {
  std::string name;
  std::optional<MapArea> area;
  MapSurface surface;
};

struct MapProbe {
  ProbePoint point;
  std::optional<int> i_source;
};

struct MapFile {
  std::string made_by;
  std::optional<int> z_axis;
  MapSurface surface;          ///< of version 1
  std::vector<MapZone> zones;  ///< of version 2, as `margin` and `voids`
  Length margin;
  std::vector<MapVoid> voids;
  std::vector<MapSource> sources;
  std::vector<MapProbe> probes;
};

/// The flaw of a map's file.
Diagnostic map_file_problem(const std::string& file, std::string what, std::string expected);

MapArea written_area(const Area& area);
/// Fails  measurement-file: no area that zones have; as check_area()
Expected<Area> zone_area(const MapArea& written, const std::string& name, const std::string& file);

/// One element for each void, but for circles of one name and size in a row, which share one.
std::vector<MapVoid> written_voids(std::span<const Void> voids);
/// Fails  measurement-file: none of the forms of voids; as Voids::make()
Expected<Voids> voids_of(const MapFile& written, const std::string& file);

/// In     own: indices of the probes that the surface is of, in the file
MapSurface written_surface(const HeightMap& map, std::span<const std::size_t> own);
/// Makes the surface that is written.
///
/// In     points: all of the file; own: indices of those that the surface is of, rising
/// Fails  measurement-file; as fit_surface() and HeightMap::of_surface(), at the file
Expected<HeightMap> surface_of(const MapSurface& written,
                               std::span<const ProbePoint> points,
                               std::span<const std::size_t> own,
                               const std::string& file);

}  // namespace panelcal::internal
