// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "surface/map/file.h"
#include "surface/map/voids.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/provenance.h"
#include "tools/plan/design/places.h"

// The commands `panelcal surface WHAT`.
namespace panelcal::surface {

/// Every place that a program works at on a perfect panel.
struct ProgramPlaces {
  std::vector<plan::PlannedPlace> places;
  std::string format_file;  ///< as ProgramHead
};

/// Those of --program.
///
/// Fails  as reading and walking through a program does; usage: it works at none
Expected<ProgramPlaces> program_places(const SurfaceOptions& options, CommandContext& context);

/// The voids that a program leaves in a panel, each as wide as its tool.
struct ProgramVoids {
  std::vector<Void> voids;
  std::string format_file;  ///< as ProgramHead
};

/// Fails  as reading and walking through a program does; as VoidSink::take()
Expected<ProgramVoids> program_voids(const std::string& program,
                                     const SurfaceOptions& options,
                                     CommandContext& context);

/// The map of --zone, or the only one of `file`.
///
/// Fails  as read_zoned_map_file(); usage: no such zone, or several and none named
Expected<StoredMap> read_zone_of(const std::string& file,
                                 const std::string& command,
                                 const SurfaceOptions& options);
/// The same of a map that was read.
///
/// Out    which one
Expected<std::size_t> zone_of(const StoredZones& stored,
                              const std::string& file,
                              const std::string& command,
                              const SurfaceOptions& options);

/// Version, command line and digests, for what is written.
Provenance provenance_of(const CommandContext& context, std::span<const std::string> files);

Diagnostic usage(const std::string& command, std::string what, std::string expected);

}  // namespace panelcal::surface
