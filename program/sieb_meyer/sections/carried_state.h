// SPDX-License-Identifier: Apache-2.0
// State that goes on from one copy of a section to the next.
#pragma once

#include <string_view>

#include "program/sieb_meyer/sections/sections.h"

namespace panelcal::sieb_meyer {

/// State by which the lines of a section are read.
struct ReadingModes {
  bool is_pattern_mode = false;  ///< CAMA
  bool deletes_blocks = false;   ///< BLKD
};

/// True if all copies do the same. A section that uses a tool, a depth or a mode before it states
/// that, and states it later, begins its second copy with another one than the first, which begins
/// with `begin`. Only the section's own lines count, not those of subprograms.
bool copies_begin_alike(std::string_view bytes, const Section& section, const ReadingModes& begin);

}  // namespace panelcal::sieb_meyer
