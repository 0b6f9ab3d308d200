// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/fields/field.h"

// Not installed.
namespace panelcal::internal {

/// The description of machine.toml: every table with its keys.
FileDescription machine_file();

}  // namespace panelcal::internal
