// SPDX-License-Identifier: Apache-2.0
// Routing: moves, arcs on a stretched or bent panel, compensation, plunges.
#include <limits>
#include <vector>

#include "calib/base/plane_vectors.h"
#include "program/geometry/arc_path.h"
#include "program/geometry/bent_path.h"
#include "program/walk/execution/emitter.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::is_mirror;

/// The table's feed where the program sets none (CNC-7 manual, Z-Axis Infeed).
constexpr Feed kDefaultTableFeed = inch_per_min(100);

}  // namespace

void Emitter::step_slot(int line,
                        const Eigen::Vector2d& start_mm,
                        const Eigen::Vector2d& end_mm,
                        Length initial_depth,
                        Length increment,
                        std::optional<Feed> feed) {
  was_switched_off_ |= !corrections_.is_withheld;
  refuse_passes(line);
  if (!passes(line)) return;
  const PlacedPoint end = placed(line, end_mm, Scaling::Never);
  send(line,
       StepSlot{tool_,
                placed(line, start_mm, Scaling::Never),
                end,
                initial_depth,
                increment,
                feed.value_or(kDefaultTableFeed),
                !feed});
}

void Emitter::move(int line, const Eigen::Vector2d& to_mm) {
  was_switched_off_ |= !corrections_.is_withheld;  // by the control, during the move (G00)
  if (!passes(line)) return;
  stand_at(to_mm);
  send(line, RapidMove{placed(line, to_mm, Scaling::Never)});
}

Rout Emitter::rout_to(int line,
                      const Eigen::Vector2d& at_mm,
                      std::optional<Feed> feed,
                      const DepthOfCut& cut) {
  Rout move;
  static_cast<PlacedPoint&>(move) = placed(line, at_mm, Scaling::Never);
  move.tool = tool_;
  move.feed = feed.value_or(kDefaultTableFeed);
  move.feed_is_default = !feed;
  move.cut = cut;
  return move;
}

void Emitter::stand_at(const Eigen::Vector2d& at_mm) {
  stands_at_ = place_.placement(position_mm<frame::Programmed>(at_mm));
  stands_at_cut_ = cut_;
}

Eigen::Vector2d Emitter::commanded_mm(int line, const Eigen::Vector2d& at_mm) {
  const auto nominal = place_.placement(position_mm<frame::Programmed>(at_mm));
  const auto commanded = commanded_for(line, corrections_.stack.actual_of(nominal));
  // A job that is refused need not be cut into pieces.
  if (is_off_table_) return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  return commanded.in_mm();
}

void Emitter::take_center(const Eigen::Vector2d& commanded_center_mm, Rout& move) const {
  move.commanded_center = displacement_mm<frame::Machine>(commanded_center_mm);
  move.center = place_.work_zero + move.commanded_center;
  // A table errs at an arc's centre as at its end, as near as pictures of the job need it.
  const Eigen::Vector2d error_mm = move.corrected.in_mm() - move.commanded.in_mm();
  move.corrected_center = position_mm<frame::Actual>((commanded_center_mm + error_mm).eval());
}

void Emitter::rout(int line, const Eigen::Vector2d& to_mm, std::optional<Feed> feed) {
  const bool is_cut = is_bent() || depths_.follows_map(cut_);
  if (is_cut && sink_ != nullptr && stands_at_ && !corrections_.is_withheld) {
    const Eigen::Vector2d from_mm = place_.placement.inverse()(*stands_at_).in_mm();
    const Arc path{from_mm, to_mm, 0.5 * (from_mm + to_mm), false, true};
    return rout_way(line, path, feed, stands_at_cut_);
  }
  if (!passes(line)) return;
  stand_at(to_mm);
  send(line, rout_to(line, to_mm, feed, cut_at(line, *stands_at_)));
}

void Emitter::rout(int line, const Arc& arc, std::optional<Feed> feed, const DepthOfCut& from) {
  if (sink_ == nullptr || corrections_.is_withheld) {
    count_operations(1, line);
    return;
  }
  rout_way(line, arc, feed, from);
}

/// As deep as [[depth]] says; where that counts from a map, the way is cut so that the tool keeps
/// to the surface.
void Emitter::rout_way(int line,
                       const Arc& path,
                       std::optional<Feed> feed,
                       const DepthOfCut& from) {
  if (!depths_.is_needed()) {
    rout_piece(line, path, feed, from, cut_);
    return stand_at(path.end_mm);
  }
  const ArcPath way(path);
  const auto place = [&](double share) {
    return place_.placement(position_mm<frame::Programmed>(way.at(share)));
  };
  std::vector<double> ends = {1};
  if (depths_.follows_map(cut_)) ends = depths_.cuts(line, place, way.length_mm());
  const auto cut_after = [&](double share) {
    return depths_.at(line, place(share), share < 1 ? interpolate(from, cut_, share) : cut_);
  };
  double begin = 0;
  DepthOfCut begin_cut = cut_after(0);
  for (const double end : ends) {
    const DepthOfCut end_cut = cut_after(end);
    rout_piece(line, ends.size() == 1 ? path : way.part(begin, end), feed, begin_cut, end_cut);
    begin = end;
    begin_cut = end_cut;
  }
  stand_at(path.end_mm);
}

void Emitter::rout_piece(int line,
                         const Arc& path,
                         std::optional<Feed> feed,
                         const DepthOfCut& from,
                         const DepthOfCut& to) {
  if (is_bent()) return rout_bent(line, path, feed, from, to);
  if (!path.straight) return rout_arc(line, path, feed, from, to);
  if (passes(line)) send(line, rout_to(line, path.end_mm, feed, to));
}

/// On a bent panel, and on a table whose error bends it, a path is cut into lines or arcs that keep
/// as near to its image as arcs of a stretched panel do.
void Emitter::rout_bent(int line,
                        const Arc& path,
                        std::optional<Feed> feed,
                        const DepthOfCut& from,
                        const DepthOfCut& to) {
  const std::vector<BentPiece> pieces = carry_bent(
      path,
      [this, line](const Eigen::Vector2d& at_mm) { return commanded_mm(line, at_mm); },
      options_.arc_tolerance.in_mm());
  for (std::size_t i = 0; i < pieces.size() && passes(line); ++i) {
    const BentPiece& piece = pieces[i];
    const bool is_last = i + 1 == pieces.size();
    Rout move =
        rout_to(line, piece.end_mm, feed, is_last ? to : interpolate(from, to, piece.share));
    if (!piece.image.straight) {
      move.kind = piece.image.clockwise ? RoutKind::Clockwise : RoutKind::Counterclockwise;
      take_center(piece.image.center_mm, move);
    }
    send(line, move);
  }
}

/// Stretch turns a circle into an ellipse, which takes several arcs (or lines where it is almost
/// straight) within the tolerance; mirrors turn the sense round.
void Emitter::rout_arc(int line,
                       const Arc& arc,
                       std::optional<Feed> feed,
                       const DepthOfCut& from,
                       const DepthOfCut& to) {
  const auto& correction = corrections_.stack.actual_from_nominal().map;
  const auto whole = correction * place_.placement;
  const auto back = whole.inverse();
  const std::vector<Arc> pieces =
      carry_arc(arc, whole.linear(), whole.translation(), options_.arc_tolerance.in_mm());
  for (std::size_t i = 0; i < pieces.size() && passes(line); ++i) {
    const Arc& piece = pieces[i];
    const bool is_last = i + 1 == pieces.size();
    const Eigen::Vector2d end_mm =
        is_last ? arc.end_mm : back(position_mm<frame::Actual>(piece.end_mm)).in_mm();
    const double fraction = static_cast<double>(i + 1) / static_cast<double>(pieces.size());
    Rout move = rout_to(line, end_mm, feed, is_last ? to : interpolate(from, to, fraction));
    if (!piece.straight) {
      move.kind = piece.clockwise ? RoutKind::Clockwise : RoutKind::Counterclockwise;
      take_center(piece.center_mm, move);
    }
    send(line, move);
  }
}

DepthOfCut Emitter::cut_where_it_stands(int line) {
  if (!stands_at_ && follows_map()) {
    reporter_.report_working(Code::CoordinateMissing,
                             line,
                             0,
                             "the router goes down before the first place",
                             "a move to X#Y# before it");
  }
  return cut_at(line, stands_at_.value_or(Position<frame::Nominal>()));
}

/// No plain depth says how deep a single pass is.
void Emitter::refuse_passes(int line) {
  if (!depths_.has_tool_depth()) return;
  reporter_.report(Code::NotSupported,
                   line,
                   0,
                   fmt::format("a slot in deepening passes (G87) by tool {}, whose depth [[depth]] "
                               "states",
                               tool_),
                   "a slot in one pass");
}

CompensationSide Emitter::placed_side(CompensationSide side) const {
  const auto placed = corrections_.stack.actual_from_nominal().map * place_.placement;
  if (side == CompensationSide::Off || !is_mirror(placed.linear())) return side;
  return side == CompensationSide::Left ? CompensationSide::Right : CompensationSide::Left;
}

void Emitter::compensate(int line,
                         CompensationSide side,
                         std::optional<Length> compensation_value) {
  side = placed_side(side);
  if (side == side_ || corrections_.is_withheld) return;
  side_ = side;
  if (side == CompensationSide::Off) compensation_value.reset();
  put(line, Compensation{side, compensation_value});
}

void Emitter::plunge(int line,
                     PlungeKind kind,
                     CompensationSide side,
                     std::optional<Length> compensation_value,
                     std::optional<Length> depth_offset) {
  if (corrections_.is_withheld) {
    count_operations(1, line);
    return;
  }
  side = placed_side(side);
  const bool has_to_be_told = side != side_ || (was_switched_off_ && side != CompensationSide::Off);
  if (side == CompensationSide::Off) compensation_value.reset();
  if (has_to_be_told) put(line, Compensation{side, compensation_value});
  side_ = side;
  was_switched_off_ = false;
  stands_at_cut_ = cut_;
  if (depth_offset) refuse_passes(line);
  if (passes(line)) send(line, Plunge{tool_, kind, depth_offset, cut_where_it_stands(line)});
}

}  // namespace panelcal
