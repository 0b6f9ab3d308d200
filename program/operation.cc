// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/operation.h"

namespace panelcal {
namespace {

struct NameOf {
  std::string_view operator()(const ToolChange&) const { return "tool"; }
  std::string_view operator()(const Drill&) const { return "drill"; }
  std::string_view operator()(const Stop&) const { return "stop"; }
  std::string_view operator()(const Message&) const { return "message"; }
  std::string_view operator()(const Setting&) const { return "setting"; }
  std::string_view operator()(const ZeroSet&) const { return "zero_set"; }
  std::string_view operator()(const RapidMove&) const { return "position"; }
  std::string_view operator()(const Rout&) const { return "rout"; }
  std::string_view operator()(const Plunge&) const { return "plunge"; }
  std::string_view operator()(const Retract&) const { return "retract"; }
  std::string_view operator()(const Compensation&) const { return "compensation"; }
  std::string_view operator()(const Slot&) const { return "slot"; }
  std::string_view operator()(const StepSlot&) const { return "step_slot"; }
  std::string_view operator()(const Dwell&) const { return "dwell"; }
  std::string_view operator()(const Function&) const { return "function"; }
  std::string_view operator()(const ToolRate&) const { return "rate"; }
  std::string_view operator()(const Autocalibration&) const { return "autocalibration"; }
};

}  // namespace

std::string_view operation_name(const Operation& operation) {
  return std::visit(NameOf{}, operation.what);
}

std::string_view name(StopKind kind) {
  switch (kind) {
    case StopKind::EndNoRewind:
      return "end";
    case StopKind::EndRewind:
      return "end_rewind";
    case StopKind::Inspection:
      return "inspection";
    case StopKind::Optional:
      return "optional";
    case StopKind::HeaderEnd:
      return "header_end";
  }
  return "";
}

std::string_view name(FunctionKind kind) {
  switch (kind) {
    case FunctionKind::ToolTipCheck:
      return "tool_tip_check";
    case FunctionKind::PeckOn:
      return "peck_on";
    case FunctionKind::PeckOff:
      return "peck_off";
    case FunctionKind::SpindleGroup:
      return "spindle_group";
    case FunctionKind::BinaryMap:
      return "binary_map";
    case FunctionKind::ScalingOn:
      return "scaling_on";
    case FunctionKind::ScalingOff:
      return "scaling_off";
    case FunctionKind::ToolExpired:
      return "tool_expired";
  }
  return "";
}

std::string_view name(RoutKind kind) {
  switch (kind) {
    case RoutKind::Line:
      return "line";
    case RoutKind::Clockwise:
      return "cw";
    case RoutKind::Counterclockwise:
      return "ccw";
  }
  return "";
}

}  // namespace panelcal
