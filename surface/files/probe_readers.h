// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "surface/files/probe_format.h"

// Not installed: part of surface/files/probe_file.h. A reader each, in a file of its own; `file`
// stands in the diagnostics.
namespace panelcal::internal {

/// RepRapFirmware's heightmap.csv: a line with the version and, behind commas, figures of the
/// heights; a line of labels, which has three versions; the grid; the heights, row by row. A `0`
/// without a decimal point stands for a node that was not probed, as do all beyond the radius.
///
/// The figures must be those of the heights, but for rounding: else the file was changed.
///
/// Fails  measurement-file
/// Source RepRapFirmware, Grid.cpp (loading and saving of 1.x to 3.x)
/// See    tests/surface/files/formats/height_map_csv_test.cc
Expected<ProbeFile> parse_height_map_csv(std::string_view text,
                                         const std::string& file,
                                         const ProbeFileOptions& options);

/// LinuxCNC's log of G38 probes: each line X Y Z and up to A B C U V W. The height is Z + W.
///
/// Fails  measurement-file: a line of fewer than 3 or more than 9 numbers; A, B or C not 0: a
///        tilted tool probes no height; U or V not 0: the place of the probe is unknown
/// Source LinuxCNC, G-code reference, G38.n (PROBEOPEN)
/// See    tests/surface/files/formats/linuxcnc_log_test.cc
Expected<ProbeFile> parse_linuxcnc_log(std::string_view text,
                                       const std::string& file,
                                       const ProbeFileOptions& options);

/// bCNC's .probe: `xmin xmax xn`, `ymin ymax yn`, `zmin zmax feed`, then x y z of each node.
///
/// A place must be within a tenth of a step of a node, as bCNC has it, and each node there once;
/// bCNC itself skips others and takes 0 for their height.
///
/// Fails  measurement-file
/// Source bCNC, CNC.py, class Probe
/// See    tests/surface/files/formats/bcnc_probe_test.cc
Expected<ProbeFile> parse_bcnc_probe(std::string_view text,
                                     const std::string& file,
                                     const ProbeFileOptions& options);

/// OpenCNCPilot's .hmap, XML: `heightmap` with MinX MinY MaxX MaxY SizeX SizeY, and in it `point`s
/// with X and Y, indices from 0, whose text is the height. A node without a point was not probed.
///
/// Fails  measurement-file
/// Source OpenCNCPilot, HeightMap.cs
/// See    tests/surface/files/formats/opencncpilot_map_test.cc
Expected<ProbeFile> parse_opencncpilot_map(std::string_view text,
                                           const std::string& file,
                                           const ProbeFileOptions& options);

/// panelcal's readings. Of a line only `probe`, `nominal`, `status`, `zaxis`, `height` and `sigma`
/// matter to a map; what belongs to the program's request may be left out, and is checked where the
/// program is known (machine/sources/probe_file_source.h). A probe that found nothing is missing.
///
/// Fails  json-syntax; measurement-file; measurement-invalid (a sigma that is not above 0)
/// Source docs/formats/probes.md
/// See    tests/surface/files/formats/recorded_probes_test.cc
Expected<ProbeFile> parse_recorded_probes(std::string_view text,
                                          const std::string& file,
                                          const ProbeFileOptions& options);

}  // namespace panelcal::internal
