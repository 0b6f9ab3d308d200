// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/design/design.h"

#include <algorithm>
#include <cmath>

namespace panelcal::plan {

std::vector<DesignTarget> design_of(const Survey& survey, const SeriesResult& series) {
  std::vector<DesignTarget> design;
  for (const std::size_t i : series.points) {
    const MeasurementRequest& request = survey.measurements[i].request;
    design.push_back({request.nominal, request.axes});
  }
  return design;
}

double SeriesDesigns::noise_mm(std::size_t i_series) const {
  const std::vector<std::size_t>& points = survey_.series[i_series].points;
  double picture2 = std::pow(request_.fiducial_sigma.in_mm(), 2);
  if (!request_.recorded_mm.empty()) {
    double sum = 0;
    for (const std::size_t i : points) sum += std::pow(request_.recorded_mm[i], 2);
    picture2 = sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
  }
  return std::sqrt(picture2 + machine_.of_target_mm2()(0, 0));
}

MapCovariance SeriesDesigns::base_cov(std::size_t i_series) const {
  const SeriesResult& series = survey_.series[i_series];
  if (series.level == CorrectionLevel::Base || !series.base_series) return MapCovariance::Zero();
  const std::size_t i_base = *series.base_series;
  const auto found = predict_fit(targets(i_base), programmed_[i_base]);
  if (!found.fit) return MapCovariance::Zero();
  return std::pow(noise_mm(i_base) / noise_mm(i_series), 2) * found.fit->cov;
}

std::vector<PlannedPlace> SeriesDesigns::nested_targets(std::size_t i_base) const {
  std::vector<PlannedPlace> out;
  for (const SeriesResult& series : survey_.series) {
    if (series.level != CorrectionLevel::Nested || series.base_series != i_base) continue;
    for (const std::size_t i : series.points) out.push_back(target_place(survey_.measurements[i]));
  }
  return out;
}

}  // namespace panelcal::plan
