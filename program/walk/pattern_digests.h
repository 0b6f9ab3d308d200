// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace panelcal {

/// SHA-256 of the stored patterns and subprograms in which a walk asks for something, each made
/// once and only where it is asked for: most patterns measure nothing.
class PatternDigests {
 public:
  /// In     file: of the pattern; empty: the program itself, which has no digest (empty)
  const std::string& of(std::string_view file, std::string_view bytes);

 private:
  std::map<std::string, std::string, std::less<>> by_file_;
};

}  // namespace panelcal
