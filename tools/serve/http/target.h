// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace panelcal::serve {

/// The address that a request asks for: a path, and the parameters behind `?`.
struct Target {
  std::string path;  ///< letters, digits and `/ . - _` only, so that none can be read in two ways
  std::map<std::string, std::string> parameters;  ///< decoded; any bytes but NUL
};

/// Nothing: a path with another character, an escape without two digits, a parameter that appears
/// twice.
std::optional<Target> parse_target(std::string_view text);

}  // namespace panelcal::serve
