// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "program/walk/dialect.h"

namespace panelcal::sieb_meyer {

/// SIEB & MEYER, whose programs %% opens.
const ProgramDialect& dialect();

}  // namespace panelcal::sieb_meyer
