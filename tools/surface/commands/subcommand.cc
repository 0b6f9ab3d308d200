// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/commands/subcommand.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "machine/config/machine_config.h"
#include "machine/job/checked_program.h"
#include "machine/job/walk_terms.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/process/version.h"
#include "tools/surface/commands/void_sink.h"
#include <fmt/format.h>

namespace panelcal::surface {

Diagnostic usage(const std::string& command, std::string what, std::string expected) {
  return {Code::Usage, {command, 0, 0}, std::move(what), std::move(expected)};
}

Provenance provenance_of(const CommandContext& context, std::span<const std::string> files) {
  Provenance out = {{"made by", std::string("panelcal ") + kVersion},
                    command_line_row(context.options)};
  for (const std::string& file : files) {
    if (const auto bytes = read_file(file)) out.emplace_back("sha256 " + file, sha256(*bytes));
  }
  return out;
}

namespace {

using Execute = std::function<void(const CheckedProgram&, const WalkOptions&, DiagnosticLog&)>;

/// Calls `execute` with a program that has no errors, to pass its job on the perfect panel.
///
/// Out    the file beside it that has decided on its number format; empty: none has
Expected<std::string> walk_program(const std::string& program,
                                   const SurfaceOptions& options,
                                   CommandContext& context,
                                   const Execute& execute) {
  PANELCAL_TRY(MachineConfig config, read_machine_config(options.machine));
  // Targets that are where they are drawn speak for no model; a slot's ends say all about it.
  config.walk.chooses_model = false;
  config.walk.slots = config.walk.step_slots = Cycles::Kept;
  PANELCAL_CHECK(set_walk_terms({.program = program,
                                 .clock = options.clock,
                                 .now = system_clock()(),
                                 .max_operations = options.max_operations,
                                 .reading = options.reading,
                                 .ages_offset = false,
                                 .command = "panelcal surface"},
                                config));
  DiagnosticLog log;
  const auto checked = read_and_check(program, config.reading, config.walk, log);
  if (checked) PANELCAL_CHECK(check_patterns(context.options, checked->program, context.files));
  if (checked && !log.has_errors()) execute(*checked, config.walk, log);
  DiagnosticLog others;
  std::optional<Diagnostic> first;
  for (const Diagnostic& diagnostic : log.kept()) {
    if (!first && diagnostic.severity() == Severity::Error) {
      first = diagnostic;
    } else {
      others.add(diagnostic);
    }
  }
  context.console.print(others);
  if (first) return failure(*std::move(first));
  return checked->program.head->format_file;
}

}  // namespace

Expected<ProgramPlaces> program_places(const SurfaceOptions& options, CommandContext& context) {
  ProgramPlaces of;
  const auto execute =
      [&](const CheckedProgram& checked, const WalkOptions& walk, DiagnosticLog& log) {
        plan::PlaceSink sink(checked.nominal_survey, [&](const plan::PassingPlace& place) {
          of.places.push_back(place.kept());
        });
        execute_nominal(checked, walk, sink, log);
      };
  PANELCAL_TRY(of.format_file, walk_program(options.program, options, context, execute));
  if (!of.places.empty()) return of;
  return failure(usage("panelcal surface",
                       quoted(options.program) + " works at no place",
                       "a program that drills or routs"));
}

Expected<ProgramVoids> program_voids(const std::string& program,
                                     const SurfaceOptions& options,
                                     CommandContext& context) {
  VoidSink sink(program);
  ProgramVoids of;
  const auto execute = [&](const CheckedProgram& checked,
                           const WalkOptions& walk,
                           DiagnosticLog& log) { execute_nominal(checked, walk, sink, log); };
  PANELCAL_TRY(of.format_file, walk_program(program, options, context, execute));
  PANELCAL_TRY(of.voids, sink.take());
  return of;
}

Expected<std::size_t> zone_of(const StoredZones& stored,
                              const std::string& file,
                              const std::string& command,
                              const SurfaceOptions& options) {
  const auto zones = stored.map.zones();
  if (zones.size() <= 1 && options.zone.empty()) return 0;
  std::vector<std::string_view> names;
  for (const Zone& zone : zones) names.push_back(zone.name);
  const auto found = std::ranges::find(names, options.zone);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  const std::string_view nearest = nearest_word(options.zone, names);
  std::vector<std::string> shown;
  for (const std::string_view name : names) shown.push_back(quoted(name));
  return failure(
      usage(command,
            options.zone.empty() ? fmt::format("{} has {} zones", file, zones.size())
                                 : fmt::format("{} has no zone {}", file, quoted(options.zone)),
            zones.empty()      ? std::string("no --zone: it has one surface all over")
            : !nearest.empty() ? "did you mean --zone " + quoted(nearest) + "?"
                               : fmt::format("--zone with one of {}", fmt::join(shown, ", "))));
}

Expected<StoredMap> read_zone_of(const std::string& file,
                                 const std::string& command,
                                 const SurfaceOptions& options) {
  PANELCAL_TRY(const StoredZones stored, read_zoned_map_file(file));
  PANELCAL_TRY(const std::size_t i_zone, zone_of(stored, file, command, options));
  return stored.zone(i_zone);
}

}  // namespace panelcal::surface
