// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/design/plan.h"

#include <algorithm>
#include <cmath>

namespace panelcal::plan {

const ModelPlan& SeriesPlan::in_force() const {
  return *std::ranges::find(models, programmed, &ModelPlan::model);
}

Length Plan::total_sigma(const SeriesPlan& one,
                         const PredictedFit& fit,
                         const PlannedPlace& place) const {
  const double noise2 = std::pow(one.noise.in_mm(), 2);
  Eigen::Matrix2d cov_mm2 = noise2 * LeverageMap(fit.cov).covariance(place.nominal);
  // Nothing is drilled at a target that is only looked for.
  if (!one.serves_targets) cov_mm2 += machine.shared_mm2() + machine.of_hole_mm2();
  return mm(greatest_sigma(cov_mm2));
}

}  // namespace panelcal::plan
