// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace panelcal {

/// The modules of web/, joined to one script, and their style sheet (cmake/bundle_web.cmake).
extern const std::string_view kFrontEndScript;
extern const std::string_view kFrontEndStyle;

}  // namespace panelcal
