// SPDX-License-Identifier: Apache-2.0
#include "program/walk/program.h"

namespace panelcal {

bool Program::deletes_blocks() const {
  return head->block_delete.value_or(reading.block_delete.value_or(false));
}

PartialFormat ReadOptions::unstated_format() const {
  PartialFormat format = format_beside;
  format.fill_from(last_format);
  return format;
}

}  // namespace panelcal
