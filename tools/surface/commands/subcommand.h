// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/json/facts.h"
#include "surface/map/file.h"
#include "surface/map/voids.h"
#include "tools/cli/commands.h"
#include "tools/cli/provenance.h"
#include "tools/plan/design/places.h"

// The commands `panelcal surface WHAT`.
namespace panelcal::surface {

/// The text for standard output, and whether all of it could be done.
struct Answer {
  std::string text;
  ExitCode code = ExitCode::Done;
};

Expected<Answer> fit(const SurfaceOptions& options, CommandContext& context);
Expected<Answer> query(const SurfaceOptions& options, CommandContext& context);
Expected<Answer> diff(const SurfaceOptions& options, CommandContext& context);
Expected<Answer> plan(const SurfaceOptions& options, CommandContext& context);
Expected<Answer> apply(const SurfaceOptions& options, CommandContext& context);
Expected<Answer> export_map(const SurfaceOptions& options, CommandContext& context);

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

/// Makes a document of facts where --json or --report asks for one.
///
/// In     make: the document; title: of the page; text: the result in words
/// Out    what standard output gets: the text, or the document with `--json -`
/// Fails  as write_file()
Expected<std::string> with_facts(const SurfaceOptions& options,
                                 const std::function<facts::Json()>& make,
                                 const std::string& title,
                                 std::string text);

/// Fails  usage, of `panelcal surface WHAT`: no `extension` at a name that is not empty
Expected<void> check_extension(const std::string& command,
                               const std::string& name,
                               std::string_view extension);

Diagnostic usage(const std::string& command, std::string what, std::string expected);

}  // namespace panelcal::surface
