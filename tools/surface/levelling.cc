// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/levelling.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace panelcal::surface {

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

std::string level_text(const LevelFigures& figures) {
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

std::string with_provenance(std::string text, std::string_view mark, const Provenance& provenance) {
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
      remarks += fmt::format("{}: {})\n", mark, words.substr(0, kMaxCharacters));
      words.erase(0, kMaxCharacters);
    } while (!words.empty());
  }
  const bool has_percent = text.starts_with('%');
  text.insert(has_percent ? text.find('\n') + 1 : 0, remarks);
  return text;
}

}  // namespace panelcal::surface
