// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "program/geometry/bounding_box.h"
#include "program/walk/walk.h"

namespace panelcal {

/// Zero that places count from where no program sets another one: that of an alignment's pads.
inline Position<frame::Machine> configured_zero(const WalkOptions& options) {
  return options.absolute_zero + displacement_mm<frame::Machine>(options.work_zero.in_mm());
}

/// Checks that a program can be corrected by WalkOptions::aligned: it measures no target and
/// calibrates nothing itself, counts from the zero that the pads were measured from, and its places
/// overlap the rectangle of the pads (check_one_origin()).
///
/// In     checked: what the check of the program has found on a perfect panel, the alignment first
/// Fails  usage
/// See    tests/machine/job/alignment_check_test.cc
Expected<void> check_fits_alignment(const Program& program,
                                    const WalkOptions& options,
                                    const Survey& checked);

/// Checks that a program and the pads of an alignment count from one origin, as far as their
/// rectangles tell: they overlap, and neither lies shifted against the other. If only one of them
/// reaches beyond the other they may be of one board.
///
/// In     worked: where the program works; file: its name
/// Fails  usage
Expected<void> check_one_origin(const std::string& file,
                                const BoundingBox<frame::Nominal>& worked,
                                const Survey& aligned);

}  // namespace panelcal
