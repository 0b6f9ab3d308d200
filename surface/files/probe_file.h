// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "surface/files/probe_format.h"
#include "surface/fit/probe_point.h"
#include "surface/map/height_lattice.h"

namespace panelcal {

/// Reads a file of probed heights, strictly: whatever its program would skip or make up is refused.
///
/// Fails  file-unreadable; measurement-file and json-syntax with file:line:column (see the reader
///        of each format in surface/files); config-value (options)
/// Source the programs' own readers and writers, see surface/files
/// See    tests/surface/files, docs/formats/height_files.md
Expected<ProbeFile> read_probe_file(const std::filesystem::path& path,
                                    const ProbeFileOptions& options = {});

/// The same from text; `file` stands in the diagnostics, its extension may tell the format. Any
/// bytes give a value or a diagnostic.
Expected<ProbeFile> parse_probe_file(std::string_view text,
                                     const std::string& file,
                                     const ProbeFileOptions& options = {});

}  // namespace panelcal
