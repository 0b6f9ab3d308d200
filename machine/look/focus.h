// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/settings/vision_options.h"
#include "machine/look/view_taker.h"
#include "program/model/measurement.h"

namespace panelcal {

/// Looks for the height at which the camera sees a place sharpest: 11 pictures over the range, then
/// twice 7 around the sharpest one at a third of the distance; the peak is fitted to all of them.
///
/// In     request: expected, work_zero, settings; views are numbered in the order taken
/// Out    is_found false with the reason where fit_focus_peak finds no peak; the curve always
/// Fails  what `taker` reports
/// Cost   25 pictures
/// See    tests/machine/look/vision_procedure_test.cc; vision/locate/focus.h
Expected<FocusResult> autofocus(const MeasurementRequest& request,
                                const FocusRange& range,
                                ViewTaker& taker);

}  // namespace panelcal
