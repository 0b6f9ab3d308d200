// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "panelcal/calib/base/expected.h"
#include "panelcal/tools/commands.h"
#include "panelcal/tools/plan_places.h"
#include "panelcal/tools/provenance.h"

// What `panelcal surface WHAT` does.
namespace panelcal::surface {

/// What goes to standard output, and whether all of it could be done.
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

/// Every place that --program works at on a perfect panel.
///
/// Fails  as reading and walking through a program does; usage: it works at none
Expected<std::vector<plan::PlannedPlace>> program_places(const SurfaceOptions& options,
                                                         CommandContext& context);

/// Version, command line and digests, for what is written.
Provenance provenance_of(const CommandContext& context, std::span<const std::string> files);

/// Fails  usage, of `panelcal surface WHAT`: no `extension` at a name that is not empty
Expected<void> check_extension(const std::string& command,
                               const std::string& name,
                               std::string_view extension);

Diagnostic usage(const std::string& command, std::string what, std::string expected);

}  // namespace panelcal::surface
