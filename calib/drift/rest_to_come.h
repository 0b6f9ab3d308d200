// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "calib/drift/warm_up.h"

namespace panelcal {

/// Greatest part of a warm-up that may still come after the last sample: the samples decide when
/// they are enough themselves, so that the best fit would stop at the first piece of noise that
/// looks like an end.
///
///   value(t) = warm + c exp(-t / T),   rest = |c| exp(-t_last / T) with two of its sigmas
///
/// The largest over all time constants T up to twice as long as the samples go, of which the
/// samples are no more than three standard deviations (chi square 9) farther than of the best one.
/// A machine that takes longer than that still is not seen to move.
///
/// In     samples: 3 times or more, of one size of value, sigmas above 0
/// Out    in the values' unit, all axes together; infinite where nothing can be said
/// See    tests/calib/drift/rest_to_come_test.cc
double most_to_come(std::span<const WarmUpSample> samples);

}  // namespace panelcal
