// SPDX-License-Identifier: Apache-2.0
#include "program/model/tool_links.h"

#include <algorithm>

#include "program/text/number_format.h"

namespace panelcal {
namespace {

bool is_link_digits(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

/// Each tool once, where it stands first: going round, a tool has one successor.
std::vector<int> linked_tools(std::string_view text) {
  std::vector<int> tools;
  std::set<int> seen;
  while (true) {
    const auto slash = text.find('/');
    const auto tool = parse_count(text.substr(0, slash));
    if (tool && seen.insert(*tool).second) tools.push_back(*tool);
    if (slash == std::string_view::npos) return tools;
    text.remove_prefix(slash + 1);
  }
}

}  // namespace

bool is_tool_link(std::string_view text) {
  bool has_slash = false;
  while (true) {
    const auto slash = text.find('/');
    if (!is_link_digits(text.substr(0, slash))) return false;
    if (slash == std::string_view::npos) return has_slash;
    has_slash = true;
    text.remove_prefix(slash + 1);
  }
}

void ToolLinks::link(std::string_view text) {
  std::vector<int> tools = linked_tools(text);
  // The latest link of a tool is the one that holds.
  for (std::vector<int>& group : groups_) {
    std::erase_if(group, [&](int tool) { return std::ranges::find(tools, tool) != tools.end(); });
  }
  std::erase_if(groups_, [](const std::vector<int>& group) { return group.empty(); });
  groups_.push_back(std::move(tools));
}

void add_linked_tools(std::string_view text, std::set<int>& used) {
  if (!is_tool_link(text)) return;
  const std::vector<int> tools = linked_tools(text);
  if (std::ranges::any_of(tools, [&](int tool) { return used.contains(tool); })) {
    used.insert(tools.begin(), tools.end());
  }
}

std::optional<int> ToolLinks::next(int tool) const {
  for (const std::vector<int>& group : groups_) {
    const auto found = std::ranges::find(group, tool);
    if (found == group.end()) continue;
    const int next = found + 1 == group.end() ? group.front() : *(found + 1);
    return next == tool ? std::nullopt : std::optional(next);
  }
  return std::nullopt;
}

}  // namespace panelcal
