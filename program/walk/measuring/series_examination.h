// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "calib/correction/stack.h"
#include "calib/faults/finder.h"
#include "program/walk/measuring/fit_point.h"
#include "program/walk/options.h"
#include "program/walk/survey.h"

namespace panelcal {

/// The reason why a series does not fit, if it does not: find_fault over its points, in the frame
/// that its correction maps from. Pads are asked for only then.
///
/// Of a smooth series the bending is taken off first; what is left must fit an affine map, which is
/// a weak test: it has degrees of freedom that the spline used up.
///
/// In     series: fitted and gated; points: those of its fit
/// See    tests/program/walk/measuring/series_examination_test.cc
std::optional<SeriesFault> examine_series(const SeriesResult& series,
                                          std::span<const FitPoint> points,
                                          const Survey& survey,
                                          const CorrectionStack& stack,
                                          const WalkOptions& options);

/// The points without one, if the others still determine the model with an equation to spare.
std::optional<std::vector<FitPoint>> without_point(std::span<const FitPoint> points,
                                                   std::size_t i_point,
                                                   PanelModel model);

/// True if the targets of a series still determine its model with an equation to spare where some
/// are left out: what remains can be held against its limits.
///
/// In     nominal: the check's, which `series` is of; left_out: measurements of the series
bool is_checked_without(const SeriesResult& series,
                        const Survey& nominal,
                        std::span<const std::size_t> left_out);

}  // namespace panelcal
