// SPDX-License-Identifier: Apache-2.0
#include "machine/config/toml/command_words.h"

#include <algorithm>

namespace panelcal::internal {

bool has_zero_byte(const CommandWords& words) {
  return std::ranges::any_of(
      words, [](const std::string& word) { return word.find('\0') != std::string::npos; });
}

void look_for_program(CommandWords& words, const std::filesystem::path& folder) {
  const std::filesystem::path program = words.front();
  if (!program.has_parent_path() || program.is_absolute()) return;
  // A bare name would be looked for in PATH.
  words.front() = ((folder.empty() ? "." : folder) / program).string();
}

}  // namespace panelcal::internal
