// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/plan/output/facts.h"

namespace panelcal::plan {

/// The plan as `panelcal plan` prints it.
std::string plan_text(const Plan& plan, const Survey& survey);

}  // namespace panelcal::plan
