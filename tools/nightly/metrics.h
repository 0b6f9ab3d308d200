// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "machine/nightly/record/night_record.h"
#include "tools/cli/metrics.h"

namespace panelcal::nightly {

/// A night as numbers for Prometheus (docs/howto/metrics.md).
///
/// In     exit_code: of the process, also where no night came to pass
Metrics night_metrics(const NightRecord& record, int exit_code);

}  // namespace panelcal::nightly
