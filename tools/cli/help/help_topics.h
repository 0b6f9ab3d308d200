// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace panelcal {

/// A reference page in Markdown, made from the tables that the program itself uses: `diagnostics`,
/// `excellon`, `sieb-meyer`. docs/diagnostics.md, docs/excellon_commands.md and
/// docs/sieb_meyer_commands.md are these pages. Empty for any
/// other topic.
std::optional<std::string> help_topic(std::string_view topic);

}  // namespace panelcal
