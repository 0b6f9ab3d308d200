// SPDX-License-Identifier: Apache-2.0
#include "program/model/measurement.h"

#include <algorithm>
#include <array>
#include <utility>

namespace panelcal {
namespace {

constexpr std::array<std::pair<MeasurementStatus, std::string_view>, 6> kStatusNames = {{
    {MeasurementStatus::Found, "found"},
    {MeasurementStatus::NotFound, "not_found"},
    {MeasurementStatus::Ambiguous, "ambiguous"},
    {MeasurementStatus::Rejected, "rejected"},
    {MeasurementStatus::Skipped, "skipped"},
    {MeasurementStatus::BoardLeftOut, "board_left_out"},
}};

/// In the order of the enumerators; the source's own decision has no word.
constexpr std::array<std::string_view, 6> kDeciderNames = {
    "", "camera", "candidate", "hand", "skip", "leave_board_out"};

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

std::string_view name(Decider decider) {
  return kDeciderNames[static_cast<std::size_t>(decider)];
}

std::optional<Decider> decider_from_name(std::string_view name) {
  const auto found = std::ranges::find(kDeciderNames, name);
  if (name.empty() || found == kDeciderNames.end()) return std::nullopt;
  return static_cast<Decider>(found - kDeciderNames.begin());
}

Expected<std::optional<Measurement>> MeasurementSource::reconsider(const Contradiction&) {
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

}  // namespace panelcal
