// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "calib/faults/examined_target.h"
#include "calib/faults/series_fault.h"
#include "calib/faults/stories.h"

namespace panelcal::internal {

/// A cause in words, with numbers: a clause without a full stop.
std::string words_of(const FaultStory& story,
                     const Series& series,
                     std::span<const ExaminedTarget> targets);

}  // namespace panelcal::internal
