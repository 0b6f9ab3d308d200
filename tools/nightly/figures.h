// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "machine/nightly/record/night_record.h"

namespace panelcal::nightly {

/// Styles of the classes that the figures use, besides those of the report.
extern const std::string_view kFigureStyle;

/// One axis over the last nights against what is in force now: each night's result with a bar of
/// one sigma to either side, crosses for refused ones (on the edge if beyond it, with their value),
/// rings for alarms, a step line for what was in force, and for tonight where the nights before
/// predicted it, three sigma wide. Empty where fewer than two nights have something to show.
///
/// In     i_axis: of step.axes
std::string drift_figure(const NightStep& step, std::size_t i_axis);

/// The coupon's holes with their residuals, magnified. Empty without holes.
std::string holes_figure(const NightStep& step);

/// Figure of the mark's place over time while the machine warmed up, from its warm place, with the
/// fit and the limit. Empty with fewer than two looks.
std::string warm_up_figure(const NightWarmUp& seen);

}  // namespace panelcal::nightly
