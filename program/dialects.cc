// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "program/excellon/dialect.h"
#include "program/sieb_meyer/dialect.h"
#include "program/walk/dialect.h"

namespace panelcal {

std::span<const ProgramDialect* const> dialects() {
  static const std::array<const ProgramDialect*, 2> kDialects = {&sieb_meyer::dialect(),
                                                                 &excellon::dialect()};
  return kDialects;
}

}  // namespace panelcal
