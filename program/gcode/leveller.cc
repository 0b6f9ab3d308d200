// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/leveller.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "program/gcode/block.h"
#include "program/gcode/lines.h"
#include "program/gcode/motion.h"
#include "surface/map/way_cuts.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using gcode::Counting;
using gcode::GcodeBlock;
using gcode::GcodeLines;
using gcode::Motion;
using gcode::MotionKind;
using gcode::MotionReader;
using gcode::Standing;

/// Over so much of an arc the tool goes from the surface to the safe height or back.
constexpr double kLeastArc_mm = 0.01;

/// Calls visit(block, move) for every line; move is absent for lines that make none.
template <class Visit>
Expected<void> for_each_block(const SourceText& program, MotionReader& reader, Visit visit) {
  LineCursor cursor(program.bytes);
  while (!cursor.at_end()) {
    PANELCAL_TRY(const GcodeBlock block, gcode::read_gcode_block(cursor.next(), program.file));
    PANELCAL_TRY(const auto motion, reader.read(block));
    PANELCAL_CHECK(visit(block, motion));
  }
  return {};
}

/// The lowest Z above the board at which the program travels.
Expected<Length> travel_height(const SourceText& program,
                               const std::optional<double>& unit_mm,
                               Length board) {
  std::optional<double> of_travel_mm, of_any_mm;
  const auto lower = [&](std::optional<double>& lowest_mm, double z_mm) {
    if (z_mm > board.in_mm()) lowest_mm = std::min(lowest_mm.value_or(z_mm), z_mm);
  };
  MotionReader reader(program.file, unit_mm);
  const auto visit = [&](const GcodeBlock&, const std::optional<Motion>& motion) {
    if (!motion || !motion->goes() || !motion->to.z_mm) return Expected<void>();
    const bool is_cycle = motion->kind == MotionKind::Cycle;
    const double z_mm = is_cycle ? motion->travel_mm : *motion->to.z_mm;
    lower(of_any_mm, z_mm);
    if (is_cycle || motion->kind == MotionKind::Rapid) lower(of_travel_mm, z_mm);
    return Expected<void>();
  };
  PANELCAL_CHECK(for_each_block(program, reader, visit));
  if (of_travel_mm) return mm(*of_travel_mm);
  if (of_any_mm) return mm(*of_any_mm);
  return failure({Code::ArgumentInvalid,
                  {program.file, 0, 0},
                  fmt::format("the program never moves in X or Y above the board, whose highest "
                              "place is at {:.3f} mm",
                              board.in_mm()),
                  "a safe height (--safe-mm Z)"});
}

class Leveller {
 public:
  Leveller(const SourceText& program, const ZonedMap& map, const LevelOptions& options)
      : program_(program), map_(map), options_(options), reader_(program.file, options.unit_mm) {}

  Expected<LevelledGcode> level() {
    PANELCAL_CHECK(prepare());
    PANELCAL_CHECK(for_each_block(
        program_, reader_, [this](const GcodeBlock& block, const std::optional<Motion>& motion) {
          return put(block, motion);
        }));
    return LevelledGcode{lines_.take(), figures_};
  }

 private:
  /// Part of a move's way, and whether the tool follows the surface there and at its end.
  struct Stretch {
    double begin = 0;
    double end = 1;
    bool follows = true;
    bool ends_on_surface = true;
  };

  Expected<void> prepare() {
    if (!(options_.height_tolerance > Length())) {
      return failure({Code::ArgumentInvalid,
                      {program_.file, 0, 0},
                      "a height tolerance of 0 or less",
                      "one above 0"});
    }
    if (options_.zero) {
      PANELCAL_TRY(const ZonedHeight zero, map_.height_at(*options_.zero));
      zero_mm_ = zero.height.height.in_mm();
    }
    const Range range = heights();
    PANELCAL_CHECK(check_zero(range));
    figures_.board = mm(range.highest_mm - zero_mm_);
    if (!options_.safe_height) {
      PANELCAL_TRY(figures_.safe_height, travel_height(program_, options_.unit_mm, figures_.board));
      return {};
    }
    figures_.safe_height = *options_.safe_height;
    if (figures_.safe_height > figures_.board) return {};
    return failure({Code::ArgumentInvalid,
                    {program_.file, 0, 0},
                    fmt::format("a safe height of {:.3f} mm, which the board reaches: it is up to "
                                "{:.3f} mm high",
                                figures_.safe_height.in_mm(),
                                figures_.board.in_mm()),
                    "a higher one"});
  }

  struct Range {
    double lowest_mm = std::numeric_limits<double>::infinity();
    double highest_mm = -std::numeric_limits<double>::infinity();
  };

  /// With three sigmas, in all cells that the probes' hulls reach: they end between nodes.
  Range heights() const {
    Range range;
    for (const HeightMap& map : map_.maps()) widen(range, map);
    return range;
  }

  static void widen(Range& range, const HeightMap& map) {
    const HeightLattice& lattice = map.lattice();
    const int n_x = lattice.x().n_nodes, n_y = lattice.y().n_nodes;
    const auto place = [&](int i, int j) {
      return position_mm<frame::Nominal>(lattice.x().at_mm(i), lattice.y().at_mm(j));
    };
    for (int j = 0; j < n_y; ++j) {
      for (int i = 0; i < n_x; ++i) {
        const auto found = map.height_at(place(i, j));
        if (!found || found->outside > Length()) continue;
        for (int k = 0; k < 9; ++k) {
          const int to_i = std::clamp(i + k % 3 - 1, 0, n_x - 1);
          const int to_j = std::clamp(j + k / 3 - 1, 0, n_y - 1);
          const double height_mm = lattice.height_mm(place(to_i, to_j).in_mm());
          range.lowest_mm = std::min(range.lowest_mm, height_mm - 3 * found->sigma.in_mm());
          range.highest_mm = std::max(range.highest_mm, height_mm + 3 * found->sigma.in_mm());
        }
      }
    }
  }

  /// A map of heights above the table would lift the tool by the board's thickness.
  Expected<void> check_zero(const Range& range) const {
    constexpr double kOff_mm = 1;
    if (options_.zero || (range.lowest_mm < kOff_mm && range.highest_mm > -kOff_mm)) return {};
    return failure({Code::ArgumentInvalid,
                    {program_.file, 0, 0},
                    fmt::format("the map's heights are {:.3f} to {:.3f} mm, so its 0 is not where "
                                "the tool touches the board",
                                range.lowest_mm,
                                range.highest_mm),
                    "where Z was set to 0 (--zero X,Y)"});
  }

  double safe_mm() const { return figures_.safe_height.in_mm(); }
  bool is_below(const std::optional<double>& z_mm) const { return z_mm && *z_mm < safe_mm(); }

  Diagnostic problem(const GcodeBlock& block,
                     Code code,
                     std::string what,
                     std::string expected) const {
    return {code, {program_.file, block.line, 1}, std::move(what), std::move(expected)};
  }

  Diagnostic placed(Diagnostic diagnostic, const GcodeBlock& block) const {
    diagnostic.place = {program_.file, block.line, 1};
    return diagnostic;
  }

  Expected<void> put(const GcodeBlock& block, const std::optional<Motion>& motion) {
    lines_.put_unstated(reader_.take_unstated(block, motion));
    if (!motion) {
      lines_.put(block);
      return {};
    }
    ++figures_.n_moves;
    const bool is_cycle = motion->kind == MotionKind::Cycle;
    if (is_cycle && reader_.counting().is_incremental) {
      return failure(problem(block, Code::NotSupported, "a cycle in G91", "G90 before it"));
    }
    const Standing end = {motion->to.x_mm,
                          motion->to.y_mm,
                          is_cycle ? std::optional(motion->travel_mm) : motion->to.z_mm};
    if (!motion->to.z_mm && motion->kind != MotionKind::Rapid) {
      return failure(problem(block,
                             Code::CoordinateMissing,
                             "move before the first Z: height unknown",
                             "Z before it"));
    }
    if (!is_below(motion->from.z_mm) && !is_below(motion->to.z_mm)) {
      lines_.put(block);
      reader_.counting().is_incremental ? lines_.step(*motion) : lines_.stand_at(end);
      return {};
    }
    ++figures_.n_levelled;
    is_filled_ = is_extrapolated_ = is_over_void_ = false;
    PANELCAL_CHECK(is_cycle ? put_cycle(block, *motion) : put_way(block, *motion));
    if (is_cycle) lines_.stand_at(end);
    figures_.n_filled += is_filled_ ? 1 : 0;
    figures_.n_extrapolated += is_extrapolated_ ? 1 : 0;
    figures_.n_over_voids += is_over_void_ ? 1 : 0;
    return {};
  }

  // --- heights ---------------------------------------------------------------------------------

  /// Computes the shift of Z at a place, and adds it to the report.
  Expected<double> shift_mm(const GcodeBlock& block, const Eigen::Vector2d& p_mm) {
    const auto zoned = map_.height_at(position_mm<frame::Nominal>(p_mm));
    if (!zoned) return failure(placed(zoned.error(), block));
    const HeightAt* const found = &zoned->height;
    if (found->sigma > figures_.largest_sigma) {
      figures_.largest_sigma = found->sigma;
      figures_.line_of_largest_sigma = block.line;
    }
    is_filled_ = is_filled_ || found->source == HeightSource::Filled;
    is_extrapolated_ = is_extrapolated_ || found->source == HeightSource::Extrapolated;
    is_over_void_ = is_over_void_ || found->source == HeightSource::InVoid;
    const Length added = found->height - mm(zero_mm_);
    // Outside of the probes the board may be higher than its highest place inside.
    if (!(added < figures_.safe_height)) {
      return failure(problem(block,
                             Code::ArgumentInvalid,
                             fmt::format("the board is {:.3f} mm high here, and the safe height is "
                                         "{:.3f} mm",
                                         added.in_mm(),
                                         safe_mm()),
                             "a safe height above the board"));
    }
    figures_.lowest = has_shifted_ ? std::min(figures_.lowest, added) : added;
    figures_.highest = has_shifted_ ? std::max(figures_.highest, added) : added;
    has_shifted_ = true;
    return added.in_mm();
  }

  /// A tool that goes evenly does not follow a step from one zone to another.
  Expected<void> check_step(const GcodeBlock& block,
                            const Eigen::Vector2d& from_mm,
                            const Eigen::Vector2d& to_mm) const {
    const auto step =
        map_.step_between(position_mm<frame::Nominal>(from_mm), position_mm<frame::Nominal>(to_mm));
    if (!step || step->is_followed_within(options_.height_tolerance)) return {};
    return failure(problem(block,
                           Code::ArgumentInvalid,
                           fmt::format("the surface steps by {:+.4f} mm from zone {} to zone {}, "
                                       "near ({:.3f}, {:.3f})",
                                       step->height.in_mm(),
                                       quoted(map_.zones()[step->i_from].name),
                                       quoted(map_.zones()[step->i_to].name),
                                       to_mm.x(),
                                       to_mm.y()),
                           "a move above the safe height between zones, or a wider height "
                           "tolerance"));
  }

  /// The first profile looks at everything, finer ones at heights alone.
  Expected<std::vector<double>> profile_mm(const GcodeBlock& block,
                                           const Motion& motion,
                                           const Stretch& stretch,
                                           std::size_t n,
                                           bool is_first) {
    places_mm_.clear();
    for (std::size_t i = 0; i <= n; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(n);
      const double t = i == n ? stretch.end : stretch.begin + share * (stretch.end - stretch.begin);
      places_mm_.push_back(gcode::place_mm(motion, t));
      if (!is_first) continue;
      PANELCAL_CHECK(shift_mm(block, places_mm_.back()));
      if (i > 0) PANELCAL_CHECK(check_step(block, places_mm_[i - 1], places_mm_[i]));
    }
    std::vector<double> heights_mm(n + 1);
    PANELCAL_CHECK(map_.heights_at(places_mm_, heights_mm));
    return heights_mm;
  }

  /// Parts of the way at which a stretch is cut, its end included.
  Expected<std::vector<double>> ends_of(const GcodeBlock& block,
                                        const Motion& motion,
                                        const Stretch& stretch) {
    const double span_mm = (stretch.end - stretch.begin) * gcode::length_mm(motion);
    const std::size_t least = way_samples(span_mm, map_.finest_cell());
    auto found =
        way_cuts([&](std::size_t n) { return profile_mm(block, motion, stretch, n, n == least); },
                 least,
                 options_.height_tolerance);
    if (!found) return failure(placed(found.error(), block));
    for (double& t : *found) t = stretch.begin + t * (stretch.end - stretch.begin);
    found->push_back(stretch.end);
    return found;
  }

  // --- moves -----------------------------------------------------------------------------------

  Expected<void> put_cycle(const GcodeBlock& block, const Motion& motion) {
    PANELCAL_TRY(const double added_mm, shift_mm(block, motion.to.xy_mm()));
    if (motion.travel_mm < safe_mm()) {
      return failure(problem(block,
                             Code::NotSupported,
                             fmt::format("a drilling cycle that moves on at {:.3f} mm, below the "
                                         "safe height of {:.3f} mm",
                                         motion.travel_mm,
                                         safe_mm()),
                             "G98 after a move to the safe height, or a safe height of R or less"));
    }
    const double bottom_mm = *motion.to.z_mm + added_mm;
    // No higher than the tool travels: it would then return to R.
    const double retract_mm = std::min(
        motion.retract_mm + (is_below(motion.retract_mm) ? added_mm : 0), motion.travel_mm);
    if (!(bottom_mm < retract_mm)) {
      return failure(problem(block,
                             Code::NotSupported,
                             fmt::format("a hole whose bottom is at {:.3f} mm on this board, not "
                                         "below R of {:.3f} mm",
                                         bottom_mm,
                                         retract_mm),
                             "a move to a greater height before the cycle, or a deeper hole"));
    }
    const Counting counting = reader_.counting();
    // Where the tool is before the first cycle is how high G98 returns, if that is above R. The
    // program has it below the safe height, and so below R; the surface may have lifted it above.
    if (is_below(motion.from.z_mm)) {
      lines_.put_rise(safe_mm(), counting);
      ++figures_.n_pieces;
    }
    lines_.begin_block(block);
    if (block.has('X')) lines_.put_place('X', *motion.to.x_mm, counting);
    if (block.has('Y')) lines_.put_place('Y', *motion.to.y_mm, counting);
    lines_.put_height('Z', bottom_mm, counting);
    lines_.put_height('R', retract_mm, counting);
    lines_.end_block(block);
    ++figures_.n_pieces;
    return {};
  }

  Expected<void> put_way(const GcodeBlock& block, const Motion& motion) {
    const bool is_known = motion.from.has_xy() && motion.to.has_xy() && motion.from.z_mm;
    if (!is_known || !(gcode::length_mm(motion) > 0)) return put_end(block, motion);
    std::vector<std::pair<double, double>> knots;  // part of the way, Z
    PANELCAL_TRY(const std::vector<Stretch> parts, stretches(block, motion));
    for (const Stretch& stretch : parts) {
      PANELCAL_CHECK(append_knots(block, motion, stretch, knots));
    }
    lines_.begin_block(block);
    double begin = 0;
    for (std::size_t i = 0; i < knots.size(); ++i) {
      if (i > 0) lines_.begin_move(motion.kind);
      put_piece(block, motion, begin, knots[i]);
      begin = knots[i].first;
      i + 1 < knots.size() ? lines_.end_line() : lines_.end_block(block);
    }
    figures_.n_pieces += static_cast<std::int64_t>(knots.size());
    return {};
  }

  /// Up and down where the tool stands, and rapid moves from an unknown place.
  Expected<void> put_end(const GcodeBlock& block, const Motion& motion) {
    const bool from_nowhere = motion.goes() && motion.kind != MotionKind::Rapid;
    double added_mm = 0;
    if (is_below(motion.to.z_mm)) {
      if (!motion.to.has_xy() || from_nowhere) {
        return failure(problem(block,
                               Code::CoordinateMissing,
                               "move below the safe height from an unknown place",
                               "X, Y and Z before it"));
      }
      PANELCAL_TRY(added_mm, shift_mm(block, motion.to.xy_mm()));
    }
    const Counting counting = reader_.counting();
    lines_.begin_block(block);
    if (block.has('X')) lines_.put_place('X', *motion.to.x_mm, counting);
    if (block.has('Y')) lines_.put_place('Y', *motion.to.y_mm, counting);
    lines_.put_height('Z', *motion.to.z_mm + added_mm, counting);
    lines_.end_block(block);
    ++figures_.n_pieces;
    return {};
  }

  /// The shortest piece that a move may have. A line may go straight up; an arc of no length would
  /// be a full circle.
  static double least_share(const Motion& motion) {
    return motion.is_arc() ? kLeastArc_mm / gcode::length_mm(motion) : 0;
  }

  /// Stretches below the safe height, and above: these end or begin where the ones along the
  /// surface begin or end. Where the surface is below 0 the tool sinks to it, or rises from it, at
  /// the safe height itself: spread over the way above, it would sink towards what stands higher
  /// there.
  ///
  /// Precondition: it is known where it begins and ends.
  Expected<std::vector<Stretch>> stretches(const GcodeBlock& block, const Motion& motion) {
    const bool begins_below = is_below(motion.from.z_mm), ends_below = is_below(motion.to.z_mm);
    if (begins_below == ends_below) return std::vector<Stretch>{{}};
    const double from_mm = *motion.from.z_mm, to_mm = *motion.to.z_mm;
    const double least = least_share(motion);
    if (least > 0.5) return std::vector<Stretch>{{0, 1, ends_below, ends_below}};
    const double at = std::clamp((safe_mm() - from_mm) / (to_mm - from_mm), least, 1 - least);
    PANELCAL_TRY(const double added_mm, shift_mm(block, gcode::place_mm(motion, at)));
    const bool is_steep = added_mm < 0;
    // Straight up or down; an arc as steeply as its shortest piece may be.
    const auto behind = [&](double t) { return t + least < 1 - least / 2 ? t + least : 1; };
    std::vector<Stretch> parts;
    if (begins_below) {
      parts.push_back({0, at, true, true});
      if (is_steep) parts.push_back({at, behind(at), false, false});
      if (parts.back().end < 1 || !is_steep) parts.push_back({parts.back().end, 1, false, false});
    } else {
      const double begin = is_steep && at > least ? at : 0;
      if (begin > 0) parts.push_back({0, begin, false, false});
      parts.push_back({begin, is_steep ? behind(begin) : at, false, true});
      if (parts.back().end < 1) parts.push_back({parts.back().end, 1, true, true});
    }
    return parts;
  }

  Expected<void> append_knots(const GcodeBlock& block,
                              const Motion& motion,
                              const Stretch& stretch,
                              std::vector<std::pair<double, double>>& knots) {
    const double rise_mm = *motion.to.z_mm - *motion.from.z_mm;
    std::vector<double> ends = {stretch.end};
    if (stretch.follows && stretch.end > stretch.begin) {
      PANELCAL_TRY(ends, ends_of(block, motion, stretch));
    }
    for (const double end : ends) {
      double added_mm = 0;
      if (stretch.ends_on_surface) {
        PANELCAL_TRY(added_mm, shift_mm(block, gcode::place_mm(motion, end)));
      }
      knots.emplace_back(end, *motion.to.z_mm - (1 - end) * rise_mm + added_mm);
    }
    return {};
  }

  /// In     end: part of the way, and Z there
  void put_piece(const GcodeBlock& block,
                 const Motion& motion,
                 double begin,
                 const std::pair<double, double>& end) {
    const Counting counting = reader_.counting();
    const Eigen::Vector2d to_mm = gcode::place_mm(motion, end.first);
    // A line that leaves out an axis does not move along it.
    if (motion.is_arc() || block.has('X')) lines_.put_place('X', to_mm.x(), counting);
    if (motion.is_arc() || block.has('Y')) lines_.put_place('Y', to_mm.y(), counting);
    lines_.put_height('Z', end.second, counting);
    if (!motion.is_arc()) return;
    const Eigen::Vector2d from_mm = gcode::place_mm(motion, begin);
    const Eigen::Vector2d origin_mm =
        reader_.arcs_are_absolute() ? Eigen::Vector2d(Eigen::Vector2d::Zero()) : from_mm;
    lines_.put_offset('I', motion.center_mm.x() - origin_mm.x(), counting);
    lines_.put_offset('J', motion.center_mm.y() - origin_mm.y(), counting);
  }

  const SourceText& program_;
  const ZonedMap& map_;
  const LevelOptions& options_;
  MotionReader reader_;
  GcodeLines lines_;
  double zero_mm_ = 0;
  std::vector<Eigen::Vector2d> places_mm_;
  bool has_shifted_ = false;
  bool is_filled_ = false;  ///< the present move
  bool is_extrapolated_ = false;
  bool is_over_void_ = false;
  LevelFigures figures_;
};

}  // namespace

Expected<LevelledGcode> level_gcode(const SourceText& program,
                                    const ZonedMap& map,
                                    const LevelOptions& options) {
  return Leveller(program, map, options).level();
}

}  // namespace panelcal
