// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "program/model/measurement.h"
#include <Eigen/Core>

namespace panelcal {

/// One picture that a target was looked for in, as the report shows it. Work coordinates, mm.
struct ReportView {
  int i_view = 0;
  MeasurementStatus status = MeasurementStatus::NotFound;
  std::vector<Eigen::Vector2d> frame_mm;  ///< the picture's corners, one after the other
  std::vector<Eigen::Vector2d> seen_mm;   ///< the best candidate's place, if there was one
  std::string crop_png;                   ///< empty: not shown
};

namespace report {

/// Figure of the views of a target with several: their frames with numbers in the order of the
/// search, what was seen in them, where the target was expected, and the crops of all views that
/// saw something. Empty for a single view.
std::string views_figure(const Measurement& measurement, std::span<const ReportView> views);

}  // namespace report
}  // namespace panelcal
