// SPDX-License-Identifier: Apache-2.0
// Like command_line.cc it includes CLI11: seconds to compile.
#include <string>
#include <vector>

#include "surface/fit/shape.h"
#include "tools/cli/options/command_options.h"
#include "tools/cli/options/program_options.h"
#include <CLI/CLI.hpp>

namespace panelcal {
namespace {

constexpr const char* kClock = "Date and time for texts, such as 2026-11-21T13:45:00";

/// Of a map of several zones one is taken.
void add_zone(CLI::App& command, SurfaceOptions& o) {
  command.add_option("--zone", o.zone, "Name of the zone, of a map that has several");
}

/// A program's places are asked for, as a job would work at them.
CLI::Option* add_program(CLI::App& command, SurfaceOptions& o, const char* what) {
  CLI::Option* program = command.add_option("--program", o.program, what);
  CLI::Option* machine = command.add_option("-m,--machine", o.machine, "machine.toml");
  program->needs(machine);
  machine->needs(program);
  command.add_option("--clock", o.clock, kClock);
  add_reading(command, o.reading, program);
  return program;
}

void add_levelling(CLI::App& command, SurfaceOptions& o) {
  command
      .add_option("--height-tolerance-um",
                  o.height_tolerance_um,
                  "How near to its height the tool has to be all along a move")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command
      .add_option("--safe-mm",
                  o.safe_mm,
                  "Moves at this Z or above stay (default: the lowest Z above the board at which "
                  "the program travels)")
      ->check(CLI::Range(-1e3, 1e3));
  command.add_option("--zero", o.zero_mm, "X,Y: where the tool's Z was set to 0, mm")
      ->expected(2)
      ->delimiter(',');
  command.add_option("--unit", o.gcode_unit, "Of a program that has neither G20 nor G21")
      ->check(CLI::IsMember({"mm", "inch"}));
}

void add_max_sigma(CLI::App& command, SurfaceOptions& o, const char* help) {
  command.add_option("--max-sigma-um", o.max_sigma_um, help)->check(CLI::Range(1e-3, 1e6));
}

void add_alignment_in_force(CLI::App& command, ApplyOptions& o) {
  command.add_option("-m,--machine", o.machine, "machine.toml")->required();
  command.add_option("--align", o.align, "board.align.json of `panelcal align`")->required();
  command
      .add_option("--valid",
                  o.valid_hours,
                  "Hours for which a panel is taken to lie where it was seen last")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command
      .add_option("--tolerance-um",
                  o.tolerance_um,
                  "How near lines and arcs have to be to the way of the board")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command.add_option("--surface", o.surface.map, "The tool also follows this map (.json)");
  add_levelling(command, o.surface);
}

}  // namespace

void add_surface_fit_options(CLI::App& command, SurfaceOptions& o) {
  add_json(command, o.facts);
  command
      .add_option("PROBES",
                  o.files,
                  "Files of one panel: panelcal's, RepRapFirmware's, LinuxCNC's, bCNC's, "
                  "OpenCNCPilot's, Klipper's, Marlin's, GRBL's, Candle's, or a table of x, y, z")
      ->required();
  command.add_option("-o,--output", o.output, "The map (.json)")->required();
  CLI::Option* machine = command.add_option(
      "-m,--machine",
      o.machine,
      "machine.toml, whose [surface] grid_hold_mm is how far heights are extrapolated");
  std::vector<std::string> models = {"auto"};
  for (const std::string_view word : surface_model_words()) models.emplace_back(word);
  command.add_option("--model", o.model, "Model of the surface between probes")
      ->check(CLI::IsMember(models))
      ->capture_default_str();
  command.add_option("--sigma-um", o.sigma_um, "Scatter of a probe whose file states none (5)")
      ->check(CLI::Range(1e-3, 1e5));
  command
      .add_option("--max-extrapolation-mm",
                  o.max_extrapolation_mm,
                  "How far outside of the probes the map still gives heights (5)")
      ->check(CLI::Range(0.0, 1000.0));
  command.add_option("--zones", o.zones, "Zones, clamps, cut-outs and the panel's edge (.toml)");
  CLI::Option* voids_of =
      command
          .add_option(
              "--voids-of",
              o.voids_of,
              "A program whose holes, slots and contours are there already; may be repeated")
          ->needs(machine)
          ->expected(1)
          ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  // --format is that of the probes.
  add_reading(command, o.reading, voids_of, "--program-format");
  command
      .add_option("--probe-tip-mm",
                  o.probe_tip_mm,
                  "Diameter of the probe's tip: a probe that may touch a void does not count (1)")
      ->check(CLI::Range(1e-3, 100.0));
  command.add_option("--clock", o.clock, kClock);
  command.add_option("--format", o.format, "Of the files (default: told from their texts)")
      ->check(CLI::IsMember({"probes",
                             "heightmap",
                             "linuxcnc",
                             "bcnc",
                             "opencncpilot",
                             "klipper",
                             "moonraker",
                             "marlin",
                             "grbl",
                             "candle",
                             "csv"}));
  command.add_option("--unit", o.unit, "Of files that state none (mm)")
      ->check(CLI::IsMember({"mm", "inch"}));
  command.add_option("--profile", o.profile, "Which mesh of a Klipper file that has several");
  command
      .add_option(
          "--mesh-mm",
          o.mesh_mm,
          "X0,Y0,X1,Y1: the first and last node of a Marlin mesh whose console does not say")
      ->expected(4)
      ->delimiter(',');
  command.add_option("--zaxis", o.z_axis, "Whose heights, of probes with several Z axes (from 0)")
      ->check(CLI::Range(0, 63));
  add_report(command, o.facts, "Heights, sigmas and probes as a page (.html)");
}

void add_surface_query_options(CLI::App& command, SurfaceOptions& o) {
  add_json(command, o.facts);
  command.add_option("MAP", o.map, "The map (.json)")->required();
  CLI::Option* places = command.add_option(
      "PLACE", o.places, "X,Y in mm, as many as you like; - reads them, one a line");
  CLI::Option* program = add_program(command, o, "Every place that this program works at");
  CLI::Option* grid =
      command.add_option("--grid", o.grid, "NXxNY: columns and rows over the probes");
  places->excludes(program)->excludes(grid);
  program->excludes(grid);
}

void add_surface_diff_options(CLI::App& command, SurfaceOptions& o) {
  add_json(command, o.facts);
  command.add_option("MAP", o.files, "Two maps: before and after")->required()->expected(2);
  add_zone(command, o);
  add_report(command, o.facts, "The difference as a page (.html)");
}

void add_surface_plan_options(CLI::App& command, SurfaceOptions& o) {
  add_json(command, o.facts);
  CLI::Option* map = command.add_option(
      "MAP", o.map, "A map of this panel, or with --afresh of one like it (.json)");
  add_zone(command, o);
  command
      .add_option("--tolerance-um", o.tolerance_um, "The sigma that the map may have at any place")
      ->required()
      ->check(CLI::Range(1e-3, 1e6));
  add_program(command, o, "Heights matter where this program works");
  command.add_option("--area", o.area_mm, "X0,Y0,X1,Y1: where one may probe, mm")
      ->expected(4)
      ->delimiter(',');
  command
      .add_flag("--afresh", o.afresh, "Another panel of this kind: the map's probes do not count")
      ->needs(map);
  CLI::Option* amplitude =
      command.add_option("--amplitude-mm", o.amplitude_mm, "How high such panels bend (sigma)")
          ->check(CLI::Range(1e-6, 1e3));
  CLI::Option* length =
      command.add_option("--length-mm", o.length_mm, "The distance over which they do")
          ->check(CLI::Range(1e-3, 1e5));
  CLI::Option* sigma =
      command.add_option("--probe-sigma-um", o.probe_sigma_um, "What a probe scatters")
          ->check(CLI::Range(1e-3, 1e5));
  amplitude->needs(length)->excludes(map);
  length->needs(amplitude)->excludes(map);
  amplitude->needs(sigma);
  command.add_option("-o,--output", o.output, "List of the places, in the order to probe (.csv)");
  add_report(command, o.facts, "The plan as a page (.html)");
}

void add_surface_apply_options(CLI::App& command, SurfaceOptions& o) {
  add_json(command, o.facts);
  command.add_option("MAP", o.map, "The map (.json)")->required();
  command.add_option("GCODE", o.gcode, "The program")->required();
  command.add_option("-o,--output", o.output, "The levelled program; - is standard output")
      ->required();
  add_levelling(command, o);
  add_max_sigma(command, o, "Refuse where the map is less sure than this");
}

void add_align_apply_options(CLI::App& command, ApplyOptions& o) {
  command.add_option("GCODE", o.program, "The program")->required();
  add_alignment_in_force(command, o);
  command.add_option("-o,--output", o.output, "The moved program; - is standard output")
      ->required();
  add_max_sigma(command, o.surface, "Refuse where a place in X and Y is less sure than this");
}

void add_filter_options(CLI::App& command, ApplyOptions& o) {
  command.add_option("PROGRAM", o.program, "A program to drill or rout, or G-code")->required();
  add_alignment_in_force(command, o);
  add_max_sigma(
      command, o.surface, "G-code: refuse where a place in X and Y is less sure than this");
}

void add_surface_export_options(CLI::App& command, SurfaceOptions& o) {
  add_json(command, o.facts);
  command.add_option("MAP", o.map, "The map (.json)")->required();
  command
      .add_option("-o,--output",
                  o.output,
                  "heightmap.csv, .probe, .hmap, .jsonl, or any name with --format; - is standard "
                  "output")
      ->required();
  command.add_option("--format", o.format, "Of the file (default: by its name)")
      ->check(CLI::IsMember({"probes", "heightmap", "linuxcnc", "bcnc", "opencncpilot"}));
  command.add_option("--grid", o.grid, "NXxNY: columns and rows over the probes");
  command.add_flag("--fill", o.fill, "Heights of nodes that no probe vouches for, too");
  command.add_option("--zero", o.zero_mm, "X,Y: where heights are 0, mm (default: as in the map)")
      ->expected(2)
      ->delimiter(',');
}

}  // namespace panelcal
