// SPDX-License-Identifier: Apache-2.0
#include "program/walk/program.h"

namespace panelcal {

bool Program::deletes_blocks() const {
  return header.block_delete.value_or(reading.block_delete.value_or(false));
}

std::string Program::number_summary() const {
  return dialect == Dialect::Excellon ? header.format.summary()
                                      : sieb_meyer::summary(layout.format);
}

}  // namespace panelcal
