// SPDX-License-Identifier: Apache-2.0
// Contours: T0, G1 to G3 with rounded corners and ramps, and the figures G45 to G50.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "calib/base/plane_vectors.h"
#include "program/sieb_meyer/interpreter/parts.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

using internal::cross;

bool is_figure(Command motion) {
  return motion != Command::RoutLine && motion != Command::RoutClockwise &&
         motion != Command::RoutCounterclockwise;
}

/// The angle that an arc covers, above 0; its ends in one place make a full circle.
double sweep_rad(const ContourPiece& arc) {
  const Eigen::Vector2d from = arc.start_mm - *arc.center_mm;
  const Eigen::Vector2d to = arc.end_mm - *arc.center_mm;
  double sweep = std::atan2(cross(from, to), from.dot(to));
  if (arc.clockwise) sweep = -sweep;
  return sweep > 1e-12 ? sweep : sweep + 2 * std::numbers::pi;
}

/// The point nearest to a centre that is equally far from both ends.
Eigen::Vector2d on_bisector(const ContourPiece& piece, const Eigen::Vector2d& center_mm) {
  const Eigen::Vector2d chord_mm = piece.end_mm - piece.start_mm;
  const Eigen::Vector2d middle_mm = (piece.start_mm + piece.end_mm) / 2;
  const Eigen::Vector2d normal = Eigen::Vector2d(-chord_mm.y(), chord_mm.x()).normalized();
  return middle_mm + normal * normal.dot(center_mm - middle_mm);
}

/// Point of an arc after a part of its sweep.
Eigen::Vector2d on_arc(const ContourPiece& arc, double fraction) {
  if (fraction >= 1) return arc.end_mm;
  const Eigen::Vector2d from = arc.start_mm - *arc.center_mm;
  const double angle = (arc.clockwise ? -1 : 1) * fraction * sweep_rad(arc);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return *arc.center_mm + Eigen::Vector2d(c * from.x() - s * from.y(), s * from.x() + c * from.y());
}

std::optional<Length> tool_diameter(const Walk& walk) {
  return walk.tool ? walk.tool->diameter : std::nullopt;
}

/// Refuses a line that does not rout from where the cutter stands.
bool may_rout(Walk& walk, const Block& block) {
  if (walk.contour == Contour::None) {
    walk.reporter.report(Code::ContourUnopened, block, "X#Y#T0 before it");
    return false;
  }
  if (std::exchange(walk.takes_surface_late, false)) {
    walk.reporter.report(Code::CommandMisplaced,
                         block,
                         " begins a contour with an L# behind its T0 line: the control "
                         "takes the surface value ahead of that",
                         "L# before the T0 line");
    return false;
  }
  judge_control(walk, block.line);
  return true;
}

/// R above zero goes the short way round, below zero the long way.
bool make_radius_arc(Walk& walk, const Block& block, bool clockwise, ContourPiece& piece) {
  const double radius_mm = std::abs(*walk.modal.radius_mm);
  const bool is_long = *walk.modal.radius_mm < 0;
  const double chord_mm = (piece.end_mm - piece.start_mm).norm();
  if (chord_mm > 2 * radius_mm + 2 * walk.step_mm) {
    walk.reporter.report(Code::ArcInvalid,
                         block,
                         fmt::format(": the ends are {:.4f} mm apart", chord_mm),
                         fmt::format("at most twice the radius, {:.4f} mm", 2 * radius_mm));
    return false;
  }
  // The long way round is the rest of the circle whose short way has the other sense.
  const ArcFit fit = arc_from_radius(
      piece.start_mm, piece.end_mm, radius_mm, is_long ? !clockwise : clockwise, 2 * walk.step_mm);
  if (fit.fault != ArcFault::None) {
    walk.reporter.report(Code::ArcInvalid, block, "a radius above zero");
    return false;
  }
  piece.center_mm = fit.arc.center_mm;
  return true;
}

/// I and J are start less centre, for arcs of any angle. A centre that is not equally far from both
/// ends is moved to where it is, if that is not far.
bool make_center_arc(Walk& walk, const Block& block, bool, ContourPiece& piece) {
  constexpr double kMostMismatch = 0.03;
  const Eigen::Vector2d center_mm =
      piece.start_mm - Eigen::Vector2d(walk.modal.center_offset_mm[0].value_or(0),
                                       walk.modal.center_offset_mm[1].value_or(0));
  const double start_mm = (piece.start_mm - center_mm).norm();
  const double end_mm = (piece.end_mm - center_mm).norm();
  const double mismatch_mm = std::abs(start_mm - end_mm);
  if (!(start_mm > 0) || !(end_mm > 0) ||
      mismatch_mm > kMostMismatch * std::max(start_mm, end_mm)) {
    walk.reporter.report(
        Code::ArcInvalid,
        block,
        fmt::format(
            ": the radius is {:.4f} mm at the start and {:.4f} mm at the end", start_mm, end_mm),
        "I and J that are start less centre");
    return false;
  }
  piece.center_mm = on_bisector(piece, center_mm);
  if (mismatch_mm > 3 * walk.step_mm) {
    walk.reporter.report(
        Code::ArcAdjusted, block, fmt::format(" by {:.4f} mm", mismatch_mm / 2), "");
  }
  return true;
}

/// Format 1000: I and J have no sign, and a line routs no more than one quadrant, which decides.
bool make_quadrant(Walk& walk, const Block& block, bool clockwise, ContourPiece& piece) {
  const double i_mm = walk.modal.center_offset_mm[0].value_or(0);
  const double j_mm = walk.modal.center_offset_mm[1].value_or(0);
  const double radius_mm = std::hypot(i_mm, j_mm);
  std::optional<Eigen::Vector2d> best_mm;
  double least_mm = std::max(3 * walk.step_mm, 0.03 * radius_mm);
  for (const double i_sign : {1.0, -1.0}) {
    for (const double j_sign : {1.0, -1.0}) {
      ContourPiece tried = piece;
      tried.clockwise = clockwise;
      const Eigen::Vector2d center_mm =
          piece.start_mm - Eigen::Vector2d(i_sign * i_mm, j_sign * j_mm);
      tried.center_mm = center_mm;
      const double off_mm = std::abs((piece.end_mm - center_mm).norm() - radius_mm);
      const double slack_rad = 3 * walk.step_mm / std::max(radius_mm, walk.step_mm) + 1e-9;
      if (off_mm < least_mm && sweep_rad(tried) <= std::numbers::pi / 2 + slack_rad) {
        least_mm = off_mm;
        best_mm = center_mm;
      }
    }
  }
  if (!best_mm) {
    walk.reporter.report(Code::ArcInvalid,
                         block,
                         " is longer than one quadrant",
                         "a line for each quadrant in format 1000");
    return false;
  }
  piece.center_mm = on_bisector(piece, *best_mm);
  return true;
}

bool make_arc(Walk& walk, const Block& block, bool clockwise, ContourPiece& piece) {
  piece.clockwise = clockwise;
  if ((piece.end_mm - piece.start_mm).norm() <= 0) {
    walk.reporter.report(Code::ArcInvalid, block, "an end away from the start");
    return false;
  }
  if (walk.modal.radius_mm) return make_radius_arc(walk, block, clockwise, piece);
  if (!walk.modal.center_offset_mm[0] && !walk.modal.center_offset_mm[1]) {
    walk.reporter.report(Code::ArcInvalid, block, "R#, or I#J#, in this line or before it");
    return false;
  }
  if (walk.format.file == FileFormat::F1000) return make_quadrant(walk, block, clockwise, piece);
  return make_center_arc(walk, block, clockwise, piece);
}

/// Arcs are at most half circles: longer ones were cut.
void send_part(Walk& walk,
               int line,
               const ContourPiece& piece,
               std::optional<Feed> feed,
               const DepthOfCut& from) {
  if (!piece.center_mm) return walk.emitter.rout(line, piece.end_mm, feed);
  walk.emitter.rout(line,
                    Arc{piece.start_mm, piece.end_mm, *piece.center_mm, piece.clockwise, false},
                    feed,
                    from);
}

/// Parts of a piece at which it has to be cut so that the tool follows the measured grid, or a ramp
/// its line.
std::vector<double> cuts_of(Walk& walk, const PendingPiece& pending) {
  const ContourPiece& piece = pending.piece;
  std::vector<double> cuts;
  if (piece.center_mm && sweep_rad(piece) > std::numbers::pi) cuts.push_back(0.5);
  if (!pending.follows_grid) return cuts;
  const GridMap* const grid = walk.surface.grid(pending.line);
  if (grid == nullptr) return cuts;
  const auto nominal = [&walk](const Eigen::Vector2d& p_mm) -> Eigen::Vector2d {
    return walk.place.placement(position_mm<frame::Programmed>(p_mm)).in_mm();
  };
  const Length tolerance = walk.options.board.height_tolerance;
  std::vector<double> more;
  if (!piece.center_mm) {
    more = grid->split_line(nominal(piece.start_mm), nominal(piece.end_mm), tolerance);
  } else {
    // Scaling makes an ellipse of a circle by parts in a million, which a grid does not see.
    const Eigen::Vector2d center_mm = nominal(*piece.center_mm);
    const Eigen::Vector2d from_mm = nominal(piece.start_mm) - center_mm;
    const Eigen::Matrix2d& linear = walk.place.placement.linear();
    const double sense = internal::is_mirror(linear) ? -1 : 1;
    const double sweep = (piece.clockwise ? -1 : 1) * sense * sweep_rad(piece);
    const double start_rad = std::atan2(from_mm.y(), from_mm.x());
    // Between its ends, which are asked for anyway, an arc reaches farthest along an axis.
    for (int quarter = -8; quarter <= 8; ++quarter) {
      const double angle = quarter * std::numbers::pi / 2;
      const double part = (angle - start_rad) / sweep;
      if (!(part > 0 && part < 1)) continue;
      const Eigen::Vector2d reach(std::cos(angle), std::sin(angle));
      if (!walk.surface.grid_surface_at(pending.line, center_mm + from_mm.norm() * reach))
        return cuts;
    }
    more = grid->split_arc(center_mm, start_rad, sweep, from_mm.norm(), tolerance);
  }
  cuts.insert(cuts.end(), more.begin(), more.end());
  std::ranges::sort(cuts);
  cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
  return cuts;
}

void send_piece(Walk& walk, const PendingPiece& pending) {
  const int line = pending.line;
  const auto cut_there = [&](const Eigen::Vector2d& at_mm, const DepthOfCut& cut) {
    return pending.follows_grid ? grid_cut(walk, line, at_mm, cut) : cut;
  };
  const bool starts = !std::exchange(walk.is_plunged, true);
  if (starts && walk.machine_at_mm != pending.piece.start_mm) {
    walk.emitter.move(line, pending.piece.start_mm);
  }
  // Another depth without G6: the cutter goes there where it stands.
  const bool changes =
      pending.from != walk.routed_cut || pending.follows_grid != walk.routed_on_grid;
  if (starts || changes) {
    walk.emitter.set_cut(cut_there(pending.piece.start_mm, pending.from));
    walk.emitter.plunge(line, PlungeKind::Plain, pending.side, tool_diameter(walk));
  } else {
    walk.emitter.compensate(line, pending.side, tool_diameter(walk));
  }
  walk.routed_cut = pending.to;
  walk.routed_on_grid = pending.follows_grid;
  for (const auto& [kind, text] : pending.events) {
    function(walk, line, kind, text, kind == FunctionKind::MachineFunction);
  }
  if (pending.finishes) {
    walk.emitter.put(line, Function{.kind = FunctionKind::FinishRouting, .text = "G11"});
  }
  const ContourPiece& piece = pending.piece;
  std::vector<double> ends = cuts_of(walk, pending);
  ends.push_back(1);
  double begin = 0;
  Eigen::Vector2d at_mm = piece.start_mm;
  for (const double end : ends) {
    ContourPiece part = piece;
    part.start_mm = at_mm;
    part.end_mm = end == 1 ? piece.end_mm
                  : piece.center_mm
                      ? on_arc(piece, end)
                      : Eigen::Vector2d(piece.start_mm + end * (piece.end_mm - piece.start_mm));
    const DepthOfCut from = cut_there(at_mm, interpolate(pending.from, pending.to, begin));
    walk.emitter.set_cut(cut_there(part.end_mm, interpolate(pending.from, pending.to, end)));
    send_part(walk, line, part, pending.feed, from);
    begin = end;
    at_mm = part.end_mm;
  }
  walk.emitter.set_cut(walk.base_cut);
  walk.machine_at_mm = piece.end_mm;
}

/// Passes the piece that waits, its end rounded towards the next one if D asks for it.
void flush_piece(Walk& walk, PendingPiece* next) {
  if (!walk.piece) return;
  PendingPiece piece = *std::exchange(walk.piece, std::nullopt);
  if (!piece.rounding_mm) return send_piece(walk, piece);
  if (next == nullptr) {
    walk.reporter.report(Code::CycleInvalid,
                         piece.line,
                         quoted(piece.text) + " rounds the end of a contour",
                         "D# where another line or arc follows");
    return send_piece(walk, piece);
  }
  const auto corner = round_corner(piece.piece, next->piece, *piece.rounding_mm);
  if (!corner) {
    walk.reporter.report(
        Code::CycleInvalid, piece.line, quoted(piece.text) + ": " + corner.error());
    return send_piece(walk, piece);
  }
  piece.piece.end_mm = corner->start_mm;
  next->piece.start_mm = corner->end_mm;
  const bool has_rest = (piece.piece.end_mm - piece.piece.start_mm).norm() > 0;
  if (has_rest) send_piece(walk, piece);
  PendingPiece rounding = piece;
  rounding.piece = {corner->start_mm, corner->end_mm, corner->center_mm, corner->clockwise};
  rounding.from = rounding.to;
  rounding.finishes = false;
  if (has_rest) rounding.events.clear();
  send_piece(walk, rounding);
}

tl::expected<FigurePath, std::string> figure_path(const Walk& walk,
                                                  Command motion,
                                                  const Order& order,
                                                  double diameter_mm) {
  const Cut cut = order.clears_area || walk.clears_areas ? Cut::Area : Cut::Contour;
  const bool is_clockwise = motion == Command::CircleClockwise ||
                            motion == Command::DiskClockwise ||
                            motion == Command::RectangleClockwise;
  const Turn turn = is_clockwise ? Turn::Clockwise : Turn::Counterclockwise;
  const bool is_rectangle =
      motion == Command::RectangleClockwise || motion == Command::RectangleCounterclockwise;
  if (is_rectangle) {
    Eigen::Vector2d sides_mm;
    if (walk.modal.radius_mm) {
      sides_mm.setConstant(*walk.modal.radius_mm);
    } else if (walk.modal.center_offset_mm[0] && walk.modal.center_offset_mm[1]) {
      sides_mm = {*walk.modal.center_offset_mm[0], *walk.modal.center_offset_mm[1]};
    } else {
      return tl::unexpected<std::string>("the sides are missing; expected R#, or I#J#");
    }
    return rectangle_inside(walk.modal.at_mm, sides_mm, diameter_mm, turn, cut);
  }
  // I and J are the shares of a radius as well: format 1000 has no R.
  std::optional<double> radius_mm = walk.modal.radius_mm;
  if (!radius_mm && (walk.modal.center_offset_mm[0] || walk.modal.center_offset_mm[1])) {
    radius_mm = std::hypot(walk.modal.center_offset_mm[0].value_or(0),
                           walk.modal.center_offset_mm[1].value_or(0));
  }
  if (!radius_mm) return tl::unexpected<std::string>("the radius is missing; expected R#");
  const bool is_disk = motion == Command::DiskClockwise || motion == Command::DiskCounterclockwise;
  if (is_disk) {
    if (order.clears_area) {
      return tl::unexpected<std::string>("G43 clears the inside of a hole; expected G45 or G46");
    }
    return disk_outside(walk.modal.at_mm, *radius_mm, diameter_mm, turn);
  }
  return circle_inside(walk.modal.at_mm, *radius_mm, diameter_mm, turn, cut);
}

/// G45 to G50: the cutter goes to its plunge point by itself, and is up again behind the figure.
void figure(Walk& walk, const Block& block, const Order& order) {
  const Eigen::Vector2d before_mm = walk.modal.at_mm;
  const bool follows_figure = walk.contour == Contour::Figures;
  move_to(walk, order);
  flush_piece(walk, nullptr);
  if (walk.is_plunged) walk.emitter.put(block.line, Retract{});
  walk.is_plunged = false;
  walk.contour = Contour::Figures;
  if (!may_work(walk, block.line)) return;
  if (follows_figure && walk.modal.at_mm == before_mm) {
    return walk.reporter.report(Code::RoutRepeated,
                                block,
                                " has the centre of the line before",
                                "another place, or T0 between them");
  }
  const auto diameter_mm = tool_diameter_mm(walk, block);
  if (!diameter_mm) return;
  const auto path = figure_path(walk, *walk.modal.motion, order, *diameter_mm);
  if (!path) {
    return walk.reporter.report(Code::CycleInvalid, block, ": " + path.error(), "");
  }
  walk.emitter.move(block.line, path->plunge_mm);
  walk.emitter.set_cut(cut_at(walk, block.line, path->plunge_mm));
  walk.emitter.plunge(block.line, PlungeKind::Plain, CompensationSide::Off, std::nullopt);
  if (order.finishes && (walk.modal.motion == Command::DiskClockwise ||
                         walk.modal.motion == Command::DiskCounterclockwise)) {
    walk.emitter.put(block.line, Function{.kind = FunctionKind::FinishRouting, .text = "G11"});
  }
  PendingPiece piece;
  piece.line = block.line;
  piece.from = piece.to = walk.base_cut;
  piece.follows_grid = uses_grid(walk);
  piece.feed = walk.modal.feed;
  walk.is_plunged = true;
  walk.routed_cut = walk.base_cut;
  walk.routed_on_grid = piece.follows_grid;
  piece.events = std::exchange(walk.waiting_events, {});
  for (const Arc& arc : path->pieces) {
    piece.piece = {arc.start_mm, arc.end_mm, std::nullopt, arc.clockwise};
    if (!arc.straight) piece.piece.center_mm = arc.center_mm;
    send_piece(walk, piece);
    piece.events.clear();
    if (walk.has_ended()) return;
  }
  walk.is_plunged = false;
  walk.machine_at_mm.reset();
  walk.emitter.put(block.line, Retract{});
}

}  // namespace

/// T0 with coordinates moves with the tool up; if a contour was being routed, it has ended. Behind
/// a figure the move waits until something is routed from there.
void position(Walk& walk, const Block& block, const Order& order) {
  const Eigen::Vector2d before_mm = walk.modal.at_mm;
  const Contour was = walk.contour;
  const bool has_place = move_to(walk, order);
  walk.contour = Contour::Positioned;
  walk.takes_surface_late = false;
  if (order.side) walk.modal.side = *order.side;
  if (!has_place || !may_work(walk, block.line)) return;
  if (was == Contour::Figures && walk.modal.at_mm == before_mm) return;
  if (was != Contour::None && walk.machine_at_mm == walk.modal.at_mm) return;
  walk.emitter.move(block.line, walk.modal.at_mm);
  walk.machine_at_mm = walk.modal.at_mm;
}

/// Raises the tool and forgets what holds for one contour only.
void end_contour(Walk& walk, int line) {
  flush_piece(walk, nullptr);
  for (const auto& [kind, text] : std::exchange(walk.waiting_events, {})) {
    function(walk, line, kind, text);
  }
  if (std::exchange(walk.is_plunged, false)) walk.emitter.put(line, Retract{});
  if (walk.contour == Contour::Routing) walk.contour = Contour::Positioned;
  walk.modal.motion.reset();
  walk.modal.side = CompensationSide::Off;
}

void rout(Walk& walk, const Block& block, const Order& order) {
  const Command motion = order.motion.value_or(walk.modal.motion.value_or(Command::RoutLine));
  const bool is_one_figure = is_figure(motion);
  const std::uint32_t known =
      is_one_figure ? kXy | kMotion | kCutArea | kFinish | kParameters
                    : kXy | kMotion | kSide | kRamp | kFinish | kRounding | kParameters;
  if (!holds_only(walk, block, order, known) || !may_rout(walk, block)) return;
  if (order.side) walk.modal.side = *order.side;
  if (order.motion) walk.modal.motion = order.motion;
  if (is_one_figure && order.has_xy()) return figure(walk, block, order);
  if (!order.has_xy()) {
    const std::uint32_t without_place = kMotion | kSide | kParameters;
    holds_only(walk, block, order, without_place);
    return;
  }
  if (walk.contour == Contour::Figures) {
    return walk.reporter.report(Code::ContourUnopened,
                                block,
                                " goes on from a finished figure",
                                "X#Y#T0 where the next contour begins");
  }
  const bool is_first = walk.contour == Contour::Positioned;
  if (is_first && !has_reference(walk)) {
    return walk.reporter.report(
        Code::AxisAmbiguous, block, " begins a contour where no line has led", "X#Y#T0 before it");
  }
  const Eigen::Vector2d from_mm = walk.modal.at_mm;
  const double from_step_mm = walk.modal.at_step_mm;
  move_to(walk, order);
  if (!may_work(walk, block.line)) return;
  if (walk.modal.at_mm == from_mm && !is_first &&
      (order.z_mm || order.k_mm || order.depth_control)) {
    // Only deeper or higher, where the cutter stands (the example of G82 and G83).
    flush_piece(walk, nullptr);
    walk.emitter.set_cut(cut_at(walk, block.line, from_mm));
    walk.emitter.plunge(block.line, PlungeKind::Plain, walk.modal.side, tool_diameter(walk));
    walk.emitter.set_cut(walk.base_cut);
    walk.routed_cut = walk.base_cut;
    walk.routed_on_grid = uses_grid(walk);
    return;
  }
  if (walk.modal.at_mm == from_mm && !is_first) {
    return walk.reporter.report(Code::RoutRepeated, block, "another place, or T0");
  }
  PendingPiece next;
  next.piece.start_mm = from_mm;
  next.piece.end_mm = walk.modal.at_mm;
  next.line = block.line;
  next.text = std::string(block.text);
  next.rounding_mm = order.rounding_mm;
  next.finishes = order.finishes;
  next.side = walk.modal.side;
  next.from = next.to = walk.base_cut;
  next.feed = walk.modal.feed;
  if (order.is_ramp) next.from = walk.ramp_start;
  next.follows_grid = uses_grid(walk);
  next.events = std::exchange(walk.waiting_events, {});
  walk.step_mm = std::max({from_step_mm, walk.modal.at_step_mm, walk.modal.arc_step_mm});
  if (motion != Command::RoutLine &&
      !make_arc(walk, block, motion == Command::RoutClockwise, next.piece)) {
    return;
  }
  flush_piece(walk, &next);
  walk.piece = std::move(next);
  walk.contour = Contour::Routing;
}

// --- arcs --------------------------------------------------------------------------------------

// --- sending -----------------------------------------------------------------------------------

// --- figures -----------------------------------------------------------------------------------

}  // namespace panelcal::sieb_meyer
