// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <set>
#include <string_view>
#include <vector>

namespace panelcal {

/// `#/#/#` links tools (CNC-7 manual, Link Tools for Automatic Tool Changers).
bool is_tool_link(std::string_view text);

/// Adds the tools of a link to `used` if one of them is in it: spares are used too.
void add_linked_tools(std::string_view text, std::set<int>& used);

/// Successors of tools that are used up (CNC-7 manual, Link Tools).
class ToolLinks {
 public:
  /// Precondition: is_tool_link(text).
  void link(std::string_view text);
  void clear() { groups_.clear(); }
  /// The tool right of `tool` in its group, counting round.
  std::optional<int> next(int tool) const;

 private:
  std::vector<std::vector<int>> groups_;
};

}  // namespace panelcal
