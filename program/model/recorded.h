// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/fields/json_file.h"
#include "calib/base/json/json_line.h"
#include "program/model/calibration_order.h"
#include "program/model/measurement.h"

// Not installed: reads lines as to_json() writes them.
namespace panelcal::internal {

/// Fails  measurement-file; measurement-invalid: a covariance that is not positive definite
Expected<Measurement> measurement_of(const JsonLine& line);
/// Fails  the same
Expected<CalibrationAnswer> calibration_of(const JsonLine& line);

/// That a digest of a stored pattern stands beside its name.
///
/// Fails  measurement-file
Expected<void> check_pattern(const JsonLine& line, const std::string& file);

/// Symmetric of [xx, xy, yy].
Eigen::Matrix2d recorded_covariance(const std::array<double, 3>& cov);

/// Requests and measurements; calibrations.
JsonFile measurements_file();
JsonFile calibrations_file();

}  // namespace panelcal::internal
