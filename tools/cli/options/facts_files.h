// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace panelcal {

/// Where a command line wants a command's facts; "-" is standard output, empty: nowhere.
struct FactsFiles {
  std::string json;
  std::string report;  ///< a page that shows them

  bool any() const { return !json.empty() || !report.empty(); }
  bool use_standard_output() const { return json == "-" || report == "-"; }
};

}  // namespace panelcal
