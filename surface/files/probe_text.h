// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "calib/base/expected.h"
#include "surface/files/height_grid.h"
#include "surface/files/probe_file.h"
#include "surface/fit/probe_point.h"

namespace panelcal {

/// A grid of heights as the text of a file, in mm, that its program and parse_probe_file() read.
///
/// heightmap: version 2, heights rounded to 1 um as the firmware does, without a date. bcnc: so
/// that a scan begun from the file stays 3 mm above the highest node and ends 1 mm below the
/// lowest, at 10 mm/min. linuxcnc: the nodes that have a height.
///
/// Fails  grid-invalid: as HeightGrid::validate(); a format without grids (probes); what a program
///        cannot say or would refuse: bcnc a missing node; heightmap steps below 0.1 mm, less than
///        1 mm from first to last, heights of 100 mm or more
/// See    tests/surface/files/probe_text_test.cc
Expected<std::string> probe_file_text(ProbeFormat format, const HeightGrid& grid);

/// Probes as the text of a log: linuxcnc, rounded to 1 nm, or probes, which keep their sigma and
/// every digit but have nothing of a program, so that only maps can be made of them.
///
/// Fails  grid-invalid: a format of grids, a number that is not finite
Expected<std::string> probe_file_text(ProbeFormat format, std::span<const ProbePoint> points);

}  // namespace panelcal
