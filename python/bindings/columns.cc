// SPDX-License-Identifier: Apache-2.0
#include "python/bindings/columns.h"

#include <limits>
#include <variant>

#include <pybind11/stl.h>

namespace panelcal::python {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

}  // namespace

void OperationColumns::begin(const ProgramInfo&) {
  // An execution that began before this one was given up.
  *this = OperationColumns();
}

void OperationColumns::put(const Operation& operation) {
  const std::string_view op = operation_name(operation);
  const auto& what = operation.what;
  if (const auto* change = std::get_if<ToolChange>(&what)) {
    diameter_mm_ = change->tool.diameter ? change->tool.diameter->in_mm() : kNone;
    add(op, operation, change->tool.number, nullptr);
  } else if (const auto* drill = std::get_if<Drill>(&what)) {
    add(op, operation, drill->tool, drill);
  } else if (const auto* rout = std::get_if<Rout>(&what)) {
    add(op, operation, rout->tool, rout);
  } else if (const auto* move = std::get_if<RapidMove>(&what)) {
    add(op, operation, 0, move);
  } else if (const auto* slot = std::get_if<Slot>(&what)) {
    add(op, operation, slot->tool, &slot->start);
    add("slot_end", operation, slot->tool, &slot->end);
  } else if (const auto* step_slot = std::get_if<StepSlot>(&what)) {
    add(op, operation, step_slot->tool, &step_slot->start);
    add("slot_end", operation, step_slot->tool, &step_slot->end);
  } else {
    add(op, operation, 0, nullptr);
  }
}

void OperationColumns::add(std::string_view op,
                           const Operation& operation,
                           int tool,
                           const PlacedPoint* at) {
  auto known = i_op_.find(op);
  if (known == i_op_.end()) {
    known = i_op_.emplace(std::string(op), static_cast<std::uint8_t>(ops_.size())).first;
    ops_.emplace_back(op);
  }
  op_.push_back(known->second);
  line_.push_back(operation.line);
  tool_.push_back(tool);
  const InstancePath path(operation.path.begin(), operation.path.end());
  const auto board = i_board_.emplace(path, static_cast<std::uint32_t>(boards_.size()));
  if (board.second) boards_.push_back(path);
  board_.push_back(board.first->second);
  diameters_mm_.push_back(at != nullptr ? diameter_mm_ : kNone);
  const auto add_point = [&](std::vector<double>& to, const Eigen::Vector2d& point) {
    to.insert(to.end(), {point.x(), point.y()});
  };
  const Eigen::Vector2d none(kNone, kNone);
  add_point(nominal_mm_, at != nullptr ? at->nominal.in_mm() : none);
  add_point(actual_mm_, at != nullptr ? at->actual.in_mm() : none);
  for (int i = 0; i < 4; ++i) cov_mm2_.push_back(at != nullptr ? at->cov_mm2(i / 2, i % 2) : kNone);
  risk_.push_back(at != nullptr && at->risk ? *at->risk : kNone);
}

py::dict OperationColumns::take() {
  py::dict out;
  out["ops"] = ops_;
  out["op"] = array_of(std::move(op_));
  out["line"] = array_of(std::move(line_));
  out["tool"] = array_of(std::move(tool_));
  out["board"] = array_of(std::move(board_));
  out["boards"] = boards_;
  out["diameter_mm"] = array_of(std::move(diameters_mm_));
  out["nominal_mm"] = array_of(std::move(nominal_mm_), {2});
  out["actual_mm"] = array_of(std::move(actual_mm_), {2});
  out["cov_mm2"] = array_of(std::move(cov_mm2_), {2, 2});
  out["risk"] = array_of(std::move(risk_));
  return out;
}

}  // namespace panelcal::python
