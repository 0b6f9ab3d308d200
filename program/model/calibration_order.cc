// SPDX-License-Identifier: Apache-2.0
#include "program/model/calibration_order.h"

#include <iterator>

#include "program/text/json_text.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// The settings are orders to the camera, not a part of what is recorded: as of a focus.
void append_order(std::string& out, const CalibrationOrder& order) {
  auto to = std::back_inserter(out);
  fmt::format_to(to, "{{\"calibration\":{},\"line\":{},\"command\":", order.number, order.line);
  append_json_string(out, order.command);
  fmt::format_to(to, ",\"path\":[{}]", fmt::join(order.path, ","));
  append_pattern(out, order.pattern());
  if (order.first_hole) {
    const Eigen::Vector2d& first_mm = order.first_hole->in_mm();
    fmt::format_to(to, ",\"first_hole\":[{},{}]", first_mm.x(), first_mm.y());
  }
  if (order.lamp) fmt::format_to(to, ",\"lamp\":{}", *order.lamp);
  if (order.zoom) fmt::format_to(to, ",\"zoom\":{}", *order.zoom);
}

}  // namespace

std::string to_json(const CalibrationOrder& order) {
  std::string out;
  append_order(out, order);
  return out + "}";
}

std::string to_json(const CalibrationAnswer& answer) {
  std::string out;
  append_order(out, answer.order);
  auto to = std::back_inserter(out);
  if (answer.offset) {
    const Eigen::Vector2d& offset_mm = answer.offset->offset.in_mm();
    const Eigen::Matrix2d& cov_mm2 = answer.offset->cov_mm2;
    fmt::format_to(to, ",\"offset\":[{},{}]", offset_mm.x(), offset_mm.y());
    fmt::format_to(to, ",\"cov\":[{},{},{}]", cov_mm2(0, 0), cov_mm2(0, 1), cov_mm2(1, 1));
  }
  out += ",\"text\":";
  append_json_string(out, answer.text);
  return out + "}";
}

std::string describe(const CalibrationOrder& order) {
  return fmt::format("calibration {} ({}, line {})", order.number, order.command, order.line);
}

}  // namespace panelcal
