// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "surface/map/file.h"
#include "tools/surface/commands/subcommand.h"
#include "tools/surface/levelling.h"
#include "tools/surface/made_facts.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

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
  Answer answer = state_facts(context, options.facts, {}, document, {level_text(figures)});
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
  std::string text = with_provenance(levelled.text, kLevelledBy, provenance);
  if (options.output != "-") {
    PANELCAL_CHECK(write_file(options.output, text));
    return answer;
  }
  context.console.say(answer.text);
  answer.text = std::move(text);
  return answer;
}

}  // namespace panelcal::surface
