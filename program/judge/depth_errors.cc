// SPDX-License-Identifier: Apache-2.0
#include "program/judge/depth_errors.h"

#include <cmath>
#include <utility>

#include "calib/base/statistics/distributions.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// That a normal error is above a limit. Without a sigma it is or is not.
double chance_above(Length limit, Length mean, Length sigma) {
  const Length room = limit - mean;
  if (!(sigma > Length())) return room < Length() ? 1 : 0;
  return normal_exceedance(room / sigma);
}

/// Surface that an axis counts on; absent if it was not probed.
std::optional<Length> surface_of(const DepthOfCut& cut, std::size_t axis) {
  if (axis == 0) return cut.surface;
  if (axis > cut.other_surfaces.size()) return std::nullopt;
  return cut.other_surfaces[axis - 1];
}

std::optional<Length> height_of(const PlaneReference& reference, std::size_t axis) {
  if (axis == 0) return reference.height;
  if (axis > reference.other_heights.size()) return std::nullopt;
  return reference.other_heights[axis - 1];
}

}  // namespace

std::string error_text(const DepthError& error) {
  std::string out = fmt::format("{:.1f} um too {} if the map is right, sigma {:.1f} um",
                                std::abs(error.mean.in_um()),
                                error.mean < Length() ? "shallow" : "deep",
                                error.sigma.in_um());
  if (error.axis) out += fmt::format(", Z axis {}", *error.axis);
  return out;
}

DepthRisk depth_risk(const DepthError& error, const DepthTolerance& tolerance) {
  DepthRisk risk;
  if (tolerance.too_shallow) {
    risk.too_shallow = chance_above(*tolerance.too_shallow, -error.mean, error.sigma);
  }
  if (tolerance.too_deep) {
    risk.too_deep = chance_above(*tolerance.too_deep, error.mean, error.sigma);
  }
  return risk;
}

std::optional<DepthError> DepthErrors::at(const Position<frame::Nominal>& place,
                                          const DepthOfCut& cut,
                                          std::size_t axis) const {
  const Expected<ZonedMap>& map = maps_[axis];
  const std::optional<Length> counted_on = surface_of(cut, axis);
  if (!map || !counted_on) return std::nullopt;
  const auto found = map->height_at(place);
  if (!found) return std::nullopt;
  DepthError error;
  error.mean = found->height.height - *counted_on;
  error.map_sigma = found->height.sigma;
  error.machine_sigma = depth_sigma_;
  if (maps_.size() > 1) error.axis = axis;
  if (cut.reference) {
    const auto at_reference = map->height_at(cut.reference->place);
    const std::optional<Length> reference = height_of(*cut.reference, axis);
    if (!at_reference || !reference) return std::nullopt;
    error.mean = error.mean - (at_reference->height.height - *reference);
    error.reference_sigma = at_reference->height.sigma;
  }
  error.sigma = mm(std::hypot(
      error.map_sigma.in_mm(), error.reference_sigma.in_mm(), error.machine_sigma.in_mm()));
  return error;
}

std::optional<DepthError> DepthErrors::worst_at(const Position<frame::Nominal>& place,
                                                const DepthOfCut& cut,
                                                const DepthTolerance& tolerance) const {
  if (!cut.depth && !cut.surface && !cut.is_controlled()) return std::nullopt;
  if (!cut.surface) {
    if (!finds_surface_ || !(depth_sigma_ > Length())) return std::nullopt;
    DepthError error;
    error.sigma = error.machine_sigma = depth_sigma_;
    return error;
  }
  std::optional<DepthError> worst;
  const auto badness = [&](const DepthError& error) {
    return std::pair(depth_risk(error, tolerance).either(), std::abs(error.mean.in_mm()));
  };
  for (std::size_t axis = 0; axis < maps_.size(); ++axis) {
    const auto error = at(place, cut, axis);
    if (!error) return std::nullopt;
    if (!worst || badness(*error) > badness(*worst)) worst = error;
  }
  return worst;
}

DepthTolerance DepthJudge::tolerance_of(int tool, const DepthOfCut& cut) const {
  if (!cut.depth && !cut.surface && !cut.is_controlled()) return {};
  const auto known = tools_.find(tool);
  return tolerances_.depth_of(tool, known == tools_.end() ? std::nullopt : known->second.diameter);
}

std::optional<JudgedDepth> DepthJudge::judge(int tool,
                                             const Position<frame::Nominal>& place,
                                             const DepthOfCut& cut) const {
  const DepthTolerance tolerance = tolerance_of(tool, cut);
  if (tolerance.is_empty()) return std::nullopt;
  const std::optional<DepthError> error = errors_.worst_at(place, cut, tolerance);
  if (!error) return std::nullopt;
  return JudgedDepth{tolerance, *error, depth_risk(*error, tolerance)};
}

std::optional<JudgedDepth> DepthJudge::judge(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    return judge(drill->tool, drill->nominal, drill->cut);
  }
  if (const auto* rout = std::get_if<Rout>(&operation.what)) {
    return judge(rout->tool, rout->nominal, rout->cut);
  }
  if (const auto* change = std::get_if<ToolChange>(&operation.what)) take(*change);
  return std::nullopt;
}

}  // namespace panelcal
