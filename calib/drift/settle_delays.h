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

/// Delays of a later round, over the time in which `seen` still moves: as many parts of it with one
/// delay each, anywhere within, so that rounds differ and no frequency is aliased. Where nothing
/// was seen to move it is the first quarter of `longest`.
///
/// In     seen: of all rounds before; i_round: 1 for the second round
std::vector<Time> next_settle_delays(
    std::span<const SettleView> seen, int n, int i_round, Time longest, Length limit);

}  // namespace panelcal
