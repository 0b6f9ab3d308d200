// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace panelcal {

/// Appends `text` for an XML element or a quoted attribute. What XML cannot hold (control bytes,
/// bytes that are not valid UTF-8) comes out as a question mark.
void append_xml_text(std::string& out, std::string_view text);

}  // namespace panelcal
