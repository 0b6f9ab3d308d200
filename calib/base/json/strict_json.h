// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include <nlohmann/json.hpp>

// Not installed: public headers know nothing of JSON.
namespace panelcal::internal {

/// Calibration files nest three deep; a file of a million brackets is not one of them.
inline constexpr std::size_t kMaxJsonDepth = 16;

/// Parses JSON as RFC 8259 has it, and refuses what parsers commonly let pass: keys that appear
/// twice, numbers too large for a double, nesting beyond kMaxJsonDepth.
///
/// Fails  json-syntax, with line and column where the text stops making sense
Expected<nlohmann::json> parse_strict_json(std::string_view text, const std::string& file);

}  // namespace panelcal::internal
