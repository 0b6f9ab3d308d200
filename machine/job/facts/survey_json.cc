// SPDX-License-Identifier: Apache-2.0
#include "machine/job/facts/sections.h"

namespace panelcal::facts {
namespace {

Json heights_json(const std::vector<HeightEstimate>& heights) {
  Json out = Json::array();
  for (const HeightEstimate& height : heights) {
    out.push_back(
        {{"height_mm", number(height.height.in_mm())}, {"sigma_um", number(height.sigma.in_um())}});
  }
  return out;
}

Json probe_json(const ProbeReading& reading) {
  const ProbeRequest& request = reading.request;
  return {{"seq", request.seq},
          {"command", request.command},
          {"line", request.line},
          {"file", request.file},
          {"board", board_json(request.path)},
          {"memory", request.memory ? Json(*request.memory) : Json()},
          {"nominal_mm", point(request.nominal.in_mm())},
          {"reference_mm", number(request.reference.in_mm())},
          {"is_found", reading.status == ProbeStatus::Found && !reading.heights.empty()},
          {"reason", reading.reason},
          {"axes", heights_json(reading.heights)}};
}

}  // namespace

Json surface_json(const Survey& survey, const std::string& use) {
  if (survey.probes.empty() && use.empty()) return {};
  Json probes = Json::array();
  for (const ProbeReading& reading : survey.probes) probes.push_back(probe_json(reading));
  Json filled = Json::array();
  for (const FilledNode& node : survey.filled_nodes) {
    filled.push_back({{"place_mm", point(node.place.in_mm())},
                      {"height_from", name(node.source)},
                      {"axes", heights_json(node.heights)}});
  }
  return {{"use", use}, {"probes", probes}, {"filled", filled}};
}

Json focus_json(const Survey& survey) {
  Json rows = Json::array();
  for (const FocusResult& focus : survey.focus) {
    Json curve = Json::array();
    for (const FocusResult::Sample& sample : focus.curve) {
      curve.push_back(
          {{"z_mm", number(sample.z.in_mm())}, {"sharpness", number(sample.sharpness)}});
    }
    rows.push_back({{"line", focus.request.line},
                    {"expected_mm", point(focus.request.expected.in_mm())},
                    {"is_found", focus.is_found},
                    {"reason", focus.reason},
                    {"z_mm", focus.is_found ? number(focus.z.in_mm()) : Json()},
                    {"sigma_um", focus.is_found ? number(focus.sigma.in_um()) : Json()},
                    {"curve", curve}});
  }
  return rows;
}

Json calibrations_json(const Survey& survey) {
  Json rows = Json::array();
  for (const CalibrationAnswer& calibration : survey.calibrations) {
    rows.push_back({{"line", calibration.order.line},
                    {"command", calibration.order.command},
                    {"text", calibration.text}});
  }
  return rows;
}

}  // namespace panelcal::facts
