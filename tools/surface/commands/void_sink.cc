// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/commands/void_sink.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

#include "calib/base/plane_vectors.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

using Eigen::Vector2d;
using internal::cross;
using internal::left_of;

/// Coordinates of maps are in steps of this: half the bytes of a file, and less than any machine
/// knows of its place.
constexpr double kStepsPerMm = 1e6;
/// Greatest distance of a chord from its arc.
constexpr double kSagitta_mm = 0.002;
/// Around an outer corner the tool goes in chords of at most this angle.
constexpr double kCornerStep_rad = std::numbers::pi / 12;

Position<frame::Nominal> rounded_place(const Vector2d& p_mm) {
  return position_mm<frame::Nominal>(std::round(p_mm.x() * kStepsPerMm) / kStepsPerMm,
                                     std::round(p_mm.y() * kStepsPerMm) / kStepsPerMm);
}

/// Ends of chords of a move, the first and the last included.
std::vector<Vector2d> contour_of(const Vector2d& from_mm, const Rout& rout) {
  const Vector2d& to_mm = rout.nominal.in_mm();
  if (rout.kind == RoutKind::Line) return {from_mm, to_mm};
  // Nominal places differ from corrected ones by a shift here: the panel is perfect.
  const Vector2d center_mm = to_mm + (rout.corrected_center.in_mm() - rout.corrected.in_mm());
  const Vector2d begin_mm = from_mm - center_mm, end_mm = to_mm - center_mm;
  const double radius_mm = begin_mm.norm();
  double sweep_rad = std::atan2(cross(begin_mm, end_mm), begin_mm.dot(end_mm));
  // At most half a circle, whose sense rounding does not tell.
  const bool is_clockwise = rout.kind == RoutKind::Clockwise;
  sweep_rad = is_clockwise ? -std::abs(sweep_rad) : std::abs(sweep_rad);
  if (!(radius_mm > kSagitta_mm)) return {from_mm, to_mm};
  const double step_rad = 2 * std::acos(1 - kSagitta_mm / radius_mm);
  const int n = std::max(1, static_cast<int>(std::ceil(std::abs(sweep_rad) / step_rad)));
  const double first_rad = std::atan2(begin_mm.y(), begin_mm.x());
  std::vector<Vector2d> out = {from_mm};
  for (int i = 1; i < n; ++i) {
    const double angle_rad = first_rad + sweep_rad * i / n;
    out.push_back(center_mm + radius_mm * Vector2d(std::cos(angle_rad), std::sin(angle_rad)));
  }
  out.push_back(to_mm);
  return out;
}

}  // namespace

Place VoidSink::place_of(const Operation& operation) const {
  return {operation.file.empty() ? file_ : std::string(operation.file), operation.line, 1};
}

std::optional<Length> VoidSink::diameter_of(const Operation& operation, int tool) {
  const auto found = diameters_.find(tool);
  if (found != diameters_.end() && found->second) return found->second;
  Unknown& unknown = unknown_[tool];
  if (unknown.n++ == 0) unknown.first = place_of(operation);
  return std::nullopt;
}

void VoidSink::put(const Operation& operation) {
  if (const auto* change = std::get_if<ToolChange>(&operation.what)) {
    diameters_[change->tool.number] = change->tool.diameter;
  } else if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    put_hole(operation, *drill);
  } else if (const auto* slot = std::get_if<Slot>(&operation.what)) {
    put_slot(operation, slot->start.nominal, slot->end.nominal, slot->tool);
  } else if (const auto* step_slot = std::get_if<StepSlot>(&operation.what)) {
    put_slot(operation, step_slot->start.nominal, step_slot->end.nominal, step_slot->tool);
  } else if (const auto* compensation = std::get_if<Compensation>(&operation.what)) {
    side_ = compensation->side;
    compensation_ = compensation->value;
  } else if (const auto* move = std::get_if<RapidMove>(&operation.what)) {
    router_ = move->nominal;
    heading_.reset();
  } else if (const auto* rout = std::get_if<Rout>(&operation.what)) {
    put_rout(operation, *rout);
    router_ = rout->nominal;
  }
}

void VoidSink::put_hole(const Operation& operation, const Drill& drill) {
  const auto diameter = diameter_of(operation, drill.tool);
  if (!diameter) return;
  voids_.push_back({Circle{rounded_place(drill.nominal.in_mm()), 0.5 * *diameter},
                    fmt::format("hole of tool {}", drill.tool),
                    place_of(operation)});
}

void VoidSink::put_slot(const Operation& operation,
                        const Position<frame::Nominal>& from,
                        const Position<frame::Nominal>& to,
                        int tool) {
  const auto diameter = diameter_of(operation, tool);
  if (!diameter) return;
  voids_.push_back({Track{{rounded_place(from.in_mm()), rounded_place(to.in_mm())}, *diameter},
                    fmt::format("slot of tool {}", tool),
                    place_of(operation)});
}

void VoidSink::put_rout(const Operation& operation, const Rout& rout) {
  const auto diameter = diameter_of(operation, rout.tool);
  if (!diameter) return;
  std::vector<Vector2d> way_mm = contour_of(router_.in_mm(), rout);
  if (side_ != CompensationSide::Off) {
    const Length shift = 0.5 * compensation_.value_or(*diameter);
    way_mm = tool_way_mm(way_mm, side_ == CompensationSide::Left ? shift : -shift);
  }
  Track track{{}, *diameter};
  for (const Vector2d& at_mm : way_mm) track.points.push_back(rounded_place(at_mm));
  voids_.push_back(
      {std::move(track), fmt::format("rout of tool {}", rout.tool), place_of(operation)});
}

/// Beside each chord, and around the corners between them.
std::vector<Vector2d> VoidSink::tool_way_mm(const std::vector<Vector2d>& contour_mm,
                                            Length to_the_left) {
  std::vector<Vector2d> out;
  for (std::size_t i = 1; i < contour_mm.size(); ++i) {
    const Vector2d chord_mm = contour_mm[i] - contour_mm[i - 1];
    if (!(chord_mm.norm() > 0)) continue;
    const Vector2d heading = chord_mm.normalized();
    const Vector2d last = heading_.value_or(heading);
    const double turn_rad = std::atan2(cross(last, heading), last.dot(heading));
    const int n = static_cast<int>(std::ceil(std::abs(turn_rad) / kCornerStep_rad));
    for (int k = 0; k < n; ++k) {
      const double c = std::cos(turn_rad * k / n), s = std::sin(turn_rad * k / n);
      const Vector2d between(c * last.x() - s * last.y(), s * last.x() + c * last.y());
      out.push_back(contour_mm[i - 1] + to_the_left.in_mm() * left_of(between));
    }
    out.push_back(contour_mm[i - 1] + to_the_left.in_mm() * left_of(heading));
    out.push_back(contour_mm[i] + to_the_left.in_mm() * left_of(heading));
    heading_ = heading;
  }
  if (out.empty()) out.push_back(contour_mm.back());
  return out;
}

Expected<std::vector<Void>> VoidSink::take() {
  if (!unknown_.empty()) {
    const auto& [tool, unknown] = *unknown_.begin();
    const std::string others =
        unknown_.size() > 1 ? fmt::format(", and {} more tools", unknown_.size() - 1) : "";
    return failure({Code::DiameterMissing,
                    unknown.first,
                    fmt::format("tool {} has no diameter, and works at {} places{}: how large its "
                                "voids are is not known",
                                tool,
                                unknown.n,
                                others),
                    "a diameter in the program"});
  }
  std::set<std::tuple<double, double, double>> seen;
  std::erase_if(voids_, [&](const Void& one) {
    const auto* circle = std::get_if<Circle>(&one.area);
    if (circle == nullptr) return false;
    const Vector2d& at_mm = circle->center.in_mm();
    return !seen.emplace(at_mm.x(), at_mm.y(), circle->radius.in_mm()).second;
  });
  return std::move(voids_);
}

}  // namespace panelcal::surface
