// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/plan/output/facts.h"

namespace panelcal::plan {

/// The frame of the pictures.
struct PlanPage {
  std::string program_file;
  std::string machine_name;
  std::vector<std::pair<std::string, std::string>> provenance;
};

/// All pictures on one sheet: a row for each series, then the order of visits.
std::string plan_svg(const Plan& plan, const PlanPage& page);

/// Pictures, tables and advice on one page that needs no other file.
std::string plan_html(const Plan& plan, const Survey& survey, const PlanPage& page);

}  // namespace panelcal::plan
