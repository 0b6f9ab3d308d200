// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/base/fields/json_file.h"
#include "calib/base/json/json_line.h"
#include "program/walk/probing.h"

// Not installed.
namespace panelcal::internal {

/// A request, or the reading of one Z axis or that nothing was found, as a line has it.
struct ProbeLine {
  ProbeRequest request;
  ProbeStatus status = ProbeStatus::NotFound;
  std::optional<int> axis;  ///< of a reading that was found, as the following
  std::optional<Length> height;
  std::optional<Length> sigma;
  std::string reason;
};

/// Reads a line as to_json(ProbeReading) writes it.
///
/// Fails  measurement-file; measurement-invalid: a sigma out of its range
Expected<ProbeLine> probe_line_of(const JsonLine& line);

JsonFile probes_file();

}  // namespace panelcal::internal
