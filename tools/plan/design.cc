// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/design.h"

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

Eigen::Matrix2d SeriesDesigns::picture_mm2(std::size_t i_measurement) const {
  if (!request_.recorded_mm2.empty()) return request_.recorded_mm2[i_measurement];
  return std::pow(request_.fiducial_sigma.in_mm(), 2) * Eigen::Matrix2d::Identity();
}

std::vector<DesignTarget> SeriesDesigns::targets(std::size_t i_series) const {
  const SeriesResult& series = survey_.series[i_series];
  std::vector<DesignTarget> design = design_of(survey_, series);
  if (request_.recorded_mm2.empty()) return design;
  const double noise2 = std::pow(noise_mm(i_series), 2);
  for (std::size_t k = 0; k < design.size(); ++k) {
    const Eigen::Matrix2d picture_mm2 = this->picture_mm2(series.points[k]);
    design[k].cov = (picture_mm2 + machine_.of_target_mm2()) / noise2;
    design[k].picture_cov = picture_mm2 / noise2;
  }
  return design;
}

double SeriesDesigns::noise_mm(std::size_t i_series) const {
  const std::vector<std::size_t>& points = survey_.series[i_series].points;
  double sum = 0;
  for (const std::size_t i : points) {
    sum += (picture_mm2(i) + machine_.of_target_mm2()).trace() / 2;
  }
  if (points.empty()) return 1e-3;
  return std::sqrt(sum / static_cast<double>(points.size()));
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
