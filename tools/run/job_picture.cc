// SPDX-License-Identifier: Apache-2.0
#include "tools/run/job_picture.h"

#include <string>

namespace panelcal {

std::vector<SvgTarget> picture_targets(const Survey& survey) {
  std::vector<SvgTarget> targets;
  for (const Measurement& measurement : survey.measurements) {
    const bool is_found = measurement.status == MeasurementStatus::Found;
    targets.push_back({is_found ? measurement.measured.position : measurement.request.expected,
                       std::to_string(measurement.request.seq),
                       std::nullopt});
  }
  for (const SeriesResult& series : survey.series) {
    for (std::size_t i = 0; i < series.points.size() && series.is_fitted(); ++i) {
      targets[series.points[i]].residual = displacement_mm<frame::Actual>(
          series.base ? series.base->residuals[i].in_mm() : series.nested->residuals[i].in_mm());
    }
  }
  return targets;
}

}  // namespace panelcal
