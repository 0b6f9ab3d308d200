// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/fields/json_file.h"

// Not installed: the JSON file of alignments, for its page and schema.
namespace panelcal::internal {

JsonFile alignment_file();

}  // namespace panelcal::internal
