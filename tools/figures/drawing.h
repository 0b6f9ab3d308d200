// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace panelcal::report {

/// A drawing of its own size in px.
struct Drawing {
  std::string content;  ///< SVG elements, from (0, 0) to (width, height)
  double width = 0;
  double height = 0;
};

}  // namespace panelcal::report
