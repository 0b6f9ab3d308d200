// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "machine/job/summary/worst_hole.h"

namespace panelcal {

namespace report {

/// "Where the uncertainty comes from": the budget of a hole, and which errors all holes share.
/// Empty without one.
std::string budget_section(const std::optional<HoleBudget>& hole);

}  // namespace report
}  // namespace panelcal
