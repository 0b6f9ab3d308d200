// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/clock.h"
#include "machine/align/alignment.h"
#include "machine/align/measure.h"
#include "machine/config/machine_config.h"
#include "machine/job/alignment_check.h"
#include "program/gcode/leveller.h"
#include "program/gcode/mover.h"
#include "program/gcode/recognition.h"
#include "surface/map/file.h"
#include "tools/align/machine_places.h"
#include "tools/cli/commands.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/provenance.h"
#include "tools/surface/levelling.h"
#include <fmt/format.h>

namespace panelcal::align {
namespace {

constexpr std::string_view kMovedBy = "(moved by panelcal";

/// Fails  as restore_panel() and check_age()
Expected<AlignedPanel> panel_in_force(const ApplyOptions& options, const MachineConfig& machine) {
  constexpr double kHour_s = 3600;
  const std::chrono::sys_seconds now = system_clock()();
  PANELCAL_TRY(const Alignment alignment, read_alignment(options.align));
  const auto valid_s = static_cast<std::int64_t>(std::llround(options.valid_hours * kHour_s));
  PANELCAL_CHECK(check_age(alignment, now, std::chrono::seconds(valid_s)));
  return restore_panel(alignment, machine, now);
}

std::string moved_text(const MoveFigures& figures) {
  std::string out = fmt::format(
      "moved {} of {} moves into {} pieces; largest shift {:.1f} um\n"
      "largest predicted sigma {:.3f} um, in line {}\n",
      figures.n_moved,
      figures.n_moves,
      figures.n_pieces,
      figures.largest_shift.in_um(),
      figures.largest_sigma.in_um(),
      figures.line_of_largest_sigma);
  if (figures.n_left > 0) {
    out +=
        fmt::format("{} lines in the machine's own coordinates (G53, G28, G30) stay as they are\n",
                    figures.n_left);
  }
  return out;
}

/// A G-code program for the panel as it lies, and what has changed.
struct Applied {
  std::string text;
  std::string words;  ///< for people
  Length largest_sigma;
  int line_of_largest_sigma = 0;
};

Expected<Applied> apply_to(const SourceText& program,
                           const ApplyOptions& options,
                           const MachineConfig& machine,
                           const AlignedPanel& panel,
                           const std::function<void(double)>& progress) {
  if (program.bytes.find(kMovedBy) != std::string::npos) {
    return failure({Code::ArgumentInvalid,
                    {program.file, 0, 0},
                    "a program that was moved before",
                    "the one that it was made of"});
  }
  const LevelOptions levelling = surface::level_options(options.surface);
  const MoveOptions moving{
      .tolerance = um(options.tolerance_um), .unit_mm = levelling.unit_mm, .progress = progress};
  PANELCAL_TRY(MovedGcode moved, move_gcode(program, MachinePlaces(panel, machine), moving));
  const MoveFigures& figures = moved.figures;
  PANELCAL_CHECK(check_one_origin(program.file, figures.nominal, *panel.survey()));
  Applied out{.text = {},
              .words = moved_text(figures),
              .largest_sigma = figures.largest_sigma,
              .line_of_largest_sigma = figures.line_of_largest_sigma};
  if (options.surface.map.empty()) {
    out.text = std::move(moved.text);
    return out;
  }
  PANELCAL_TRY(const StoredZones stored, read_zoned_map_file(options.surface.map));
  const auto source_line = [&](int line) {
    return line > 0 ? moved.source_lines.at(static_cast<std::size_t>(line) - 1) : line;
  };
  auto levelled = level_gcode({program.file, std::move(moved.text)}, stored.map, levelling);
  if (!levelled) {
    Diagnostic diagnostic = levelled.error();
    diagnostic.place.line = source_line(diagnostic.place.line);
    return failure(std::move(diagnostic));
  }
  levelled->figures.line_of_largest_sigma = source_line(levelled->figures.line_of_largest_sigma);
  out.words += surface::level_text(levelled->figures);
  out.text = std::move(levelled->text);
  return out;
}

/// Writes it where the command line wants it.
Expected<Answer> put(Applied applied, const ApplyOptions& options, CommandContext& context) {
  context.console.say(applied.words);
  const auto& limit_um = options.surface.max_sigma_um;
  if (limit_um && applied.largest_sigma > um(*limit_um)) {
    context.console.print(
        Diagnostic{Code::ToleranceHold,
                   {options.program, applied.line_of_largest_sigma, 1},
                   fmt::format("the predicted sigma of the place here is {:.2f} um",
                               applied.largest_sigma.in_um()),
                   fmt::format("at most {:g} um (--max-sigma-um)", *limit_um)});
    return Answer{{}, ExitCode::GateFailed};
  }
  Program none;
  Provenance provenance =
      provenance_of(context.options,
                    none,
                    {options.program, options.machine, options.align, options.surface.map});
  std::erase_if(provenance, [](const auto& row) { return row.first == "sha256 "; });
  std::string text = surface::with_provenance(std::move(applied.text), kMovedBy, provenance);
  if (options.output == "-") return Answer{std::move(text), ExitCode::Done};
  PANELCAL_CHECK(write_file(options.output, text));
  return Answer{};
}

bool is_gcode(const SourceText& program) {
  return extension_of(program.file) == ".ngc" || gcode::line_of_gcode(program.bytes).has_value();
}

}  // namespace

Expected<Answer> apply(const ApplyOptions& options, CommandContext& context) {
  PANELCAL_TRY(const MachineConfig machine, read_machine_config(options.machine));
  PANELCAL_TRY(const AlignedPanel panel, panel_in_force(options, machine));
  PANELCAL_TRY(const SourceText program, read_source(options.program));
  PANELCAL_TRY(Applied applied, apply_to(program, options, machine, panel, {}));
  return put(std::move(applied), options, context);
}

/// Source LinuxCNC, Filter Programs: a line FILTER_PROGRESS=# on standard error moves the bar of a
///        control's screen that has set AXIS_PROGRESS_BAR
Expected<Answer> filter(const ApplyOptions& options, CommandContext& context) {
  const bool has_bar = std::getenv("AXIS_PROGRESS_BAR") != nullptr;
  const auto progress = [&](double share) {
    if (!has_bar) return;
    context.console.say(fmt::format("FILTER_PROGRESS={}", static_cast<int>(100 * share)));
  };
  progress(0);
  PANELCAL_TRY(const MachineConfig machine, read_machine_config(options.machine));
  const Expected<AlignedPanel> panel = panel_in_force(options, machine);
  if (!panel) {
    context.console.print(panel.error());
    return Answer{{}, ExitCode::GateFailed};
  }
  PANELCAL_TRY(const SourceText program, read_source(options.program));
  Expected<Answer> answer;
  if (is_gcode(program)) {
    PANELCAL_TRY(Applied applied, apply_to(program, options, machine, *panel, progress));
    answer = put(std::move(applied), options, context);
  } else if (options.surface.max_sigma_um) {
    return failure({Code::Usage,
                    {options.program, 0, 0},
                    "--max-sigma-um is of G-code, and this is a program to drill or rout",
                    "[tolerance] in machine.toml, which such a program is held against"});
  } else {
    answer = run_command(RunOptions{.program = options.program,
                                    .machine = options.machine,
                                    .surface = options.surface.map,
                                    .align = options.align,
                                    .valid_hours = options.valid_hours,
                                    .output = "-",
                                    .format = "gcode"},
                         context);
  }
  progress(1);
  return answer;
}

}  // namespace panelcal::align
