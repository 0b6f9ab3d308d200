// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "calib/base/expected.h"
#include "calib/camera/fit/fit.h"

namespace panelcal::internal {

/// Fits a camera, of whichever form and loss, to observations.
using CameraFitter = std::function<Expected<CameraFit>(const CameraData&)>;

/// The scatter of observations beyond their stated covariances.
struct ScatteredFit {
  double variance_px2 = 0;  ///< of each coordinate, beyond what is stated
  CameraData data;          ///< with covariances that have it
  CameraFit fit;            ///< of `data`
  CameraFit stated;         ///< with the stated covariances
};

/// Fits observations with the variance v by which all of them scatter beyond what is stated.
///
///   chi_square(v) = sum_i r_i^T (C_i + v I)^-1 r_i;   chi_square(v) = wanted(nu), or v = 0 if
///   chi_square(0) is less; nu: degrees of freedom of the fit
///
/// Added, not multiplied: a stage moves a mark that is seen sharply as far as a blurred one, whose
/// stated sigma may be ten times as large. A factor on all sigmas would make outliers of sharp
/// views, and give them weights that they have not earned. The variance and the fit, which weighs
/// by it, are found in turns.
///
/// In     wanted: nu of the variance itself (Paule and Mandel's estimate)
/// Fails  as the fitter
/// Source Paule and Mandel 1982; DerSimonian and Kacker 2007
/// See    tests/machine/calibrate/camera/scatter_test.cc
Expected<ScatteredFit> fit_scattered(const CameraData& data,
                                     const CameraFitter& fitter,
                                     const std::function<double(int)>& wanted);

/// The same with the median of the terms of chi_square(v) as honest noise has it, which outliers
/// hardly bend: 2 ln 2 for two coordinates, less what the fit takes of it. The median is weighted
/// by what a term tells of v, 1 over the square of its variance: sharp views tell most.
Expected<ScatteredFit> fit_scattered_robustly(const CameraData& data, const CameraFitter& fitter);

/// The same observations, each with this variance of a coordinate more than is stated.
CameraData with_scatter(CameraData data, double variance_px2);

}  // namespace panelcal::internal
