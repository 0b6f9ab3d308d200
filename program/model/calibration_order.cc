// SPDX-License-Identifier: Apache-2.0
#include "program/model/calibration_order.h"

#include "calib/base/append_format.h"
#include "program/text/json_text.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// The settings are orders to the camera, not a part of what is recorded: as of a focus.
void append_order(std::string& out, const CalibrationOrder& order) {
  internal::append_format(
      out, "{{\"calibration\":{},\"line\":{},\"command\":", order.number, order.line);
  append_json_string(out, order.command);
  internal::append_format(out, ",\"path\":[{}]", fmt::join(order.path, ","));
  append_pattern(out, order.pattern());
  if (order.first_hole) {
    const Eigen::Vector2d& first_mm = order.first_hole->in_mm();
    internal::append_format(out, ",\"first_hole\":[{},{}]", first_mm.x(), first_mm.y());
  }
  if (order.lamp) internal::append_format(out, ",\"lamp\":{}", *order.lamp);
  if (order.zoom) internal::append_format(out, ",\"zoom\":{}", *order.zoom);
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
  if (answer.offset) {
    const Eigen::Vector2d& offset_mm = answer.offset->offset.in_mm();
    const Eigen::Matrix2d& cov_mm2 = answer.offset->cov_mm2;
    internal::append_format(out, ",\"offset\":[{},{}]", offset_mm.x(), offset_mm.y());
    internal::append_format(
        out, ",\"cov\":[{},{},{}]", cov_mm2(0, 0), cov_mm2(0, 1), cov_mm2(1, 1));
  }
  out += ",\"text\":";
  append_json_string(out, answer.text);
  return out + "}";
}

std::string describe(const CalibrationOrder& order) {
  return fmt::format("calibration {} ({}, line {})", order.number, order.command, order.line);
}

}  // namespace panelcal
