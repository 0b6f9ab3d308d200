// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/survey.h"

#include <algorithm>

namespace panelcal {

bool SeriesResult::is_accepted() const {
  return is_fitted() && (!fault || fault->is_resolved) &&
         std::ranges::all_of(gates, &GateVerdict::accepted);
}

bool Survey::is_complete() const {
  return std::ranges::all_of(series, &SeriesResult::is_fitted) &&
         std::ranges::all_of(measurements, [](const Measurement& measurement) {
           return measurement.status == MeasurementStatus::Found;
         });
}

bool Survey::is_accepted() const {
  return is_complete() && std::ranges::all_of(series, &SeriesResult::is_accepted);
}

}  // namespace panelcal
