// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "program/text/number_format.h"

namespace panelcal {

/// Operations of a program, unless --max-operations says otherwise: some seconds of work. Panels of
/// ten million holes pass; larger programs are mistakes more often than panels.
inline constexpr std::int64_t kUsualMaxOperations = 20'000'000;

/// The operator's terms of reading a program: options of every command that reads one.
struct ReadingTerms {
  /// --accept-unterminated: an Excellon program may stop behind any complete line.
  bool accepts_unterminated = false;
  PartialFormat format;  ///< --format: of its numbers, whatever it states; empty: as it states
};

}  // namespace panelcal
