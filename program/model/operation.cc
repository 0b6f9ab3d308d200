// SPDX-License-Identifier: Apache-2.0
#include "program/model/operation.h"

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
  std::string_view operator()(const PatternBegin&) const { return "pattern"; }
  std::string_view operator()(const PatternEnd&) const { return "pattern_end"; }
  std::string_view operator()(const VisionSeries&) const { return "series"; }
  std::string_view operator()(const TargetHole&) const { return "target_hole"; }
  std::string_view operator()(const CancelCorrection&) const { return "cancel_correction"; }
  std::string_view operator()(const StoredCorrection&) const { return "stored_correction"; }
  std::string_view operator()(const VisionTool&) const { return "vision_tool"; }
  std::string_view operator()(const OpticalOrder&) const { return "optical_order"; }
  std::string_view operator()(const SurfaceOrder&) const { return "surface"; }
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
    case StopKind::EndAccepted:
      return "end_accepted";
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
    case FunctionKind::PulseOn:
      return "pulse_on";
    case FunctionKind::PulseOff:
      return "pulse_off";
    case FunctionKind::BreakageCheckOn:
      return "breakage_check_on";
    case FunctionKind::BreakageCheckOff:
      return "breakage_check_off";
    case FunctionKind::MachineFunction:
      return "machine_function";
    case FunctionKind::MachineZero:
      return "machine_zero";
    case FunctionKind::ParkPosition:
      return "park_position";
    case FunctionKind::CheckArea:
      return "check_area";
    case FunctionKind::ForbiddenArea:
      return "forbidden_area";
    case FunctionKind::HoleOmitted:
      return "hole_omitted";
    case FunctionKind::FinishRouting:
      return "finish_routing";
    case FunctionKind::RetractProbe:
      return "retract_probe";
    case FunctionKind::TextForDevice:
      return "text_for_device";
  }
  return "";
}

std::string_view name(Dialect dialect) {
  return dialect == Dialect::Excellon ? "Excellon CNC-7" : "SIEB & MEYER";
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
