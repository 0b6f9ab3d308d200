// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/base/json/json_line.h"
#include "machine/sources/recorded_ranges.h"
#include "program/model/pattern_file.h"
#include "program/model/placement.h"

// Not installed: reading files of measurements and files of probe readings.
namespace panelcal::internal {

/// Gives each line of a JSON Lines text that is not blank to `take`, with its number from 1.
///
/// Fails  measurement-file (a line of more than 64 KiB); json-syntax; what `take` reports
Expected<void> read_recorded_lines(
    std::string_view text,
    const std::string& file,
    const std::function<Expected<void>(const JsonLine& line, int number)>& take);

/// A whole number from 0 to `high`.
Expected<int> recorded_int(const JsonLine& line,
                           std::string_view key,
                           int high = std::numeric_limits<int>::max());

/// The copies that a request stands in, outermost first.
Expected<InstancePath> recorded_path(const JsonLine& line);

/// The line of a request in its program, or in a stored pattern's file, and its command.
template <class Request>
Expected<void> read_origin(const JsonLine& line, Request& request) {
  PANELCAL_TRY(request.line, recorded_int(line, "line"));
  PANELCAL_CHECK(read_pattern(line, Code::MeasurementFile, request.file, request.file_sha256));
  PANELCAL_TRY(request.command, line.text("command", Code::MeasurementFile));
  return {};
}

/// The nominal and the expected place of a request, and its copies.
template <class Request>
Expected<void> read_places(const JsonLine& line, Request& request) {
  PANELCAL_TRY(const Eigen::Vector2d nominal_mm,
               recorded_place(line, "nominal", Code::MeasurementFile));
  request.nominal = position_mm<frame::Nominal>(nominal_mm);
  PANELCAL_TRY(const Eigen::Vector2d expected_mm,
               recorded_place(line, "expected", Code::MeasurementFile));
  request.expected = position_mm<frame::Actual>(expected_mm);
  PANELCAL_TRY(request.path, recorded_path(line));
  return {};
}

}  // namespace panelcal::internal
