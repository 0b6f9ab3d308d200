// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "calib/base/units.h"
#include "calib/drift/settle.h"

namespace panelcal {

/// Delays after which a first round of views is taken: from 0 to `longest`, closer together at the
/// beginning, and in no common step, so that no frequency looks like a lower one at all of them.
///
/// Precondition: n >= 2
/// See    tests/calib/drift/settle_delays_test.cc
std::vector<Time> first_settle_delays(int n, Time longest);

/// Delays of a later round, within the time in which `seen` still moves: by the golden section,
/// which fills an interval evenly however many follow and never in steps (as first differences of
/// a lattice would alias). Where nothing was seen to move they fill the first quarter of `longest`.
///
/// In     seen: of all rounds before; i_round: 1 for the second round
std::vector<Time> next_settle_delays(
    std::span<const SettleView> seen, int n, int i_round, Time longest, Length limit);

}  // namespace panelcal
