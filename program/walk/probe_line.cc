// SPDX-License-Identifier: Apache-2.0
#include "program/walk/probe_line.h"

#include "calib/base/fields/json.h"
#include "program/model/line_fields.h"
#include "program/model/recorded.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

std::string_view probe_status_name(ProbeStatus status) {
  return name(status);
}

#include "program/walk/probe.def"

ProbeLine written_probe(const ProbeRequest& request) {
  ProbeLine line;
  line.request = request;
  line.request.file = without_folders(request.file);
  return line;
}

}  // namespace

Expected<ProbeLine> probe_line_of(const JsonLine& line) {
  PANELCAL_TRY(ProbeLine read, read_line(kProbeLine, line, kLineCode));
  PANELCAL_CHECK(check_pattern(line, read.request.file));
  for (const std::string_view key : {"zaxis", "height", "sigma"}) {
    if (line.has(key) == (read.status == ProbeStatus::Found)) continue;
    if (!line.has(key)) return failure(line.missing(key, kLineCode));
    return failure(line.problem(key, kLineCode, "no height unless status is found"));
  }
  if (read.sigma && !kRecordedSigma.contains(read.sigma->in_mm())) {
    return failure(line.problem("sigma", Code::MeasurementInvalid, kRecordedSigma.text()));
  }
  return read;
}

JsonFile probes_file() {
  return {"probes.jsonl",
          "One object a line: `panelcal survey` prints requests, the first form, `run "
          "--save-probes` writes readings, and `run --probes` reads them. See "
          "docs/formats/probes.md.",
          {&kProbeRequestLine, &kProbeLine}};
}

}  // namespace panelcal::internal

namespace panelcal {

std::string to_json(const ProbeRequest& request) {
  return internal::json_text(
      internal::kProbeRequestLine, internal::written_probe(request), internal::JsonStyle::Line);
}

std::string to_json(const ProbeReading& reading) {
  internal::ProbeLine line = internal::written_probe(reading.request);
  line.status = reading.status;
  line.reason = reading.reason;
  const auto text = [&] {
    return internal::json_text(internal::kProbeLine, line, internal::JsonStyle::Line);
  };
  if (reading.status != ProbeStatus::Found) return text();
  std::string out;
  for (std::size_t axis = 0; axis < reading.heights.size(); ++axis) {
    if (axis > 0) out += '\n';
    line.axis = static_cast<int>(axis);
    line.height = reading.heights[axis].height;
    line.sigma = reading.heights[axis].sigma;
    out += text();
  }
  return out;
}

}  // namespace panelcal
