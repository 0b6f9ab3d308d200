// SPDX-License-Identifier: Apache-2.0
#include "program/writers/excellon/stored_operations.h"

#include <variant>

#include "calib/base/plane_vectors.h"

namespace panelcal {
namespace {

using internal::is_mirror;

/// Changes an operation in place. A pattern is kept only where nothing is corrected, so that the
/// machine is told where it is.
struct Carrier {
  const WorkMap& map;
  std::vector<Position<frame::Nominal>>& targets;
  std::vector<Placement>& copies;

  Position<frame::Actual> moved(const Position<frame::Actual>& p) const {
    return position_mm<frame::Actual>(map(position_mm<frame::Nominal>(p.in_mm())).in_mm());
  }
  void move(PlacedPoint& point) const {
    const Eigen::Vector2d work_zero_mm = point.actual.in_mm() - point.commanded.in_mm();
    point.nominal = map(point.nominal);
    point.corrected = moved(point.corrected);
    point.commanded = displacement_mm<frame::Machine>(point.corrected.in_mm());
    point.actual = position_mm<frame::Machine>(work_zero_mm + point.commanded.in_mm());
    point.cov_mm2 = map.linear() * point.cov_mm2 * map.linear().transpose();
  }

  void operator()(Drill& drill) const { move(drill); }
  void operator()(RapidMove& rapid) const { move(rapid); }
  void operator()(Rout& rout) const {
    const Eigen::Vector2d work_zero_mm = rout.actual.in_mm() - rout.commanded.in_mm();
    move(rout);
    if (rout.kind == RoutKind::Line) return;
    rout.corrected_center = moved(rout.corrected_center);
    rout.commanded_center = displacement_mm<frame::Machine>(rout.corrected_center.in_mm());
    rout.center = position_mm<frame::Machine>(work_zero_mm + rout.commanded_center.in_mm());
    if (!is_mirror(map.linear())) return;
    rout.kind = rout.kind == RoutKind::Clockwise ? RoutKind::Counterclockwise : RoutKind::Clockwise;
  }
  void operator()(Slot& slot) const {
    move(slot.start);
    move(slot.end);
  }
  void operator()(StepSlot& slot) const {
    move(slot.start);
    move(slot.end);
  }
  void operator()(Compensation& compensation) const {
    if (compensation.side == CompensationSide::Off || !is_mirror(map.linear())) return;
    compensation.side = compensation.side == CompensationSide::Left ? CompensationSide::Right
                                                                    : CompensationSide::Left;
  }
  void operator()(Autocalibration& calibration) const {
    const Eigen::Vector2d work_zero_mm = calibration.actual.in_mm() - calibration.commanded.in_mm();
    calibration.nominal = map(calibration.nominal);
    calibration.commanded = displacement_mm<frame::Machine>(calibration.nominal.in_mm());
    calibration.actual = position_mm<frame::Machine>(work_zero_mm + calibration.commanded.in_mm());
  }
  void operator()(TargetHole& hole) const { hole.nominal = map(hole.nominal); }
  void operator()(OpticalOrder& order) const {
    if (order.target) order.target = map(*order.target);
  }
  void operator()(SurfaceOrder& order) const {
    if (order.place) move(*order.place);
  }
  void operator()(VisionSeries& series) const {
    targets.assign(series.targets.begin(), series.targets.end());
    for (auto& target : targets) target = map(target);
    series.targets = targets;
  }
  void operator()(PatternEnd& end) const {
    copies.assign(end.copies.begin(), end.copies.end());
    for (Placement& copy : copies) copy = map * copy;
    end.copies = copies;
  }
  template <class What>
  void operator()(What&) const {}
};

}  // namespace

void StoredOperations::add(const Operation& operation) {
  Stored& stored = operations_.emplace_back();
  stored.operation = operation;
  stored.operation.origin = nullptr;
  stored.file = operation.file;
  stored.operation.file = stored.file;
  stored.path.assign(operation.path.begin(), operation.path.end());
  stored.operation.path = stored.path;
  const auto keep = [&stored](std::string_view& text) {
    stored.text = text;
    text = stored.text;
  };
  if (auto* message = std::get_if<Message>(&stored.operation.what)) keep(message->text);
  if (auto* setting = std::get_if<Setting>(&stored.operation.what)) keep(setting->text);
  if (auto* function = std::get_if<Function>(&stored.operation.what)) keep(function->text);
  if (auto* order = std::get_if<OpticalOrder>(&stored.operation.what)) keep(order->text);
  if (auto* series = std::get_if<VisionSeries>(&stored.operation.what)) {
    stored.targets.assign(series->targets.begin(), series->targets.end());
    series->targets = stored.targets;
  }
  if (auto* end = std::get_if<PatternEnd>(&stored.operation.what)) {
    stored.copies.assign(end->copies.begin(), end->copies.end());
    end->copies = stored.copies;
  }
}

Operation carried(const Operation& operation,
                  const WorkMap& map,
                  std::vector<Position<frame::Nominal>>& targets,
                  std::vector<Placement>& copies) {
  Operation moved = operation;
  std::visit(Carrier{map, targets, copies}, moved.what);
  return moved;
}

}  // namespace panelcal
