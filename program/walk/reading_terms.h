// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "program/text/number_format.h"

namespace panelcal {

/// The operator's terms of reading a program: options of every command that reads one.
struct ReadingTerms {
  /// --accept-unterminated: an Excellon program may stop behind any complete line.
  bool accepts_unterminated = false;
  PartialFormat format;  ///< --format: of its numbers, whatever it states; empty: as it states
};

}  // namespace panelcal
