// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace panelcal {

/// Statements of a CAM system about a drill file, in comments, as Gerber's X2 attributes.
///
/// Source Gerber Layer Format Specification 2022.02, 5.6.3 (.FileFunction), 5.6.10 (.AperFunction);
///        KiCad writes them behind `; #@! `
struct DrillAttributes {
  std::string file_function;             ///< "Plated,1,2,PTH"; empty: not stated
  std::map<int, std::string> functions;  ///< by tool: "Plated,PTH,ComponentDrill"

  bool is_empty() const { return file_function.empty() && functions.empty(); }
  /// "plated holes of layers 1 to 2: T1 ComponentDrill, T2 ViaDrill"; empty if nothing is stated.
  std::string text() const;
};

/// Looks at the comments ahead of the first coordinate.
DrillAttributes read_drill_attributes(std::string_view program);

}  // namespace panelcal
