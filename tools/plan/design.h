// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tools/plan/plan.h"

namespace panelcal::plan {

/// The targets that a series is fitted to, as a design in which all have the same noise.
std::vector<DesignTarget> design_of(const Survey& survey, const SeriesResult& series);

/// The series of a walk over the perfect panel: where their targets are and what noise they have.
///
/// Arguments live longer than this; so does what they refer to.
class SeriesDesigns {
 public:
  SeriesDesigns(const Survey& survey,
                std::span<const PanelModel> programmed,
                const PlanRequest& request,
                const MachineUncertainty& machine)
      : survey_(survey), programmed_(programmed), request_(request), machine_(machine) {}

  /// With the noise of each.
  std::vector<DesignTarget> targets(std::size_t i_series) const;
  /// Of one target along an axis: root mean square over the series' targets.
  double noise_mm(std::size_t i_series) const;
  /// Of the map that a nested series is looked up under, in units of its own noise squared; zero
  /// for a base series.
  MapCovariance base_cov(std::size_t i_series) const;
  /// Targets of the nested series that are looked up through this base series.
  std::vector<PlannedPlace> nested_targets(std::size_t i_base) const;

 private:
  Eigen::Matrix2d picture_mm2(std::size_t i_measurement) const;

  const Survey& survey_;
  std::span<const PanelModel> programmed_;
  const PlanRequest& request_;
  const MachineUncertainty& machine_;
};

}  // namespace panelcal::plan
