// SPDX-License-Identifier: Apache-2.0
// Contours: T0, G1 to G3 with rounded corners and ramps, and the figures G45 to G50.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "program/geometry/plane_vectors.h"
#include "program/sieb_meyer/interpreter/interpreter.h"
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

}  // namespace

std::optional<Length> Interpreter::tool_diameter() const {
  return tool_ ? tool_->diameter : std::nullopt;
}

/// T0 with coordinates moves with the tool up; if a contour was being routed, it has ended. Behind
/// a figure the move waits until something is routed from there.
void Interpreter::position(const Block& block, const Order& order) {
  const Eigen::Vector2d before_mm = modal_.at_mm;
  const Contour was = contour_;
  const bool has_place = move_to(order);
  contour_ = Contour::Positioned;
  takes_surface_late_ = false;
  if (order.side) modal_.side = *order.side;
  if (!has_place || !may_work(block.line)) return;
  if (was == Contour::Figures && modal_.at_mm == before_mm) return;
  if (was != Contour::None && machine_at_mm_ == modal_.at_mm) return;
  emitter_.move(block.line, modal_.at_mm);
  machine_at_mm_ = modal_.at_mm;
}

/// Raises the tool and forgets what holds for one contour only.
void Interpreter::end_contour(int line) {
  flush_piece(nullptr);
  for (const auto& [kind, text] : std::exchange(waiting_events_, {})) {
    function(line, kind, text);
  }
  if (std::exchange(is_plunged_, false)) emitter_.put(line, Retract{});
  if (contour_ == Contour::Routing) contour_ = Contour::Positioned;
  modal_.motion.reset();
  modal_.side = CompensationSide::Off;
}

/// Refuses a line that does not rout from where the cutter stands.
bool Interpreter::may_rout(const Block& block) {
  if (contour_ == Contour::None) {
    report(Code::ContourUnopened, block, quoted(block.text), "X#Y#T0 before it");
    return false;
  }
  if (std::exchange(takes_surface_late_, false)) {
    report(Code::CommandMisplaced,
           block,
           quoted(block.text) +
               " begins a contour with an L# behind its T0 line: the control "
               "takes the surface value ahead of that",
           "L# before the T0 line");
    return false;
  }
  judge_control(block.line);
  return true;
}

void Interpreter::rout(const Block& block, const Order& order) {
  const Command motion = order.motion.value_or(modal_.motion.value_or(Command::RoutLine));
  const bool is_one_figure = is_figure(motion);
  const std::uint32_t known =
      is_one_figure ? kXy | kMotion | kCutArea | kFinish | kParameters
                    : kXy | kMotion | kSide | kRamp | kFinish | kRounding | kParameters;
  if (!holds_only(block, order, known) || !may_rout(block)) return;
  if (order.side) modal_.side = *order.side;
  if (order.motion) modal_.motion = order.motion;
  if (is_one_figure && order.has_xy()) return figure(block, order);
  if (!order.has_xy()) {
    const std::uint32_t without_place = kMotion | kSide | kParameters;
    holds_only(block, order, without_place);
    return;
  }
  if (contour_ == Contour::Figures) {
    return report(Code::ContourUnopened,
                  block,
                  quoted(block.text) + " goes on from a finished figure",
                  "X#Y#T0 where the next contour begins");
  }
  const bool is_first = contour_ == Contour::Positioned;
  if (is_first && !has_reference()) {
    return report(Code::AxisAmbiguous,
                  block,
                  quoted(block.text) + " begins a contour where no line has led",
                  "X#Y#T0 before it");
  }
  const Eigen::Vector2d from_mm = modal_.at_mm;
  const double from_step_mm = modal_.at_step_mm;
  move_to(order);
  if (!may_work(block.line)) return;
  if (modal_.at_mm == from_mm && !is_first && (order.z_mm || order.k_mm || order.depth_control)) {
    // Only deeper or higher, where the cutter stands (the example of G82 and G83).
    flush_piece(nullptr);
    emitter_.set_cut(cut_at(block.line, from_mm));
    emitter_.plunge(block.line, PlungeKind::Plain, modal_.side, tool_diameter());
    emitter_.set_cut(base_cut_);
    routed_cut_ = base_cut_;
    routed_on_grid_ = uses_grid();
    return;
  }
  if (modal_.at_mm == from_mm && !is_first) {
    return report(Code::RoutRepeated, block, quoted(block.text), "another place, or T0");
  }
  PendingPiece next;
  next.piece.start_mm = from_mm;
  next.piece.end_mm = modal_.at_mm;
  next.line = block.line;
  next.text = std::string(block.text);
  next.rounding_mm = order.rounding_mm;
  next.finishes = order.finishes;
  next.side = modal_.side;
  next.from = next.to = base_cut_;
  next.feed = modal_.feed;
  if (order.is_ramp) next.from = ramp_start_;
  next.follows_grid = uses_grid();
  next.events = std::exchange(waiting_events_, {});
  step_mm_ = std::max({from_step_mm, modal_.at_step_mm, modal_.arc_step_mm});
  if (motion != Command::RoutLine &&
      !make_arc(block, motion == Command::RoutClockwise, next.piece)) {
    return;
  }
  flush_piece(&next);
  piece_ = std::move(next);
  contour_ = Contour::Routing;
}

// --- arcs --------------------------------------------------------------------------------------

bool Interpreter::make_arc(const Block& block, bool clockwise, ContourPiece& piece) {
  piece.clockwise = clockwise;
  if ((piece.end_mm - piece.start_mm).norm() <= 0) {
    report(Code::ArcInvalid, block, quoted(block.text), "an end away from the start");
    return false;
  }
  if (modal_.radius_mm) return make_radius_arc(block, clockwise, piece);
  if (!modal_.center_offset_mm[0] && !modal_.center_offset_mm[1]) {
    report(Code::ArcInvalid, block, quoted(block.text), "R#, or I#J#, in this line or before it");
    return false;
  }
  if (format_.file == FileFormat::F1000) return make_quadrant(block, clockwise, piece);
  return make_center_arc(block, clockwise, piece);
}

/// R above zero goes the short way round, below zero the long way.
bool Interpreter::make_radius_arc(const Block& block, bool clockwise, ContourPiece& piece) {
  const double radius_mm = std::abs(*modal_.radius_mm);
  const bool is_long = *modal_.radius_mm < 0;
  const double chord_mm = (piece.end_mm - piece.start_mm).norm();
  if (chord_mm > 2 * radius_mm + 2 * step_mm_) {
    report(Code::ArcInvalid,
           block,
           fmt::format("{}: the ends are {:.4f} mm apart", quoted(block.text), chord_mm),
           fmt::format("at most twice the radius, {:.4f} mm", 2 * radius_mm));
    return false;
  }
  // The long way round is the rest of the circle whose short way has the other sense.
  const ArcFit fit = arc_from_radius(
      piece.start_mm, piece.end_mm, radius_mm, is_long ? !clockwise : clockwise, 2 * step_mm_);
  if (fit.fault != ArcFault::None) {
    report(Code::ArcInvalid, block, quoted(block.text), "a radius above zero");
    return false;
  }
  piece.center_mm = fit.arc.center_mm;
  return true;
}

/// I and J are start less centre, for arcs of any angle. A centre that is not equally far from both
/// ends is moved to where it is, if that is not far.
bool Interpreter::make_center_arc(const Block& block, bool, ContourPiece& piece) {
  constexpr double kMostMismatch = 0.03;
  const Eigen::Vector2d center_mm =
      piece.start_mm - Eigen::Vector2d(modal_.center_offset_mm[0].value_or(0),
                                       modal_.center_offset_mm[1].value_or(0));
  const double start_mm = (piece.start_mm - center_mm).norm();
  const double end_mm = (piece.end_mm - center_mm).norm();
  const double mismatch_mm = std::abs(start_mm - end_mm);
  if (!(start_mm > 0) || !(end_mm > 0) ||
      mismatch_mm > kMostMismatch * std::max(start_mm, end_mm)) {
    report(Code::ArcInvalid,
           block,
           fmt::format("{}: the radius is {:.4f} mm at the start and {:.4f} mm at the end",
                       quoted(block.text),
                       start_mm,
                       end_mm),
           "I and J that are start less centre");
    return false;
  }
  piece.center_mm = on_bisector(piece, center_mm);
  if (mismatch_mm > 3 * step_mm_) {
    reporter_.report(Code::ArcAdjusted,
                     block.line,
                     block.column,
                     fmt::format("{} by {:.4f} mm", quoted(block.text), mismatch_mm / 2));
  }
  return true;
}

/// Format 1000: I and J have no sign, and a line routs no more than one quadrant, which decides.
bool Interpreter::make_quadrant(const Block& block, bool clockwise, ContourPiece& piece) {
  const double i_mm = modal_.center_offset_mm[0].value_or(0);
  const double j_mm = modal_.center_offset_mm[1].value_or(0);
  const double radius_mm = std::hypot(i_mm, j_mm);
  std::optional<Eigen::Vector2d> best_mm;
  double least_mm = std::max(3 * step_mm_, 0.03 * radius_mm);
  for (const double i_sign : {1.0, -1.0}) {
    for (const double j_sign : {1.0, -1.0}) {
      ContourPiece tried = piece;
      tried.clockwise = clockwise;
      const Eigen::Vector2d center_mm =
          piece.start_mm - Eigen::Vector2d(i_sign * i_mm, j_sign * j_mm);
      tried.center_mm = center_mm;
      const double off_mm = std::abs((piece.end_mm - center_mm).norm() - radius_mm);
      const double slack_rad = 3 * step_mm_ / std::max(radius_mm, step_mm_) + 1e-9;
      if (off_mm < least_mm && sweep_rad(tried) <= std::numbers::pi / 2 + slack_rad) {
        least_mm = off_mm;
        best_mm = center_mm;
      }
    }
  }
  if (!best_mm) {
    report(Code::ArcInvalid,
           block,
           quoted(block.text) + " is longer than one quadrant",
           "a line for each quadrant in format 1000");
    return false;
  }
  piece.center_mm = on_bisector(piece, *best_mm);
  return true;
}

// --- sending -----------------------------------------------------------------------------------

/// Passes the piece that waits, its end rounded towards the next one if D asks for it.
void Interpreter::flush_piece(PendingPiece* next) {
  if (!piece_) return;
  PendingPiece piece = *std::exchange(piece_, std::nullopt);
  if (!piece.rounding_mm) return send_piece(piece);
  if (next == nullptr) {
    reporter_.report(Code::CycleInvalid,
                     piece.line,
                     1,
                     panelcal::quoted(piece.text) + " rounds the end of a contour",
                     "D# where another line or arc follows");
    return send_piece(piece);
  }
  const auto corner = round_corner(piece.piece, next->piece, *piece.rounding_mm);
  if (!corner) {
    reporter_.report(Code::CycleInvalid,
                     piece.line,
                     1,
                     panelcal::quoted(piece.text) + ": " + corner.error(),
                     "");
    return send_piece(piece);
  }
  piece.piece.end_mm = corner->start_mm;
  next->piece.start_mm = corner->end_mm;
  const bool has_rest = (piece.piece.end_mm - piece.piece.start_mm).norm() > 0;
  if (has_rest) send_piece(piece);
  PendingPiece rounding = piece;
  rounding.piece = {corner->start_mm, corner->end_mm, corner->center_mm, corner->clockwise};
  rounding.from = rounding.to;
  rounding.finishes = false;
  if (has_rest) rounding.events.clear();
  send_piece(rounding);
}

void Interpreter::send_piece(const PendingPiece& pending) {
  const int line = pending.line;
  const auto cut_there = [&](const Eigen::Vector2d& at_mm, const DepthOfCut& cut) {
    return pending.follows_grid ? grid_cut(line, at_mm, cut) : cut;
  };
  const bool starts = !std::exchange(is_plunged_, true);
  if (starts && machine_at_mm_ != pending.piece.start_mm) {
    emitter_.move(line, pending.piece.start_mm);
  }
  // Another depth without G6: the cutter goes there where it stands.
  const bool changes = pending.from != routed_cut_ || pending.follows_grid != routed_on_grid_;
  if (starts || changes) {
    emitter_.set_cut(cut_there(pending.piece.start_mm, pending.from));
    emitter_.plunge(line, PlungeKind::Plain, pending.side, tool_diameter());
  } else {
    emitter_.compensate(line, pending.side, tool_diameter());
  }
  routed_cut_ = pending.to;
  routed_on_grid_ = pending.follows_grid;
  for (const auto& [kind, text] : pending.events) {
    function(line, kind, text, kind == FunctionKind::MachineFunction);
  }
  if (pending.finishes) {
    emitter_.put(line, Function{.kind = FunctionKind::FinishRouting, .text = "G11"});
  }
  const ContourPiece& piece = pending.piece;
  std::vector<double> ends = cuts_of(pending);
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
    emitter_.set_cut(cut_there(part.end_mm, interpolate(pending.from, pending.to, end)));
    send_part(line, part, pending.feed, from);
    begin = end;
    at_mm = part.end_mm;
  }
  emitter_.set_cut(base_cut_);
  machine_at_mm_ = piece.end_mm;
}

/// Arcs are at most half circles: longer ones were cut.
void Interpreter::send_part(int line,
                            const ContourPiece& piece,
                            std::optional<Feed> feed,
                            const DepthOfCut& from) {
  if (!piece.center_mm) return emitter_.rout(line, piece.end_mm, feed);
  emitter_.rout(line,
                Arc{piece.start_mm, piece.end_mm, *piece.center_mm, piece.clockwise, false},
                feed,
                from);
}

/// Parts of a piece at which it has to be cut so that the tool follows the measured grid, or a ramp
/// its line.
std::vector<double> Interpreter::cuts_of(const PendingPiece& pending) {
  const ContourPiece& piece = pending.piece;
  std::vector<double> cuts;
  if (piece.center_mm && sweep_rad(piece) > std::numbers::pi) cuts.push_back(0.5);
  if (!pending.follows_grid) return cuts;
  const GridMap* const grid = surface_.grid(pending.line);
  if (grid == nullptr) return cuts;
  const auto nominal = [this](const Eigen::Vector2d& p_mm) -> Eigen::Vector2d {
    return place_.placement(position_mm<frame::Programmed>(p_mm)).in_mm();
  };
  const Length tolerance = options_.board.height_tolerance;
  std::vector<double> more;
  if (!piece.center_mm) {
    more = grid->split_line(nominal(piece.start_mm), nominal(piece.end_mm), tolerance);
  } else {
    // Scaling makes an ellipse of a circle by parts in a million, which a grid does not see.
    const Eigen::Vector2d center_mm = nominal(*piece.center_mm);
    const Eigen::Vector2d from_mm = nominal(piece.start_mm) - center_mm;
    const Eigen::Matrix2d& linear = place_.placement.linear();
    const double sense = linear(0, 0) * linear(1, 1) - linear(0, 1) * linear(1, 0) < 0 ? -1 : 1;
    const double sweep = (piece.clockwise ? -1 : 1) * sense * sweep_rad(piece);
    const double start_rad = std::atan2(from_mm.y(), from_mm.x());
    // Between its ends, which are asked for anyway, an arc reaches farthest along an axis.
    for (int quarter = -8; quarter <= 8; ++quarter) {
      const double angle = quarter * std::numbers::pi / 2;
      const double part = (angle - start_rad) / sweep;
      if (!(part > 0 && part < 1)) continue;
      const Eigen::Vector2d reach(std::cos(angle), std::sin(angle));
      if (!surface_.grid_surface_at(pending.line, center_mm + from_mm.norm() * reach)) return cuts;
    }
    more = grid->split_arc(center_mm, start_rad, sweep, from_mm.norm(), tolerance);
  }
  cuts.insert(cuts.end(), more.begin(), more.end());
  std::ranges::sort(cuts);
  cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
  return cuts;
}

// --- figures -----------------------------------------------------------------------------------

/// G45 to G50: the cutter goes to its plunge point by itself, and is up again behind the figure.
void Interpreter::figure(const Block& block, const Order& order) {
  const Eigen::Vector2d before_mm = modal_.at_mm;
  const bool follows_figure = contour_ == Contour::Figures;
  move_to(order);
  flush_piece(nullptr);
  if (is_plunged_) emitter_.put(block.line, Retract{});
  is_plunged_ = false;
  contour_ = Contour::Figures;
  if (!may_work(block.line)) return;
  if (follows_figure && modal_.at_mm == before_mm) {
    return report(Code::RoutRepeated,
                  block,
                  quoted(block.text) + " has the centre of the line before",
                  "another place, or T0 between them");
  }
  const auto diameter_mm = tool_diameter_mm(block);
  if (!diameter_mm) return;
  const auto path = figure_path(*modal_.motion, order, *diameter_mm);
  if (!path) {
    return report(Code::CycleInvalid, block, quoted(block.text) + ": " + path.error(), "");
  }
  emitter_.move(block.line, path->plunge_mm);
  emitter_.set_cut(cut_at(block.line, path->plunge_mm));
  emitter_.plunge(block.line, PlungeKind::Plain, CompensationSide::Off, std::nullopt);
  if (order.finishes &&
      (modal_.motion == Command::DiskClockwise || modal_.motion == Command::DiskCounterclockwise)) {
    emitter_.put(block.line, Function{.kind = FunctionKind::FinishRouting, .text = "G11"});
  }
  PendingPiece piece;
  piece.line = block.line;
  piece.from = piece.to = base_cut_;
  piece.follows_grid = uses_grid();
  piece.feed = modal_.feed;
  is_plunged_ = true;
  routed_cut_ = base_cut_;
  routed_on_grid_ = piece.follows_grid;
  piece.events = std::exchange(waiting_events_, {});
  for (const Arc& arc : path->pieces) {
    piece.piece = {arc.start_mm, arc.end_mm, std::nullopt, arc.clockwise};
    if (!arc.straight) piece.piece.center_mm = arc.center_mm;
    send_piece(piece);
    piece.events.clear();
    if (has_ended()) return;
  }
  is_plunged_ = false;
  machine_at_mm_.reset();
  emitter_.put(block.line, Retract{});
}

tl::expected<FigurePath, std::string> Interpreter::figure_path(Command motion,
                                                               const Order& order,
                                                               double diameter_mm) const {
  const Cut cut = order.clears_area || clears_areas_ ? Cut::Area : Cut::Contour;
  const bool is_clockwise = motion == Command::CircleClockwise ||
                            motion == Command::DiskClockwise ||
                            motion == Command::RectangleClockwise;
  const Turn turn = is_clockwise ? Turn::Clockwise : Turn::Counterclockwise;
  const bool is_rectangle =
      motion == Command::RectangleClockwise || motion == Command::RectangleCounterclockwise;
  if (is_rectangle) {
    Eigen::Vector2d sides_mm;
    if (modal_.radius_mm) {
      sides_mm.setConstant(*modal_.radius_mm);
    } else if (modal_.center_offset_mm[0] && modal_.center_offset_mm[1]) {
      sides_mm = {*modal_.center_offset_mm[0], *modal_.center_offset_mm[1]};
    } else {
      return tl::unexpected<std::string>("the sides are missing; expected R#, or I#J#");
    }
    return rectangle_inside(modal_.at_mm, sides_mm, diameter_mm, turn, cut);
  }
  // I and J are the shares of a radius as well: format 1000 has no R.
  std::optional<double> radius_mm = modal_.radius_mm;
  if (!radius_mm && (modal_.center_offset_mm[0] || modal_.center_offset_mm[1])) {
    radius_mm =
        std::hypot(modal_.center_offset_mm[0].value_or(0), modal_.center_offset_mm[1].value_or(0));
  }
  if (!radius_mm) return tl::unexpected<std::string>("the radius is missing; expected R#");
  const bool is_disk = motion == Command::DiskClockwise || motion == Command::DiskCounterclockwise;
  if (is_disk) {
    if (order.clears_area) {
      return tl::unexpected<std::string>("G43 clears the inside of a hole; expected G45 or G46");
    }
    return disk_outside(modal_.at_mm, *radius_mm, diameter_mm, turn);
  }
  return circle_inside(modal_.at_mm, *radius_mm, diameter_mm, turn, cut);
}

}  // namespace panelcal::sieb_meyer
