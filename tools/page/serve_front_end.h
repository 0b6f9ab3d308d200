// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace panelcal {

/// The operator's screen of web/serve/ (cmake/bundle_web.cmake): `/`, `/app.js` and `/app.css` of
/// `panelcal serve`. The page has no script and no style of its own, so that `script-src 'self'`
/// and `style-src 'self'` let it work.
extern const std::string_view kServePage;
extern const std::string_view kServeScript;
extern const std::string_view kServeStyle;

}  // namespace panelcal
