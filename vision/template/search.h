// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/camera/mapping.h"
#include "vision/fit/search_area.h"
#include "vision/picture/image.h"
#include "vision/template/model.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A place that looks like the template.
struct TemplateSighting {
  Eigen::Vector2d at_px;  ///< of the template's reference
  double turn = 0;        ///< rad, in the frame
  double log_scale = 0;
  double correlation = 0;
};

/// Range of a template's pose.
struct TemplateRange {
  double turn = 0;  ///< rad
  double turn_tolerance = 0;
  double log_scale_tolerance = 0;
  double gain_sign = 1;  ///< -1: its negative
};

/// The level (averaging by 2^level) at which a template is searched: 16 to 32 cells wide.
int search_level(const TemplateModel& model);

/// Finds the places that correlate with the template, turned and scaled in steps of a cell.
///
/// Normalised cross-correlation over the turned template's own pixels, by Fourier transform. Past
/// the picture's border its outermost pixels are continued, so that a template that sticks out is
/// seen as well.
///
/// In     box: the pixels to look at; mapping may be null
/// Out    at most `max_sightings`, best first; precise to about a cell, 2^search_level px
/// Cost   five Fourier transforms of the averaged picture for each step of turn and scale
/// Source Lewis 1995 (normalised correlation); Padfield 2012 (masks)
std::vector<TemplateSighting> search_template(const Image& image,
                                              const PixelBox& box,
                                              const TemplateModel& model,
                                              const CameraMapping* mapping,
                                              const TemplateRange& range,
                                              int max_sightings);

}  // namespace panelcal::internal
