// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace panelcal {

/// A letter and what follows it, such as `X` and `-0087`.
struct Word {
  char letter = 0;
  int column = 0;           ///< of the letter, from 1
  std::string_view number;  ///< may be empty

  std::string text() const { return letter + std::string(number); }
};

/// Characters that begin no word of their language.
struct LexFault {
  int column = 0;
  std::string_view text;
  std::string_view expected;
};

}  // namespace panelcal
