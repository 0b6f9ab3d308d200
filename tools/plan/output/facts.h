// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/advice/target_design.h"
#include "program/walk/walk.h"
#include "tools/plan/design/models.h"
#include "tools/plan/design/places.h"
#include "tools/plan/design/plan.h"
#include "tools/plan/design/visits.h"

namespace panelcal::plan {

/// At most this number of base series is looked at in detail.
inline constexpr std::size_t kMostBase = 4;

/// Everything that is to be said about a program's targets before they are measured.
///
/// Precondition: `survey` is a complete walk over the perfect panel, of which `programmed` has the
///               models (see cmd_plan.cc); `options` are those of the walk
/// Cost         three walks over the job; memory does not grow with its holes
Plan make_plan(const Program& program,
               const WalkOptions& options,
               const Survey& survey,
               std::span<const PanelModel> programmed,
               const PlanRequest& request);

}  // namespace panelcal::plan
