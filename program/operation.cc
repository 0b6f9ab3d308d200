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
};

}  // namespace

std::string_view operation_name(const Operation& operation) {
  return std::visit(NameOf{}, operation.what);
}

}  // namespace panelcal
