// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace panelcal {

/// Files of a command's facts, as the command line names them; "-" is standard output, empty: none.
struct FactsFiles {
  std::string json;
  std::string report;  ///< a page that shows them

  bool any() const { return !json.empty() || !report.empty(); }
  bool use_standard_output() const { return json == "-" || report == "-"; }
};

}  // namespace panelcal
