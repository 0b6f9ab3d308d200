// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/fields/json_file.h"

// Not installed: the JSON files of calib, for their pages and schemas.
namespace panelcal::internal {

JsonFile camera_file();
JsonFile ledger_entry_file();
JsonFile spindle_file();
JsonFile table_file();

}  // namespace panelcal::internal
