// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/output_paths.h"

#include <algorithm>
#include <system_error>
#include <vector>

namespace panelcal {

using Path = std::filesystem::path;

bool is_same_file(const Path& input, const Path& output) {
  const Path file = input == "-" ? Path("/dev/stdin") : input;
  std::error_code ignored;
  return file.lexically_normal() == output.lexically_normal() ||
         std::filesystem::equivalent(file, output, ignored);
}

std::string extension_of(const Path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return extension;
}

/// Files appear whole under their names: a device or a pipe cannot be replaced.
static Expected<void> check_replaceable(std::string_view command, const std::string& output) {
  std::error_code ignored;
  const auto status = std::filesystem::status(output, ignored);
  const bool is_file = !std::filesystem::exists(status) ||
                       std::filesystem::is_regular_file(status) ||
                       std::filesystem::is_directory(status);
  if (output == "-" || is_file) return {};
  return failure({Code::Usage,
                  {std::string(command), 0, 0},
                  quoted(output) + " is a device or a pipe",
                  "a regular file, or - for standard output"});
}

Expected<void> check_output_paths(std::string_view command,
                                  std::initializer_list<std::string> inputs,
                                  std::initializer_list<std::string> outputs) {
  std::vector<std::string> taken;
  for (const std::string& output : outputs) {
    if (output.empty()) continue;
    PANELCAL_CHECK(check_replaceable(command, output));
    const auto is_this = [&](const std::string& other) {
      return !other.empty() && (other == output || is_same_file(other, output));
    };
    // Standard output is no input, whatever it is called.
    const bool overwrites = output != "-" && std::ranges::any_of(inputs, is_this);
    if (overwrites || std::ranges::any_of(taken, is_this)) {
      return failure({Code::Usage,
                      {std::string(command), 0, 0},
                      quoted(output) + " is named twice",
                      "a file of its own for each output"});
    }
    taken.push_back(output);
  }
  return {};
}

}  // namespace panelcal
