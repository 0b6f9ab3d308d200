// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "program/gcode/leveller.h"
#include "program/gcode/motion.h"
#include "program/gcode/mover.h"

namespace panelcal::fuzz {

/// A board of 100 mm that leans and bulges, probed at 36 places.
inline const HeightMap& bent_map() {
  static const HeightMap kMap = [] {
    std::vector<ProbePoint> points;
    for (int j = 0; j < 6; ++j) {
      for (int i = 0; i < 6; ++i) {
        const Eigen::Vector2d p_mm(20 * i, 20 * j);
        const double z_mm = 0.05 * std::sin(p_mm.x() / 25) + 1e-3 * p_mm.y();
        points.push_back({position_mm<frame::Nominal>(p_mm), {mm(z_mm), um(2)}, "", {}});
      }
    }
    return *HeightMap::of_probes(points);
  }();
  return kMap;
}

/// End of a program, as far as it can be followed.
inline gcode::Standing end_of(std::string_view text) {
  gcode::MotionReader reader("fuzz.ngc");
  gcode::Standing end;
  LineCursor cursor(text);
  while (!cursor.at_end()) {
    const auto block = gcode::read_gcode_block(cursor.next(), "fuzz.ngc");
    if (!block) return end;
    const auto motion = reader.read(*block);
    if (!motion) return end;
    if (!*motion) continue;
    end = (*motion)->to;
    if ((*motion)->kind == gcode::MotionKind::Cycle) end.z_mm = (*motion)->travel_mm;
  }
  return end;
}

/// The same but for rounding.
inline bool is_near(const std::optional<double>& a_mm, const std::optional<double>& b_mm) {
  if (!a_mm || !b_mm) return a_mm == b_mm;
  return std::abs(*a_mm - *b_mm) <= 1e-3 + 1e-9 * std::abs(*a_mm);
}

/// A board that is turned, stretched and bent a little.
class CrookedPlaces final : public BoardPlaces {
 public:
  Eigen::Vector2d actual_mm(const Eigen::Vector2d& p_mm) const override {
    const double x_mm = 1.001 * p_mm.x() + 1e-3 * p_mm.y();
    const double bend_mm = 0.05 * std::sin(p_mm.x() / 40);
    return {50 + 0.8 * x_mm - 0.6 * p_mm.y(), 0.6 * x_mm + 0.8 * p_mm.y() + bend_mm};
  }
  Expected<Length> sigma(const Eigen::Vector2d&) const override { return um(3); }
};

/// Moves any bytes as a G-code program, in X and Y.
///
/// Out    as run_gcode()
inline std::optional<std::string> run_moved_gcode(std::string_view bytes) {
  const auto done = move_gcode({"fuzz.ngc", std::string(bytes)}, CrookedPlaces());
  if (!done) {
    return done.error().text().empty() ? std::optional<std::string>("an empty message")
                                       : std::nullopt;
  }
  const auto n_lines = static_cast<std::size_t>(std::ranges::count(done->text, '\n'));
  if (n_lines != done->source_lines.size()) return "lines that no line was made of";
  gcode::MotionReader reader("moved.ngc");
  LineCursor cursor(done->text);
  std::int64_t n_moves = 0;
  bool has_shift = false;  // of the zero, which this reader does not follow
  while (!cursor.at_end() && !reader.has_ended() && !has_shift) {
    const auto block = gcode::read_gcode_block(cursor.next(), "moved.ngc");
    if (!block) return "a line that cannot be read again: " + block.error().text();
    has_shift = std::ranges::any_of(block->words, [](const gcode::GcodeWord& word) {
      return word.is('G', 52) || (word.letter == 'G' && word.value >= 92 && word.value < 93);
    });
    if (has_shift) break;
    const auto motion = reader.read(*block);
    if (!motion) return "a move that cannot be followed again: " + motion.error().text();
    n_moves += *motion ? 1 : 0;
  }
  const MoveFigures& figures = done->figures;
  if (!has_shift && n_moves != figures.n_moves - figures.n_moved + figures.n_pieces) {
    return "moves were lost or added";
  }
  return std::nullopt;
}

/// Moves and levels any bytes as a G-code program.
///
/// Out    what is wrong with panelcal, never with the program; empty if all is well
inline std::optional<std::string> run_gcode(std::string_view bytes) {
  if (const auto complaint = run_moved_gcode(bytes)) return "moved: " + *complaint;
  const SourceText program{"fuzz.ngc", std::string(bytes)};
  const auto done = level_gcode(program, bent_map());
  if (!done) {
    return done.error().text().empty() ? std::optional<std::string>("an empty message")
                                       : std::nullopt;
  }
  // The written program can be followed, and moves in the same way.
  gcode::MotionReader reader("levelled.ngc");
  LineCursor cursor(done->text);
  std::int64_t n_moves = 0;
  while (!cursor.at_end() && !reader.has_ended()) {
    const auto block = gcode::read_gcode_block(cursor.next(), "levelled.ngc");
    if (!block) return "a line that cannot be read again: " + block.error().text();
    const auto motion = reader.read(*block);
    if (!motion) return "a move that cannot be followed again: " + motion.error().text();
    if (!*motion) continue;
    ++n_moves;
    const auto& z_mm = (*motion)->to.z_mm;
    if (z_mm && !std::isfinite(*z_mm)) return "a Z that is not finite";
  }
  const LevelFigures& figures = done->figures;
  if (n_moves != figures.n_moves - figures.n_levelled + figures.n_pieces) {
    return "moves were lost or added";
  }
  const gcode::Standing before = end_of(bytes), after = end_of(done->text);
  if (!is_near(before.x_mm, after.x_mm) || !is_near(before.y_mm, after.y_mm)) {
    return "it ends at another place";
  }
  const bool is_up = before.z_mm && *before.z_mm >= figures.safe_height.in_mm();
  if (is_up && !is_near(before.z_mm, after.z_mm)) return "it ends at another height";
  return std::nullopt;
}

}  // namespace panelcal::fuzz
