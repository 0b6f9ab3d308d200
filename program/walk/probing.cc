// SPDX-License-Identifier: Apache-2.0
#include "program/walk/probing.h"

#include "calib/base/append_format.h"
#include "program/text/json_text.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::string_view kFound = "found";
constexpr std::string_view kNotFound = "not_found";

/// Without the closing brace.
std::string open_object(const ProbeRequest& request) {
  const Eigen::Vector2d& nominal_mm = request.nominal.in_mm();
  const Eigen::Vector2d& expected_mm = request.expected.in_mm();
  std::string out =
      fmt::format("{{\"probe\":{},\"line\":{},\"command\":", request.seq, request.line);
  append_json_string(out, request.command);
  internal::append_format(out,
                          ",\"tool\":{},\"nominal\":[{},{}],\"expected\":[{},{}],\"path\":[{}]",
                          request.tool,
                          nominal_mm.x(),
                          nominal_mm.y(),
                          expected_mm.x(),
                          expected_mm.y(),
                          fmt::join(request.path, ","));
  append_pattern(out, request.pattern());
  if (request.memory) internal::append_format(out, ",\"L\":{}", *request.memory);
  if (request.depth) internal::append_format(out, ",\"depth\":{}", request.depth->in_mm());
  internal::append_format(out, ",\"reference\":{}", request.reference.in_mm());
  return out;
}

void close_reading(std::string& out, const ProbeReading& reading) {
  internal::append_format(out, ",\"status\":\"{}\"", name(reading.status));
  if (!reading.reason.empty()) {
    out += ",\"reason\":";
    append_json_string(out, reading.reason);
  }
  out += '}';
}

}  // namespace

std::string describe(const ProbeRequest& request) {
  return fmt::format("{} probe {} (line {})", request.command, request.seq, request.line);
}

std::string_view name(ProbeStatus status) {
  return status == ProbeStatus::Found ? kFound : kNotFound;
}

std::optional<ProbeStatus> probe_status_from_name(std::string_view name) {
  if (name == kFound) return ProbeStatus::Found;
  if (name == kNotFound) return ProbeStatus::NotFound;
  return std::nullopt;
}

Expected<ProbeReading> NominalProbeSource::probe(const ProbeRequest& request) {
  const HeightEstimate exact{request.reference, Length()};
  return ProbeReading{request, ProbeStatus::Found, std::vector<HeightEstimate>(n_axes_, exact), ""};
}

std::string to_json(const ProbeRequest& request) {
  return open_object(request) + "}";
}

std::string to_json(const ProbeReading& reading) {
  const std::string request = open_object(reading.request);
  std::string out;
  if (reading.status != ProbeStatus::Found) {
    out = request;
    close_reading(out, reading);
    return out;
  }
  for (std::size_t axis = 0; axis < reading.heights.size(); ++axis) {
    if (axis > 0) out += '\n';
    out += request;
    internal::append_format(out,
                            ",\"zaxis\":{},\"height\":{},\"sigma\":{}",
                            axis,
                            reading.heights[axis].height.in_mm(),
                            reading.heights[axis].sigma.in_mm());
    close_reading(out, reading);
  }
  return out;
}

}  // namespace panelcal
