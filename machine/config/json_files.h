// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/fields/json_file.h"

// Not installed: the JSON files of machine, for their pages and schemas.
namespace panelcal::internal {

JsonFile coupon_file();
JsonFile plate_looks_file();
JsonFile sample_truth_file();
JsonFile truth_file();

}  // namespace panelcal::internal
