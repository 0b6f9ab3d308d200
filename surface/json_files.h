// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/fields/json_file.h"

// Not installed: the JSON files of surface, for their pages and schemas.
namespace panelcal::internal {

JsonFile surface_map_file();

}  // namespace panelcal::internal
