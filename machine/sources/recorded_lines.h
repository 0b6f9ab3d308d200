// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/base/json/json_line.h"

// Not installed: reading files of measurements and files of probe readings.
namespace panelcal::internal {

/// Gives each line of a JSON Lines text that is not blank to `take`, with its number from 1.
///
/// Fails  measurement-file (a line of more than 64 KiB); json-syntax; what `take` reports
Expected<void> read_recorded_lines(
    std::string_view text,
    const std::string& file,
    const std::function<Expected<void>(const JsonLine& line, int number)>& take);

}  // namespace panelcal::internal
