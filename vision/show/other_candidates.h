// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "vision/fit/detection.h"

namespace panelcal {

/// The places that were looked at and are not the answer, in the order of their numbers in
/// overlays, 1 first: all of them if nothing was found, else all but the one found.
std::span<const Candidate> other_candidates(const Detection& detection);

}  // namespace panelcal
