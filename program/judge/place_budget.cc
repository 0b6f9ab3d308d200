// SPDX-License-Identifier: Apache-2.0
#include "program/judge/place_budget.h"

namespace panelcal {

BudgetPlace budget_place(const PlacedPoint& point, const Origin& origin) {
  BudgetPlace place;
  place.nominal = origin.scaling == nullptr ? point.nominal : (*origin.scaling)(point.nominal);
  if (origin.base_series != nullptr) place.base_series = *origin.base_series;
  if (origin.nested_series != nullptr) place.nested_series = *origin.nested_series;
  place.i_measurement = origin.i_measurement;
  return place;
}

CorrectionStack corrections_at(const BudgetPlace& place,
                               const Survey& survey,
                               const MachineUncertainty& machine) {
  CorrectionStack stack(machine);
  const auto offset_of = [&](const SeriesResult& series) {
    return offset_uncertainty(survey.calibration_of(series), machine);
  };
  if (place.base_series) {
    const SeriesResult& series = survey.series[*place.base_series];
    stack.set_base(series.base, offset_of(series));
  }
  if (place.nested_series) {
    const SeriesResult& series = survey.series[*place.nested_series];
    stack.set_nested(series.nested, offset_of(series));
  }
  return stack;
}

ErrorBudget error_budget(const BudgetPlace& place,
                         const Survey& survey,
                         const MachineUncertainty& machine) {
  if (place.i_measurement) {
    const Measurement& target = survey.measurements[*place.i_measurement];
    MachineUncertainty with_offset = machine;
    with_offset.set_offset(
        offset_uncertainty(survey.calibration_of(*place.i_measurement), machine));
    return error_budget_at_target(with_offset,
                                  target.measured.cov,
                                  target.by_camera.value_or(CameraJacobian::Zero()),
                                  machine.camera_index(target.request.settings.zoom));
  }
  return error_budget(corrections_at(place, survey, machine), place.nominal);
}

/// Zero where the offset is that of the machine's file, whose error no simulated job draws.
Eigen::Matrix2d PictureCovariance::of_offset_mm2(const BudgetPlace& place) const {
  const auto& i_series = place.nested_series ? place.nested_series : place.base_series;
  const CalibrationAnswer* calibration = nullptr;
  if (place.i_measurement) {
    calibration = survey_.calibration_of(*place.i_measurement);
  } else if (i_series) {
    calibration = survey_.calibration_of(survey_.series[*i_series]);
  }
  return offset_uncertainty(calibration, {}).calibrated_mm2;
}

Eigen::Matrix2d PictureCovariance::at_mm2(const BudgetPlace& place) {
  const Eigen::Matrix2d of_offset = of_offset_mm2(place);
  if (place.i_measurement) {
    return survey_.measurements[*place.i_measurement].measured.cov + of_offset;
  }
  if (place.base_series != base_series_ || place.nested_series != nested_series_) {
    base_series_ = place.base_series;
    nested_series_ = place.nested_series;
    corrections_ = corrections_at(place, survey_, machine_);
    if (corrections_.smooth() == nullptr) {
      coefficients_cov_ = coefficients_cov_of_pictures(corrections_);
    }
  }
  if (corrections_.smooth() != nullptr) {
    return smooth_cov_of_pictures_mm2(corrections_, place.nominal) + of_offset;
  }
  return place_cov_mm2(coefficients_cov_, place.nominal) + of_offset;
}

}  // namespace panelcal
