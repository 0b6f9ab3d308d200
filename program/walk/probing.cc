// SPDX-License-Identifier: Apache-2.0
#include "program/walk/probing.h"

#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::string_view kFound = "found";
constexpr std::string_view kNotFound = "not_found";

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

}  // namespace panelcal
