// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "program/gcode/leveller.h"
#include "surface/map/file.h"
#include "tools/surface/commands/subcommand.h"
#include "tools/surface/made_facts.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

LevelOptions level_options(const SurfaceOptions& options) {
  LevelOptions out;
  out.height_tolerance = um(options.height_tolerance_um);
  if (options.safe_mm) out.safe_height = mm(*options.safe_mm);
  if (options.zero_mm.size() == 2) {
    out.zero = position_mm<frame::Nominal>(options.zero_mm[0], options.zero_mm[1]);
  }
  if (options.gcode_unit == "mm") out.unit_mm = 1;
  if (options.gcode_unit == "inch") out.unit_mm = inch(1).in_mm();
  return out;
}

std::string figures_text(const LevelFigures& figures) {
  std::string out = fmt::format(
      "levelled {} of {} moves into {} pieces; Z {:+.4f} to {:+.4f} mm\n"
      "safe height {:.3f} mm; the board is up to {:.3f} mm high\n",
      figures.n_levelled,
      figures.n_moves,
      figures.n_pieces,
      figures.lowest.in_mm(),
      figures.highest.in_mm(),
      figures.safe_height.in_mm(),
      figures.board.in_mm());
  if (figures.n_levelled > 0) {
    out += fmt::format("largest sigma of the surface {:.2f} um, in line {}\n",
                       figures.largest_sigma.in_um(),
                       figures.line_of_largest_sigma);
  }
  if (figures.n_filled > 0) {
    out += fmt::format("{} moves go over places where a probe is missing\n", figures.n_filled);
  }
  if (figures.n_extrapolated > 0) {
    out += fmt::format("{} moves go outside of the probes\n", figures.n_extrapolated);
  }
  if (figures.n_over_voids > 0) {
    out += fmt::format("{} moves go over voids, at the height predicted there\n",
                       figures.n_over_voids);
  }
  return out;
}

facts::Json level_facts(const LevelFigures& figures, const Provenance& provenance) {
  facts::Json out = surface_envelope("apply");
  out.update({{"moves", figures.n_moves},
              {"levelled", figures.n_levelled},
              {"pieces", figures.n_pieces},
              {"lowest_mm", figures.lowest.in_mm()},
              {"highest_mm", figures.highest.in_mm()},
              {"safe_height_mm", figures.safe_height.in_mm()},
              {"board_mm", figures.board.in_mm()},
              {"largest_sigma_um", figures.largest_sigma.in_um()},
              {"largest_sigma_line", figures.line_of_largest_sigma},
              {"filled", figures.n_filled},
              {"extrapolated", figures.n_extrapolated},
              {"over_voids", figures.n_over_voids},
              {"provenance", provenance_facts(provenance)}});
  return out;
}

constexpr std::string_view kLevelledBy = "(levelled by panelcal";

/// Comments that say what made it, in front of the program, but behind a % that has to be first.
std::string with_provenance(std::string text, const Provenance& provenance) {
  std::string remarks;
  for (const auto& [key, value] : provenance) {
    std::string words = key + ": " + value;
    std::ranges::replace(words, '(', '[');
    std::ranges::replace(words, ')', ']');
    std::ranges::replace_if(
        words, [](char c) { return c == '\n' || c == '\r'; }, ' ');
    // LinuxCNC reads lines of 252 characters.
    constexpr std::size_t kMaxCharacters = 200;
    do {
      remarks += fmt::format("{}: {})\n", kLevelledBy, words.substr(0, kMaxCharacters));
      words.erase(0, kMaxCharacters);
    } while (!words.empty());
  }
  const bool has_percent = text.starts_with('%');
  text.insert(has_percent ? text.find('\n') + 1 : 0, remarks);
  return text;
}

}  // namespace

Expected<Answer> apply(const SurfaceOptions& options, CommandContext& context) {
  PANELCAL_TRY(const StoredZones stored, read_zoned_map_file(options.map));
  PANELCAL_TRY(const SourceText program, read_source(options.gcode));
  if (program.bytes.find(kLevelledBy) != std::string::npos) {
    return failure({Code::ArgumentInvalid,
                    {options.gcode, 0, 0},
                    "a program that was levelled before",
                    "the one that it was made of"});
  }
  PANELCAL_TRY(const LevelledGcode levelled,
               level_gcode(program, stored.map, level_options(options)));
  const LevelFigures& figures = levelled.figures;
  const std::vector<std::string> inputs = {options.map, options.gcode};
  const Provenance provenance = provenance_of(context, inputs);
  const auto document = [&] { return facts::text(level_facts(figures, provenance)); };
  Answer answer = state_facts(context, options.facts, {}, document, {figures_text(figures)});
  if (answer.code != ExitCode::Done) return Answer{{}, answer.code};
  if (options.max_sigma_um && figures.largest_sigma > um(*options.max_sigma_um)) {
    context.console.print(
        Diagnostic{Code::ToleranceHold,
                   {options.gcode, figures.line_of_largest_sigma, 1},
                   fmt::format("the sigma of the map's height here is {:.2f} um",
                               figures.largest_sigma.in_um()),
                   fmt::format("at most {:g} um (--max-sigma-um)", *options.max_sigma_um)});
    answer.code = ExitCode::GateFailed;
    return answer;
  }
  std::string text = with_provenance(levelled.text, provenance);
  if (options.output != "-") {
    PANELCAL_CHECK(write_file(options.output, text));
    return answer;
  }
  context.console.say(answer.text);
  answer.text = std::move(text);
  return answer;
}

}  // namespace panelcal::surface
