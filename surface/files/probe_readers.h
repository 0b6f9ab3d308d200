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

/// Klipper's printer.cfg: `[bed_mesh NAME]` with version, points (a line a row, from low y),
/// x_count, y_count, min_x to max_y, which SAVE_CONFIG writes behind `#*#`. Heights that Klipper
/// made up are missing: beyond mesh_radius, and in a faulty_region_N of [bed_mesh].
///
/// Fails  measurement-file: as chosen_profile() and file_of_profile(); a key that is unknown or
///        there twice
/// Source Klipper, bed_mesh.py (version 1 of profiles)
/// See    tests/surface/files/formats/klipper_mesh_test.cc
Expected<ProbeFile> parse_klipper_config(std::string_view text,
                                         const std::string& file,
                                         const ProbeFileOptions& options);

/// Moonraker's answer about `bed_mesh`, or that object alone: the mesh that is loaded
/// (probed_matrix, mesh_min, mesh_max), else one of `profiles`.
///
/// Fails  json-syntax; measurement-file: as chosen_profile() and file_of_profile(); a loaded mesh
///        that is not the profile of its name
/// Source Moonraker, printer objects; Klipper, status reference, bed_mesh
/// See    tests/surface/files/formats/klipper_mesh_test.cc
Expected<ProbeFile> parse_moonraker_json(std::string_view text,
                                         const std::string& file,
                                         const ProbeFileOptions& options);

/// Marlin's console of G29 T0 and M420 V: the report of unified bed leveling (rows from high y),
/// the grid of bilinear or of mesh bed leveling (rows from low y); without any the touches of
/// G29 V4 and G30. Places are those that the console states, or options.mesh.
///
/// Fails  measurement-file: as read_marlin_records(); meshes that differ; places that are not known
///        or contradict each other
/// Source Marlin 1.1 and 2.x, see read_marlin_records()
/// See    tests/surface/files/formats/marlin_console_test.cc
Expected<ProbeFile> parse_marlin_console(std::string_view text,
                                         const std::string& file,
                                         const ProbeFileOptions& options);

/// GRBL's probes, `[PRB:x,y,z:1]`, in machine coordinates, anywhere in a console. The work zero is
/// taken off where a status report (WCO) or `$#` states it, and named where none does. A probe that
/// touched nothing (`:0`) is missing; the one that `$#` repeats behind TLO does not count.
///
///   work = machine - WCO,   WCO = G54 + G92 + TLO
///
/// Fails  measurement-file: a work zero, unit or position that changed or got lost on the way; a
///        WCO that is not the sum of what `$#` says; four decimals of an unknown unit
/// Source GRBL 1.1 interface; grblHAL
/// See    tests/surface/files/formats/grbl_console_test.cc
Expected<ProbeFile> parse_grbl_console(std::string_view text,
                                       const std::string& file,
                                       const ProbeFileOptions& options);

/// Candle's .map: `x;y;width;height` of the border, `columns;rows;bottom;top`, `interpolation;x;y`,
/// then the heights, row by row from low y; `nan` was not probed.
///
/// Fails  measurement-file
/// Source Candle 1.1, frmmain.cpp, saveHeightMap()
/// See    tests/surface/files/formats/candle_map_test.cc
Expected<ProbeFile> parse_candle_map(std::string_view text,
                                     const std::string& file,
                                     const ProbeFileOptions& options);

/// Lines of x, y and height, between commas, semicolons, tabs or blanks, below a line of names or
/// without one; a sigma too. Decimal commas where semicolons or tabs part the columns. A unit
/// behind a name (`z_um`, `X (inch)`) is its column's. Lines without a height were not probed.
///
/// Fails  measurement-file: names from which x, y and height are not clear; a unit that contradicts
///        options.unit; points and commas in one file
/// See    tests/surface/files/formats/plain_csv_test.cc
Expected<ProbeFile> parse_plain_csv(std::string_view text,
                                    const std::string& file,
                                    const ProbeFileOptions& options);

}  // namespace panelcal::internal
