// SPDX-License-Identifier: Apache-2.0
#include "tools/locate/located_json.h"

#include <cstddef>
#include <string_view>

#include "calib/base/append_format.h"
#include "calib/base/json/json_string.h"
#include "vision/show/overlay.h"
namespace panelcal {
namespace {

void append_point(std::string& out, const Eigen::Vector2d& v_px) {
  internal::append_format(out, "[{},{}]", v_px.x(), v_px.y());
}

void append_center(std::string& out, const TargetFit& fit) {
  const Eigen::Matrix2d& cov_px2 = fit.center.cov;
  out += ",\"center_px\":";
  append_point(out, fit.center.position.in_px());
  internal::append_format(
      out,
      ",\"cov_px\":[{},{},{}],\"size_px\":{:.4f},\"angle_rad\":{:.6f},\"score\":{:.4f}",
      cov_px2(0, 0),
      cov_px2(0, 1),
      cov_px2(1, 1),
      fit.size.in_px(),
      fit.angle.in_rad(),
      fit.score);
}

void append_details(std::string& out, const TargetFit& fit) {
  internal::append_format(out,
                          ",\"visible\":{:.4f},\"blur_px\":{:.4f},\"noise\":{:.4f}",
                          fit.visible,
                          fit.blur_px,
                          fit.noise);
  if (fit.axis_ratio != 1) internal::append_format(out, ",\"axis_ratio\":{:.6f}", fit.axis_ratio);
  if (!fit.hole_offset_px.isZero(0)) {
    out += ",\"hole_offset_px\":";
    append_point(out, fit.hole_offset_px);
  }
  if (fit.blind_direction) {
    internal::append_format(out, ",\"blind_rad\":{:.6f}", fit.blind_direction->in_rad());
  }
  if (fit.tag_id) internal::append_format(out, ",\"id\":{}", *fit.tag_id);
  if (fit.corners.empty()) return;
  out += ",\"corners_px\":[";
  for (std::size_t i = 0; i < fit.corners.size(); ++i) {
    if (i > 0) out += ',';
    append_point(out, fit.corners[i].position.in_px());
  }
  out += ']';
}

void append_others(std::string& out, const Detection& detection) {
  out += ",\"others\":[";
  std::string_view separator = "";
  for (const Candidate& other : other_candidates(detection)) {
    out += separator;
    separator = ",";
    out += "{\"center_px\":";
    append_point(out, other.center.in_px());
    internal::append_format(
        out, ",\"size_px\":{:.4f},\"score\":{:.4f}", other.size.in_px(), other.score);
    if (!other.reason.empty()) {
      out += ",\"reason\":";
      append_json_string(out, other.reason);
    }
    out += '}';
  }
  out += ']';
}

}  // namespace

std::string located_json(const LocatedTarget& located, const Detection& detection) {
  std::string out = "{\"image\":";
  append_json_string(out, located.image);
  internal::append_format(
      out, ",\"tool\":{},\"status\":\"{}\"", located.tool, name(detection.status));
  const bool is_found = detection.status == DetectionStatus::Found;
  if (is_found) append_center(out, *detection.best);
  internal::append_format(out, ",\"candidates\":{}", detection.n_candidates);
  if (!detection.reason.empty()) {
    out += ",\"reason\":";
    append_json_string(out, detection.reason);
  }
  if (is_found) append_details(out, *detection.best);
  if (located.lists_candidates || detection.status == DetectionStatus::Ambiguous) {
    append_others(out, detection);
  }
  return out + "}\n";
}

}  // namespace panelcal
