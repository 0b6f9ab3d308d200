// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "tools/figures/drawing.h"
#include "tools/plan/output/facts.h"

namespace panelcal::plan {

using report::Drawing;

/// Styles of the classes that the drawings use; they are on white paper, whatever surrounds them.
extern const std::string_view kPlanStyle;

/// Drawing of the part of the targets' noise that reaches each place: bands of equal leverage with
/// the holes, the targets and their hull, the worst place, and the pads of `addition` if there is
/// one.
///
/// The colours stand for the same leverage in every picture, so that two can be compared.
Drawing leverage_drawing(const SeriesPlan& series, const AdditionPlan* addition);

/// The way from target to target: as programmed, and the short one.
Drawing visits_drawing(const Plan& plan);

/// The colours with their leverages, and in um for the noise of this series.
Drawing scale_drawing(const SeriesPlan& series);

}  // namespace panelcal::plan
