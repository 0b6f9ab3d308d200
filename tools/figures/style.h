// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace panelcal::report {

/// The style sheet of the report: light and dark screens, narrow ones, paper.
extern const std::string_view kStyle;

}  // namespace panelcal::report
