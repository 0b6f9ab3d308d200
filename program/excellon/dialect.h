// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "program/walk/dialect.h"

namespace panelcal::excellon {

/// Excellon, which any text is taken for that begins as no other language.
const ProgramDialect& dialect();

}  // namespace panelcal::excellon
