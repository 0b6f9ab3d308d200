// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "surface/fit/probe_point.h"
#include "surface/map/height_lattice.h"

namespace panelcal {

/// Program whose file of probed heights it is.
enum class ProbeFormat : std::uint8_t {
  HeightMapCsv,     ///< RepRapFirmware's `heightmap.csv`: a grid
  LinuxCncLog,      ///< LinuxCNC's `(PROBEOPEN ...)`: a place and its height a line
  BcncProbe,        ///< bCNC's `.probe`: a grid
  OpenCncPilotMap,  ///< OpenCNCPilot's `.hmap`: a grid
  RecordedProbes,   ///< panelcal's own readings, JSON Lines, docs/formats/probes.md
  KlipperConfig,    ///< Klipper's `printer.cfg`: a saved `[bed_mesh NAME]`, a grid
  MoonrakerJson,    ///< Moonraker's object `bed_mesh`: a grid
  MarlinConsole,    ///< a console of `G29 T`, `M420 V` or `G29 V4`: a grid, or a place a line
  GrblConsole,      ///< `[PRB:x,y,z:1]` among other lines
  CandleMap,        ///< Candle's `.map`: a grid
  PlainCsv,         ///< x, y and height a line
};

/// `heightmap`, `linuxcnc`, `bcnc`, `opencncpilot`, `probes`, `klipper`, `moonraker`, `marlin`,
/// `grbl`, `candle` or `csv`, as options name them.
std::string_view name_of(ProbeFormat format);

std::optional<ProbeFormat> probe_format_from_name(std::string_view name);

/// The first and the last node of a mesh, in mm: those of the lowest and the highest x and y.
struct MeshCorners {
  Eigen::Vector2d low_mm, high_mm;
};

struct ProbeFileOptions {
  /// Empty: told from the text; where that says nothing, from the extension (.probe, .hmap, .jsonl,
  /// .map, .csv).
  std::optional<ProbeFormat> format = std::nullopt;
  /// The probe's sigma where the file states none. Recorded probes state their own. Empty: 5 um is
  /// assumed, and the probes are marked as such (ProbePoint::is_sigma_assumed).
  std::optional<Length> sigma = std::nullopt;
  /// The unit of a file that states none: inch(1) if the machine was set to inches. Empty: mm.
  std::optional<Length> unit = std::nullopt;
  /// Z axis whose height is taken of probes with several, from 0. Empty: there must be only one.
  std::optional<int> z_axis = std::nullopt;
  /// Name of a mesh, of a Klipper file that has several. Empty: there must be only one.
  std::string profile = {};
  /// Of a Marlin mesh whose console does not state it.
  std::optional<MeshCorners> mesh = std::nullopt;

  /// sigma, or what is assumed.
  Length scatter() const { return sigma.value_or(um(5)); }
  double unit_mm() const { return unit.value_or(mm(1)).in_mm(); }

  /// Fails  config-value
  Expected<void> validate() const;
};

/// A place that was to be probed and has no height.
struct MissingProbe {
  Position<frame::Nominal> place;
  std::string name;    ///< as that of a ProbePoint: `column 3 row 4`, counted from 0
  std::string reason;  ///< `not probed`
  Place from;
};

/// Evenly spaced columns and rows, as a file of a grid states them.
struct ProbeGrid {
  LatticeAxis x, y;
};

/// Heights as a file has them. Places are taken as nominal: relative to work zero, x right, y up.
struct ProbeFile {
  ProbeFormat format = ProbeFormat::LinuxCncLog;
  std::string file;                   ///< as diagnostics name it
  std::vector<ProbePoint> points;     ///< in the order of the file
  std::vector<MissingProbe> missing;  ///< in the order of the grid or of the file, never filled
  std::optional<ProbeGrid> grid;      ///< of the formats that are grids
  bool states_sigma = false;          ///< the file says what its probes scatter
  std::string unit;  ///< of its lengths, and whence: `mm`, `inch ($13=1 of line 4)`
  std::string zero;  ///< from where its places and heights count, a noun phrase
  /// Of several, or chosen: whose heights they are, from 0; empty: the file does not say.
  std::optional<int> z_axis;
};

/// Larger files are refused unread, as are grids of more nodes and logs of more lines.
inline constexpr std::size_t kMaxProbeFileBytes = std::size_t{1} << 26;

inline constexpr std::size_t kMaxFileProbes = 100'000;

}  // namespace panelcal
