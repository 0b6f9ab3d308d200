// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "vision/template/model.h"

namespace panelcal::internal {

/// By which angle below `limit_rad` a template may be turned about the middle of its mark so that
/// it looks the same; then its orientation is unknown.
///
/// Only whole parts of a turn, a half to a twelfth, are tried: a round mark shows itself in any.
///
/// Cost   10 ms for a limit of half a turn, next to nothing below a twelfth of a turn
/// See    tests/vision/locate/target_check_test.cc
std::optional<double> self_turn(const TemplateModel& model, double limit_rad);

}  // namespace panelcal::internal
