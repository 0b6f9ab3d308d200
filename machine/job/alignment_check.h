// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "program/walk/walk.h"

namespace panelcal {

/// Zero that places count from where no program sets another one: that of an alignment's pads.
inline Position<frame::Machine> configured_zero(const WalkOptions& options) {
  return options.absolute_zero + displacement_mm<frame::Machine>(options.work_zero.in_mm());
}

/// Checks that a program can be corrected by WalkOptions::aligned: it measures no target and
/// calibrates nothing itself, counts from the zero that the pads were measured from, and its places
/// overlap the rectangle of the pads. Files of one board that were written with different origins
/// do not overlap.
///
/// In     checked: what the check of the program has found on a perfect panel, the alignment first
/// Fails  usage
/// See    tests/machine/job/alignment_check_test.cc
Expected<void> check_fits_alignment(const Program& program,
                                    const WalkOptions& options,
                                    const Survey& checked);

}  // namespace panelcal
