// SPDX-License-Identifier: Apache-2.0
#include "program/model/operation.h"

#include <array>

namespace panelcal {
namespace {

// Each in the order of its enumerators, or of the alternatives of Operation::what.
constexpr std::array<std::string_view, 26> kOperationNames = {"tool",
                                                              "drill",
                                                              "stop",
                                                              "message",
                                                              "setting",
                                                              "zero_set",
                                                              "position",
                                                              "rout",
                                                              "plunge",
                                                              "retract",
                                                              "compensation",
                                                              "slot",
                                                              "step_slot",
                                                              "dwell",
                                                              "function",
                                                              "rate",
                                                              "autocalibration",
                                                              "pattern",
                                                              "pattern_end",
                                                              "series",
                                                              "target_hole",
                                                              "cancel_correction",
                                                              "stored_correction",
                                                              "vision_tool",
                                                              "optical_order",
                                                              "surface"};
static_assert(kOperationNames.size() == std::variant_size_v<decltype(Operation::what)>);
constexpr std::array<std::string_view, 6> kStopNames = {
    "end", "end_rewind", "end_accepted", "inspection", "optional", "header_end"};
static_assert(kStopNames.size() == static_cast<std::size_t>(StopKind::HeaderEnd) + 1);
constexpr std::array<std::string_view, 21> kFunctionNames = {
    "tool_tip_check",   "peck_on",      "peck_off",          "spindle_group",
    "binary_map",       "scaling_on",   "scaling_off",       "tool_expired",
    "pulse_on",         "pulse_off",    "breakage_check_on", "breakage_check_off",
    "machine_function", "machine_zero", "park_position",     "check_area",
    "forbidden_area",   "hole_omitted", "finish_routing",    "retract_probe",
    "text_for_device"};
static_assert(kFunctionNames.size() == static_cast<std::size_t>(FunctionKind::TextForDevice) + 1);
constexpr std::array<std::string_view, 3> kRoutNames = {"line", "cw", "ccw"};

}  // namespace

void fill_missing(Tool& tool, const Tool& other) {
  for_each_datum(tool, other, [](auto& datum, const auto& of_other) {
    if (!datum) datum = of_other;
  });
}

bool contradict(const Tool& tool, const Tool& other) {
  bool is_other = false;
  for_each_datum(tool, other, [&](const auto& datum, const auto& of_other) {
    is_other |= datum && of_other && *datum != *of_other;
  });
  return is_other;
}

std::string_view operation_name(const Operation& operation) {
  return kOperationNames[operation.what.index()];
}

std::string_view name(StopKind kind) {
  return kStopNames[static_cast<std::size_t>(kind)];
}

std::string_view name(FunctionKind kind) {
  return kFunctionNames[static_cast<std::size_t>(kind)];
}

std::string_view name(RoutKind kind) {
  return kRoutNames[static_cast<std::size_t>(kind)];
}

std::string_view name(Dialect dialect) {
  return dialect == Dialect::Excellon ? "Excellon CNC-7" : "SIEB & MEYER";
}

}  // namespace panelcal
