// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/plan/output/facts.h"

namespace panelcal::plan {

/// The plan as one JSON object with a line end: docs/formats/plan.md.
std::string plan_json(const Plan& plan, const Program& program);

}  // namespace panelcal::plan
