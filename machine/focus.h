// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "panelcal/calib/base/expected.h"
#include "panelcal/machine/view_taker.h"
#include "panelcal/machine/vision_options.h"
#include "panelcal/program/measurement.h"

namespace panelcal {

/// Looks for the height at which the camera sees a place sharpest: 11 pictures over the range, then
/// twice 7 around the sharpest one at a third of the distance; the peak is fitted to all of them.
///
/// In     request: expected, work_zero, settings; views are numbered in the order taken
/// Out    is_found false with the reason where fit_focus_peak finds no peak; the curve always
/// Fails  what `taker` reports
/// Cost   25 pictures
/// See    tests/machine/vision_procedure_test.cc; vision/focus.h
Expected<FocusResult> autofocus(const MeasurementRequest& request,
                                const FocusRange& range,
                                ViewTaker& taker);

}  // namespace panelcal
