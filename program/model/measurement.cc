// SPDX-License-Identifier: Apache-2.0
#include "program/model/measurement.h"

#include <algorithm>
#include <array>
#include <utility>

#include "calib/base/append_format.h"
#include "program/text/json_text.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::array<std::pair<MeasurementStatus, std::string_view>, 4> kStatusNames = {{
    {MeasurementStatus::Found, "found"},
    {MeasurementStatus::NotFound, "not_found"},
    {MeasurementStatus::Ambiguous, "ambiguous"},
    {MeasurementStatus::Rejected, "rejected"},
}};

void append_settings(std::string& out, const VisionSettings& settings) {
  if (settings.tools.size() > 1) {
    internal::append_format(out, ",\"tools\":[{}]", fmt::join(settings.tools, ","));
  }
  if (settings.delta) internal::append_format(out, ",\"delta\":{}", settings.delta->in_mm());
  if (settings.inspections != 1)
    internal::append_format(out, ",\"inspections\":{}", settings.inspections);
  if (settings.search) internal::append_format(out, ",\"search\":{}", *settings.search);
  if (settings.search_area) {
    internal::append_format(out, ",\"search_area\":{}", settings.search_area->in_mm());
  }
  if (settings.lamp) internal::append_format(out, ",\"lamp\":{}", *settings.lamp);
  if (settings.zoom) internal::append_format(out, ",\"zoom\":{}", *settings.zoom);
  if (settings.algorithm) internal::append_format(out, ",\"algorithm\":{}", *settings.algorithm);
}

/// A lone candidate that was found is the measured place.
bool lists_more_than_found(const Measurement& measurement) {
  const std::vector<MeasuredCandidate>& all = measurement.candidates;
  return measurement.status == MeasurementStatus::Found ? all.size() > 1 : !all.empty();
}

void append_candidates(std::string& out, const Measurement& measurement) {
  if (lists_more_than_found(measurement)) {
    std::string places;
    std::string by_camera;
    for (const MeasuredCandidate& c : measurement.candidates) {
      const Eigen::Vector2d& at_mm = c.place.position.in_mm();
      const Eigen::Matrix2d& cov_mm2 = c.place.cov;
      internal::append_format(places,
                              "{}{},{},{},{},{},{},{}",
                              places.empty() ? "" : ",",
                              at_mm.x(),
                              at_mm.y(),
                              cov_mm2(0, 0),
                              cov_mm2(0, 1),
                              cov_mm2(1, 1),
                              c.score,
                              c.counts ? 1 : 0);
      const Eigen::Matrix<double, 2, 5, Eigen::RowMajor> rows = c.by_camera;
      internal::append_format(by_camera,
                              "{}{}",
                              by_camera.empty() ? "" : ",",
                              internal::joined({rows.data(), rows.SizeAtCompileTime}, ","));
    }
    internal::append_format(
        out, ",\"candidates\":[{}],\"candidates_by_camera\":[{}]", places, by_camera);
  }
  if (!measurement.listed) return;
  std::vector<double> corners_mm;
  for (const Position<frame::Actual>& corner : measurement.listed->corners) {
    corners_mm.insert(corners_mm.end(), {corner.in_mm().x(), corner.in_mm().y()});
  }
  internal::append_format(out, ",\"listed_area\":[{}]", internal::joined(corners_mm, ","));
  if (measurement.listed->radius) {
    internal::append_format(out, ",\"search_radius\":{}", measurement.listed->radius->in_mm());
  }
}

/// Focusing has no seq, and needs no vision tool.
void append_request(std::string& out, const MeasurementRequest& request) {
  const Eigen::Vector2d& nominal_mm = request.nominal.in_mm();
  const Eigen::Vector2d& expected_mm = request.expected.in_mm();
  const bool is_focus = request.seq < 0;
  if (is_focus) {
    out += "{\"focus\":true";
  } else {
    internal::append_format(out, "{{\"seq\":{}", request.seq);
  }
  internal::append_format(out, ",\"line\":{},\"command\":\"{}\"", request.line, request.command);
  if (!is_focus) {
    const std::vector<int>& tools = request.settings.tools;
    internal::append_format(out, ",\"tool\":{}", tools.empty() ? 0 : tools.front());
  }
  internal::append_format(out,
                          ",\"nominal\":[{},{}],\"expected\":[{},{}],\"path\":[{}]",
                          nominal_mm.x(),
                          nominal_mm.y(),
                          expected_mm.x(),
                          expected_mm.y(),
                          fmt::join(request.path, ","));
  append_pattern(out, request.pattern());
  if (request.axes != ObservedAxes::Both) {
    out += request.axes == ObservedAxes::X ? ",\"axes\":\"x\"" : ",\"axes\":\"y\"";
  }
  append_settings(out, request.settings);
}

}  // namespace

bool Measurement::has_choice() const {
  return std::ranges::count(candidates, true, &MeasuredCandidate::counts) > 1;
}

std::string_view name(MeasurementStatus status) {
  return kStatusNames[static_cast<std::size_t>(status)].second;
}

std::optional<MeasurementStatus> measurement_status_from_name(std::string_view name) {
  for (const auto& [status, status_name] : kStatusNames) {
    if (status_name == name) return status;
  }
  return std::nullopt;
}

Expected<std::optional<FocusResult>> MeasurementSource::focus(const MeasurementRequest&) {
  return std::nullopt;
}

Expected<std::optional<CalibrationAnswer>> MeasurementSource::calibrate(const CalibrationOrder&) {
  return std::nullopt;
}

Expected<std::optional<CalibrationAnswer>> NominalSource::calibrate(const CalibrationOrder& order) {
  CalibrationAnswer answer;
  answer.order = order;
  answer.text = "nothing was moved";
  return answer;
}

Expected<Measurement> NominalSource::measure(const MeasurementRequest& request) {
  // One micrometre: any positive covariance does, the answer is exact.
  constexpr double kVariance_mm2 = 1e-6;
  Measurement measurement{.request = request, .status = MeasurementStatus::Found};
  measurement.measured = {request.expected, kVariance_mm2 * Eigen::Matrix2d::Identity()};
  return measurement;
}

std::string to_json(const MeasurementRequest& request) {
  std::string out;
  append_request(out, request);
  return out + "}";
}

std::string to_json(const Measurement& measurement) {
  std::string out;
  append_request(out, measurement.request);
  if (measurement.status == MeasurementStatus::Found) {
    const Eigen::Vector2d& measured_mm = measurement.measured.position.in_mm();
    const Eigen::Matrix2d& cov_mm2 = measurement.measured.cov;
    internal::append_format(out, ",\"measured\":[{},{}]", measured_mm.x(), measured_mm.y());
    internal::append_format(
        out, ",\"cov\":[{},{},{}]", cov_mm2(0, 0), cov_mm2(0, 1), cov_mm2(1, 1));
    if (measurement.by_camera) {
      const Eigen::Matrix<double, 2, 5, Eigen::RowMajor> rows = *measurement.by_camera;
      internal::append_format(
          out, ",\"by_camera\":[{}]", internal::joined({rows.data(), rows.SizeAtCompileTime}, ","));
    }
  }
  if (measurement.scatter) {
    const Eigen::Vector2d& scatter_mm = measurement.scatter->in_mm();
    internal::append_format(out, ",\"scatter\":[{},{}]", scatter_mm.x(), scatter_mm.y());
  }
  if (measurement.score) internal::append_format(out, ",\"score\":{}", *measurement.score);
  if (!measurement.image.empty()) {
    out += ",\"image\":";
    append_json_string(out, measurement.image);
  }
  internal::append_format(out, ",\"status\":\"{}\"", name(measurement.status));
  if (!measurement.reason.empty()) {
    out += ",\"reason\":";
    append_json_string(out, measurement.reason);
  }
  append_candidates(out, measurement);
  return out + "}";
}

}  // namespace panelcal
