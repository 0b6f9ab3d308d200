// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "machine/nightly/record/night_record.h"

namespace panelcal::nightly {

/// Contours of the map that a night probed, and of its sigma. Empty for a step that has none.
std::string surface_figures(const NightStep& step);

}  // namespace panelcal::nightly
