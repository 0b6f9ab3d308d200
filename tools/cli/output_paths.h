// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include "calib/base/expected.h"

namespace panelcal {

/// Whether two names lead to one file, by whatever spelling, link or relative path. Files need not
/// exist; `-` as an input is what standard input was redirected from.
bool is_same_file(const std::filesystem::path& input, const std::filesystem::path& output);

/// Of a file's name, in small letters: formats belong to ".SVG" as to ".svg".
std::string extension_of(const std::filesystem::path& path);

/// No output may overwrite an input or another output; `-` is standard output, which only one may
/// have, and an existing output is neither a device nor a pipe. Empty names do not count.
///
/// Fails  usage, in the name of `command`
Expected<void> check_output_paths(std::string_view command,
                                  std::initializer_list<std::string> inputs,
                                  std::initializer_list<std::string> outputs);

}  // namespace panelcal
