// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/json/facts.h"
#include "surface/map/zoned_map.h"
#include "surface/plan/probe_plan.h"
#include "tools/cli/provenance.h"

namespace panelcal::surface {

/// A plan with what it was made for.
struct PlannedProbes {
  ProbePlanRequest request;
  ProbePlan plan;
  std::string belief;                    ///< source of the panel's bending
  std::vector<Eigen::Vector2d> outline;  ///< of what may be probed, counter-clockwise, mm
  std::optional<ZonedMap> map;           ///< the map whose zones and voids are kept; empty: none
  std::size_t i_zone = 0;                ///< of the map, that is planned for
};

std::string plan_text(const PlannedProbes& planned);
/// The document of it, with the sigma that the map will have: docs/formats/surface.md.
facts::Json plan_facts(const PlannedProbes& planned, const Provenance& provenance);
/// `x,y` and a line for each probe, in the order to visit them. No provenance: a program that reads
/// such a list takes every further line for a place.
std::string plan_csv(const PlannedProbes& planned);

}  // namespace panelcal::surface
