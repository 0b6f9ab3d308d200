// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/json/facts.h"
#include "tools/cli/provenance.h"
#include "tools/plan/output/facts.h"

namespace panelcal::plan {

/// The parts of a document of facts besides the plan.
struct PlanOrigin {
  std::string program;  ///< the file
  std::string machine;  ///< its name; may be empty
  Provenance provenance;
};

/// Everything that is known about the targets before they are measured, with what the leverage of
/// further ones and of others follows from: docs/formats/plan.md, share/schema/plan.schema.json.
///
/// In     survey: as for make_plan()
facts::Json plan_facts(const Plan& plan, const Survey& survey, const PlanOrigin& origin);

}  // namespace panelcal::plan
