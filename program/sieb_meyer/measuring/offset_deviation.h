// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "calib/base/machine_uncertainty.h"
#include "calib/correction/spindle_offsets.h"
#include "program/model/calibration_order.h"
#include "program/model/measurement.h"

namespace panelcal::sieb_meyer {

/// Offsets that G39 corrects: SPOP, SPOP1, SPOP2, SPOF1 to SPOF12, SPISPI.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, 9 Optical Measurement, G39
std::optional<OffsetOrder> offset_order(std::string_view text);

/// The calculated offset that G39,SPOP and its kin store: the mean of how far holes were seen from
/// where the correction in force had them drilled.
///
///   deviation = mean(measured_i - expected_i)
///
/// with the covariance of pictures, of every stop to look, and of every hole as it was drilled.
/// Layers of one target are one hole. Two targets or more that scatter farther than that allows
/// enlarge it, by chi-square over its degrees of freedom. The camera's calibration, whose error is
/// in the offset as in later targets, is left to `by_camera`.
///
/// In     measured: all found; slots count for the coordinate that they show
/// Out    `order` is left to the caller; empty unless both coordinates were seen
/// See    tests/program/sieb_meyer/measuring/offset_deviation_test.cc
std::optional<OffsetCorrection> offset_deviation(std::span<const Measurement> measured,
                                                 const MachineUncertainty& machine);

/// The chance that sound holes scatter as far about their mean, by chi-square. 1 where there is
/// nothing to compare: one target, slots, or a machine that does not state its drill's wander.
///
/// In     measured: all found
double scatter_chance(std::span<const Measurement> measured, const MachineUncertainty& machine);

}  // namespace panelcal::sieb_meyer
