// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/gcode/gcode_leveller.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "panelcal/program/gcode/gcode_block.h"
#include "panelcal/program/gcode/gcode_motion.h"
#include "panelcal/surface/way_cuts.h"

namespace panelcal {
namespace {

using gcode::GcodeBlock;
using gcode::GcodeWord;
using gcode::Motion;
using gcode::MotionKind;
using gcode::MotionReader;

constexpr std::string_view kCoordinates = "XYZIJKR";
/// These come after the move of their line.
constexpr std::array kAfterMove = {0.0, 1.0, 2.0, 30.0, 60.0};
constexpr double kSamplesPerCell = 4;

/// Calls visit(block, move) for every line of the program, up to where it ends; move is absent for
/// lines that make none. Returns where the program ended.
template <class Visit>
Expected<LinePlace> for_each_block(const SourceText& program, MotionReader& reader, Visit visit) {
  LineCursor cursor(program.bytes);
  while (!cursor.at_end() && !reader.has_ended()) {
    PANELCAL_TRY(const GcodeBlock block, gcode::read_gcode_block(cursor.next(), program.file));
    PANELCAL_TRY(const auto motion, reader.read(block));
    PANELCAL_CHECK(visit(block, motion));
  }
  return cursor.place();
}

/// The lowest Z above the board at which the program moves rapidly in X or Y.
Expected<Length> travel_height(const SourceText& program, Length board) {
  std::optional<double> lowest_mm;
  MotionReader reader(program.file);
  const auto visit = [&](const GcodeBlock&, const std::optional<Motion>& motion) {
    if (!motion || motion->kind != MotionKind::Rapid || !motion->to.z_mm) return Expected<void>();
    const gcode::Standing &from = motion->from, &to = motion->to;
    const bool goes = from.x_mm != to.x_mm || from.y_mm != to.y_mm;
    if (goes && *to.z_mm > board.in_mm()) {
      lowest_mm = std::min(lowest_mm.value_or(*to.z_mm), *to.z_mm);
    }
    return Expected<void>();
  };
  if (const auto done = for_each_block(program, reader, visit); !done) {
    return failure(done.error());
  }
  if (lowest_mm) return mm(*lowest_mm);
  return failure(
      {Code::ArgumentInvalid,
       {program.file, 0, 0},
       fmt::format("the program never moves rapidly above the board, whose highest place "
                   "is at {:.3f} mm",
                   board.in_mm()),
       "a safe height (--safe-mm Z)"});
}

Eigen::Vector2d place_mm(const Motion& motion, double t) {
  const Eigen::Vector2d from_mm = motion.from.xy_mm(), to_mm = motion.to.xy_mm();
  if (t == 1) return to_mm;
  if (!motion.is_arc()) return from_mm + t * (to_mm - from_mm);
  const Eigen::Vector2d begin_mm = from_mm - motion.center_mm;
  const double angle_rad = std::atan2(begin_mm.y(), begin_mm.x()) + t * motion.sweep_rad;
  // The radii at both ends may differ by what the control forgives.
  const double radius_mm =
      begin_mm.norm() + t * ((to_mm - motion.center_mm).norm() - begin_mm.norm());
  return motion.center_mm + radius_mm * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
}

double length_mm(const Motion& motion) {
  if (motion.is_arc()) {
    return std::abs(motion.sweep_rad) * (motion.from.xy_mm() - motion.center_mm).norm();
  }
  return (motion.to.xy_mm() - motion.from.xy_mm()).norm();
}

class Leveller {
 public:
  Leveller(const SourceText& program, const HeightMap& map, const LevelOptions& options)
      : program_(program), map_(map), options_(options), reader_(program.file) {}

  Expected<LevelledGcode> level() {
    PANELCAL_CHECK(prepare());
    PANELCAL_TRY(
        const LinePlace end,
        for_each_block(program_,
                       reader_,
                       [this](const GcodeBlock& block, const std::optional<Motion>& motion) {
                         return put(block, motion);
                       }));
    out_ += program_.bytes.substr(std::min(end.offset, program_.bytes.size()));
    return LevelledGcode{std::move(out_), figures_};
  }

 private:
  Expected<void> prepare() {
    if (!(options_.height_tolerance > Length())) {
      return failure({Code::ArgumentInvalid, {}, "a height tolerance of 0 or less", "one above 0"});
    }
    if (options_.zero) {
      PANELCAL_TRY(const HeightAt zero, map_.height_at(*options_.zero));
      zero_mm_ = zero.height.in_mm();
    }
    if (options_.safe_height) {
      figures_.safe_height = *options_.safe_height;
    } else {
      PANELCAL_TRY(figures_.safe_height, travel_height(program_, highest_place()));
    }
    return {};
  }

  Length highest_place() const {
    const HeightLattice& lattice = map_.lattice();
    double highest_mm = -std::numeric_limits<double>::infinity();
    for (int j = 0; j < lattice.y().n_nodes; ++j) {
      for (int i = 0; i < lattice.x().n_nodes; ++i) {
        const Eigen::Vector2d node_mm(lattice.x().at_mm(i), lattice.y().at_mm(j));
        highest_mm = std::max(highest_mm, lattice.height_mm(node_mm));
      }
    }
    return mm(highest_mm - zero_mm_);
  }

  bool is_below(const std::optional<double>& z_mm) const {
    return z_mm && *z_mm < figures_.safe_height.in_mm();
  }

  Expected<void> put(const GcodeBlock& block, const std::optional<Motion>& motion) {
    if (motion) ++figures_.n_moves;
    const bool levels = motion && (is_below(motion->from.z_mm) || is_below(motion->to.z_mm));
    if (motion && !motion->to.z_mm && motion->kind != MotionKind::Rapid) {
      return failure(problem(
          block, Code::CoordinateMissing, "a move at nobody knows what height", "Z before it"));
    }
    if (!levels) {
      out_ += block.text;
      out_ += '\n';
      return {};
    }
    ++figures_.n_levelled;
    return motion->kind == MotionKind::Cycle ? put_cycle(block, *motion) : put_way(block, *motion);
  }

  Diagnostic problem(const GcodeBlock& block,
                     Code code,
                     std::string what,
                     std::string expected) const {
    return {code, {program_.file, block.line, 1}, std::move(what), std::move(expected)};
  }

  /// What is added to Z at an end of a move.
  Expected<double> shift_mm(const GcodeBlock& block, const gcode::Standing& end) {
    if (!is_below(end.z_mm)) return 0;
    if (!end.has_xy()) {
      return failure(problem(block,
                             Code::CoordinateMissing,
                             "a move below the safe height, and nobody knows where in X and Y",
                             "X and Y before it"));
    }
    auto found = map_.height_at(position_mm<frame::Nominal>(end.xy_mm()));
    if (!found) return failure(placed(found.error(), block));
    if (found->sigma > figures_.largest_sigma) {
      figures_.largest_sigma = found->sigma;
      figures_.line_of_largest_sigma = block.line;
    }
    if (found->source == HeightSource::Filled) ++figures_.n_ends_filled;
    if (found->source == HeightSource::Extrapolated) ++figures_.n_ends_extrapolated;
    return counted(block, found->height.in_mm() - zero_mm_);
  }

  /// The safe height has to be safe: the board must not reach it.
  Expected<double> counted(const GcodeBlock& block, double shift_mm) {
    if (!(shift_mm < figures_.safe_height.in_mm())) {
      return failure(problem(
          block,
          Code::ArgumentInvalid,
          fmt::format("the board is {:.3f} mm high here, and the program's safe height {:.3f} mm",
                      shift_mm,
                      figures_.safe_height.in_mm()),
          "a safe height above the board"));
    }
    figures_.lowest = has_shifted_ ? std::min(figures_.lowest, mm(shift_mm)) : mm(shift_mm);
    figures_.highest = has_shifted_ ? std::max(figures_.highest, mm(shift_mm)) : mm(shift_mm);
    has_shifted_ = true;
    return shift_mm;
  }

  Diagnostic placed(Diagnostic diagnostic, const GcodeBlock& block) const {
    diagnostic.place = {program_.file, block.line, 1};
    return diagnostic;
  }

  // --- writing ---------------------------------------------------------------------------------

  void put_number(char letter, double value_mm) {
    const int decimals = reader_.unit_mm() == 1 ? 4 : 6;
    std::string text = fmt::format("{:.{}f}", value_mm / reader_.unit_mm(), decimals);
    while (text.back() == '0') text.pop_back();
    if (text.back() == '.') text.pop_back();
    line_ += fmt::format(" {}{}", letter, text == "-0" ? "0" : text);
  }

  /// The words that are no coordinates: those before a move, or those after it and comments.
  void put_others(const GcodeBlock& block, bool after) {
    for (const GcodeWord& word : block.words) {
      const bool is_after =
          word.letter == 'M' && std::ranges::find(kAfterMove, word.value) != kAfterMove.end();
      const bool is_coordinate = kCoordinates.find(word.letter) != std::string_view::npos;
      if (is_coordinate || is_after != after) continue;
      if (!line_.empty()) line_ += ' ';
      line_ += block.text.substr(word.begin, word.end - word.begin);
    }
    if (after && !block.rest.empty()) line_ += " " + block.rest;
  }

  Expected<void> put_cycle(const GcodeBlock& block, const Motion& motion) {
    PANELCAL_TRY(const double added_mm, shift_mm(block, motion.to));
    // Between holes the tool goes at R, or where it was before the cycle.
    const double travel_mm = motion.returns_to_r || !motion.from.z_mm
                                 ? motion.retract_mm
                                 : std::max(*motion.from.z_mm, motion.retract_mm);
    if (travel_mm < figures_.safe_height.in_mm()) {
      return failure(problem(
          block,
          Code::NotSupported,
          fmt::format(
              "a drilling cycle that moves on at {:.3f} mm, below the safe height of {:.3f} mm",
              travel_mm,
              figures_.safe_height.in_mm()),
          "G98 after a move to the safe height, or a safe height of R or less"));
    }
    put_others(block, false);
    if (block.has('X')) put_number('X', *motion.to.x_mm);
    if (block.has('Y')) put_number('Y', *motion.to.y_mm);
    put_number('Z', *motion.to.z_mm + added_mm);
    const bool r_is_safe = !is_below(motion.retract_mm);
    put_number('R', motion.retract_mm + (r_is_safe ? 0 : added_mm));
    put_others(block, true);
    end_line();
    ++figures_.n_pieces;
    return {};
  }

  /// A ramp through the safe height is cut nowhere: it has not reached the board yet.
  Expected<void> put_way(const GcodeBlock& block, const Motion& motion) {
    PANELCAL_TRY(const double to_shift_mm, shift_mm(block, motion.to));
    const bool stays_below = is_below(motion.from.z_mm) && is_below(motion.to.z_mm);
    const bool goes = motion.from.has_xy() && motion.to.has_xy() && length_mm(motion) > 0;
    std::vector<double> ends;
    if (stays_below && goes) {
      PANELCAL_TRY(ends, cuts(block, motion));
    }
    ends.push_back(1);
    double begin = 0;
    for (const double end : ends) {
      put_piece(block, motion, {begin, end, ends.size() > 1}, to_shift_mm);
      begin = end;
    }
    figures_.n_pieces += static_cast<std::int64_t>(ends.size());
    return {};
  }

  Expected<std::vector<double>> cuts(const GcodeBlock& block, const Motion& motion) {
    const double cell_mm = std::min(map_.lattice().x().step_mm, map_.lattice().y().step_mm);
    const double n_cells = length_mm(motion) / cell_mm;
    const auto least = static_cast<std::size_t>(std::clamp(
        std::ceil(kSamplesPerCell * n_cells), 4.0, static_cast<double>(kMostWaySamples)));
    auto found = way_cuts([&](std::size_t n) { return profile_mm(block, motion, n); },
                          least,
                          options_.height_tolerance);
    if (!found) return failure(placed(found.error(), block));
    return found;
  }

  Expected<std::vector<double>> profile_mm(const GcodeBlock& block,
                                           const Motion& motion,
                                           std::size_t n) {
    places_mm_.clear();
    for (std::size_t i = 0; i <= n; ++i) {
      places_mm_.push_back(place_mm(motion, static_cast<double>(i) / static_cast<double>(n)));
    }
    std::vector<double> heights_mm(n + 1);
    PANELCAL_CHECK(map_.heights_at(places_mm_, heights_mm));
    const auto [lowest, highest] = std::ranges::minmax(heights_mm);
    PANELCAL_CHECK(counted(block, lowest - zero_mm_));
    PANELCAL_CHECK(counted(block, highest - zero_mm_));
    return heights_mm;
  }

  double z_mm(const Motion& motion, double t, double to_shift_mm) const {
    if (t == 1) return *motion.to.z_mm + to_shift_mm;
    const double height_mm = map_.lattice().height_mm(place_mm(motion, t)) - zero_mm_;
    return *motion.from.z_mm + t * (*motion.to.z_mm - *motion.from.z_mm) + height_mm;
  }

  /// A stretch of a move, by its parameter.
  struct Piece {
    double begin = 0;
    double end = 1;
    bool is_cut = false;  ///< the move has more of them
  };

  void put_piece(const GcodeBlock& block,
                 const Motion& motion,
                 const Piece& piece,
                 double to_shift_mm) {
    if (piece.begin == 0) {
      put_others(block, false);
    } else {
      line_ += motion.kind == MotionKind::Rapid       ? "G0"
               : motion.kind == MotionKind::Line      ? "G1"
               : motion.kind == MotionKind::Clockwise ? "G2"
                                                      : "G3";
    }
    if (motion.to.has_xy()) {
      const Eigen::Vector2d to_mm = place_mm(motion, piece.end);
      if (piece.is_cut || block.has('X')) put_number('X', to_mm.x());
      if (piece.is_cut || block.has('Y')) put_number('Y', to_mm.y());
    } else {
      if (block.has('X')) put_number('X', *motion.to.x_mm);
      if (block.has('Y')) put_number('Y', *motion.to.y_mm);
    }
    put_number('Z', z_mm(motion, piece.end, to_shift_mm));
    if (motion.is_arc()) {
      const Eigen::Vector2d from_mm = place_mm(motion, piece.begin);
      const Eigen::Vector2d origin_mm =
          reader_.arcs_are_absolute() ? Eigen::Vector2d(Eigen::Vector2d::Zero()) : from_mm;
      put_number('I', motion.center_mm.x() - origin_mm.x());
      put_number('J', motion.center_mm.y() - origin_mm.y());
    }
    if (piece.end == 1) put_others(block, true);
    end_line();
  }

  void end_line() {
    out_ += std::string_view(line_).substr(line_.starts_with(' ') ? 1 : 0);
    out_ += '\n';
    line_.clear();
  }

  const SourceText& program_;
  const HeightMap& map_;
  const LevelOptions& options_;
  MotionReader reader_;
  double zero_mm_ = 0;
  std::vector<Eigen::Vector2d> places_mm_;
  std::string line_;  ///< that is being written
  std::string out_;
  bool has_shifted_ = false;
  LevelFigures figures_;
};

}  // namespace

Expected<LevelledGcode> level_gcode(const SourceText& program,
                                    const HeightMap& map,
                                    const LevelOptions& options) {
  return Leveller(program, map, options).level();
}

}  // namespace panelcal
