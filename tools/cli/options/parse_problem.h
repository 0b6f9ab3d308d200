// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "calib/base/diagnostic.h"

namespace panelcal {

/// A refusal of CLI11 in the form of our own.
///
/// In     kind: CLI11's name of the error, such as "RequiredError"; text: its message; extras: the
///        arguments that were not expected, in the order of the command line; else empty
/// Out    a diagnostic in the name of `command`, such as "panelcal run"
/// See    tests/golden/cli
Diagnostic parse_problem(std::string_view kind,
                         std::string_view text,
                         std::span<const std::string> extras,
                         const std::string& command);

}  // namespace panelcal
