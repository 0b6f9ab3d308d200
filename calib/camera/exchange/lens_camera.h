// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "calib/camera/calibration/calibration_file.h"
#include "calib/camera/exchange/lens.h"

namespace panelcal {

/// A lens model has neither of these: how the camera is mounted.
struct LensMount {
  double scale_mm_per_px = 0.01;  ///< of the panel on the optical axis
  double rotation_rad = 0;        ///< of the picture against the machine
  Length corner_sigma = um(5);    ///< of a place at the corner that is farthest from the axis
  double max_error_px = 0.01;     ///< by which our model may miss the lens anywhere in the picture
};

/// A camera calibration, and how well its model follows the lens that it was made of.
struct LensCamera {
  CameraCalibration calibration;  ///< without a date and a provenance
  double error_px = 0;            ///< of the places over the picture, the greatest
};

/// The calibration of a camera with this lens that looks straight down.
///
/// Brown's lens leads from rays to pixels, CameraModel from pixels to rays: k1, k2, p1, p2 are
/// those that miss the inverse of the lens least over the picture, by least squares. The covariance
/// has scale and rotation alone, in equal parts of corner_sigma.
///
/// Fails  calibration-invalid: pixels that are not square; a lens that folds over in the picture,
/// or
///        that our model misses by more than mount.max_error_px; a mount that is not finite
/// See    tests/calib/camera/exchange/lens_camera_test.cc
Expected<LensCamera> camera_of_lens(const Lens& lens, const LensMount& mount);

/// A lens that leads back, and its greatest error over the picture.
struct CameraLens {
  Lens lens;  ///< its format is left to the caller
  double error_px = 0;
};

/// In     focal_px: of a telecentric camera, whose lens has none; any will do
/// Fails  calibration-invalid: a tilt, which no lens model has; a camera without a focal length;
///        a lens that Brown's misses by more than max_error_px
Expected<CameraLens> lens_of_camera(const CameraCalibration& calibration,
                                    std::optional<double> focal_px,
                                    double max_error_px = 0.01);

}  // namespace panelcal
