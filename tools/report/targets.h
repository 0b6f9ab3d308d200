// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "tools/report/input/facts.h"
#include "tools/report/input/input.h"

namespace panelcal::report {

/// A card for every measured target with its picture and numbers: refused ones first, then one
/// group a series, closed where there are many.
std::string target_cards(const ReportInput& input, std::span<const TargetFact> facts);

}  // namespace panelcal::report
