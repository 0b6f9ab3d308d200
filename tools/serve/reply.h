// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "calib/base/diagnostic.h"
#include "tools/serve/http/message.h"

// Responses with the headers that each of them has.
namespace panelcal::serve {

/// The things that a document may load and run, and the sites that may show it in a frame.
enum class Policy : unsigned char {
  Nothing,  ///< no document: what a browser shows of it does nothing
  Screen,   ///< the front end of web/serve: its own script and style, nothing inline
  Report,   ///< a page of tools/page, which names its one script itself: apart from this server
};

/// In     content_type: such as "application/json"
Response reply(int status,
               std::string_view content_type,
               std::string body,
               Policy policy = Policy::Nothing);

/// {"error":{"what":"...","expected":"...","code":"..."}}
Response error_reply(int status, std::string_view what, std::string_view expected);
/// The same of what the machine refused: 400.
Response error_reply(const Diagnostic& diagnostic);

}  // namespace panelcal::serve
