// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/place_budget.h"

namespace panelcal {

BudgetPlace budget_place(const PlacedPoint& point, const Origin& origin) {
  BudgetPlace place;
  place.nominal = origin.scaling == nullptr ? point.nominal : (*origin.scaling)(point.nominal);
  if (origin.base_series != nullptr) place.base_series = *origin.base_series;
  if (origin.nested_series != nullptr) place.nested_series = *origin.nested_series;
  place.i_measurement = origin.i_measurement;
  return place;
}

namespace {

CorrectionStack corrections_at(const BudgetPlace& place,
                               const Survey& survey,
                               const MachineUncertainty& machine) {
  CorrectionStack stack(machine);
  if (place.base_series) stack.set_base(survey.series[*place.base_series].base);
  if (place.nested_series) stack.set_nested(survey.series[*place.nested_series].nested);
  return stack;
}

}  // namespace

ErrorBudget error_budget(const BudgetPlace& place,
                         const Survey& survey,
                         const MachineUncertainty& machine) {
  if (place.i_measurement) {
    const Measurement& target = survey.measurements[*place.i_measurement];
    return error_budget_at_target(machine,
                                  target.measured.cov,
                                  target.by_camera.value_or(CameraJacobian::Zero()),
                                  machine.camera_index(target.request.settings.zoom));
  }
  return error_budget(corrections_at(place, survey, machine), place.nominal);
}

Eigen::Matrix2d PictureCovariance::at_mm2(const BudgetPlace& place) {
  if (place.i_measurement) return survey_.measurements[*place.i_measurement].measured.cov;
  if (place.base_series != base_series_ || place.nested_series != nested_series_) {
    base_series_ = place.base_series;
    nested_series_ = place.nested_series;
    coefficients_cov_ = coefficients_cov_of_pictures(corrections_at(place, survey_, machine_));
  }
  return place_cov_mm2(coefficients_cov_, place.nominal);
}

}  // namespace panelcal
