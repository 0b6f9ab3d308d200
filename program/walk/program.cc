// SPDX-License-Identifier: Apache-2.0
#include "program/walk/program.h"

namespace panelcal {

bool Program::deletes_blocks() const {
  return head->block_delete.value_or(reading.block_delete.value_or(false));
}

void ReadOptions::take(const ReadingTerms& terms) {
  accepts_unterminated = terms.accepts_unterminated;
  forced_format = terms.format;
}

}  // namespace panelcal
