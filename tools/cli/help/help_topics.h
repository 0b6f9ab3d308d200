// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace panelcal {

/// A topic of `panelcal help` besides the commands.
struct HelpTopic {
  std::string_view name;
  std::string_view summary;
};

std::span<const HelpTopic> help_topics();

/// A reference page in Markdown, made from the tables that the program itself uses: `diagnostics`,
/// `excellon`, `sieb-meyer`, `machine.toml`, `json-files`; or a JSON Schema: `machine.schema.json`,
/// `camera.cal.schema.json` and so on. The files of docs/ and share/schema/ that
/// tests/tools/CMakeLists.txt lists are these pages. Empty for any other topic.
std::optional<std::string> help_topic(std::string_view topic);

}  // namespace panelcal
