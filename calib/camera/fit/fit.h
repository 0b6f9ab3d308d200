// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/calibration_plate.h"
#include "calib/base/estimate.h"
#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/camera/fit/fit_input.h"
#include "calib/camera/form.h"
#include "calib/camera/model.h"
#include <Eigen/Core>

namespace panelcal {

/// A fitted camera, and what the data say about it.
struct CameraFit {
  CameraForm form = CameraForm::Flat;
  /// The stiffest form whose criterion is within kWorthASofterModel of the least; of a form that
  /// was asked for, that one.
  CameraForm sufficient = CameraForm::Flat;
  CameraModel::Parameters parameters;
  CameraModelCovariance covariance = CameraModelCovariance::Zero();  ///< of held ones 0
  /// Parameters of the form that the data leave open; they are held at their start.
  std::vector<CameraParameter> undetermined;
  /// The next softer form, where only the number of observations keeps it from being fitted.
  std::optional<CameraForm> wants_views_for;
  std::vector<PlatePose> poses;  ///< up to a shift and turn of the whole, if no dot is certified
  std::vector<Position<frame::Plate>> dots;
  std::vector<Displacement<frame::Image>> residuals;  ///< seen minus fitted, as CameraData::seen
  double chi_square = 0;                              ///< by a Huber loss where there is one
  int degrees_of_freedom = 0;
  double rms_px = 0;  ///< of the residuals' lengths
  /// The same of observations that a second fit did not see, and whose places it predicts.
  std::optional<double> held_out_rms_px;
  std::size_t n_held_out = 0;

  CameraModel model() const { return CameraModel(parameters); }
  std::size_t n_free() const;  ///< camera parameters that were fitted
  /// chi square + 2 free camera parameters: Akaike's, as in calib/panel/model_choice.h.
  double criterion() const;
  std::string summary() const;  ///< one line
};

/// Fits a camera of the given form.
///
///   K(u_ij - bias_ij) = R(angle_k) dot_j + shift_k - axis_i + e_ij    view i, dot j, pose k of i
///
/// with e the detector's noise, carried from the picture to the panel, bias that of circle centres
/// (calib/camera/circle_bias.h), the camera common to all, a pose for every way the plate lay, and
/// the places of dots that are not certified. So one target seen at known stage places is a plate
/// of one dot, one pose and many views; a plate that is laid down anew before each picture is a
/// pose a view.
///
/// The undetermined parameters are found before the fit, by the pivots of the camera's normal
/// matrix after poses and dots are eliminated, from stiff parameters to soft, and said: the
/// rotation where every view has a pose of its own, the scale where moreover no dot is certified, a
/// tilt with a telecentric lens and one view, and so on. Such a parameter is held at its start.
/// That noise leaves a parameter vague is no reason to hold it: see choose_camera.
///
/// The derivative of the bias is left out: it is smaller than that of the place by
/// (radius of a dot / radius of the picture)^2.
///
/// In     seen: px, covariance px^2
/// Out    camera, covariance, residuals (seen minus fitted, px), held-out check
/// Fails  calibration-data (an index out of range, a number that is not finite, a covariance that
///        is not positive definite; too few observations; a picture that no camera shows)
/// Cost   81 dots in 5 views, 8 parameters: 40 ms
/// Source Ceres Solver (Levenberg-Marquardt); Triggs et al. 2000 (gauge, elimination)
/// See    tests/calib/camera/fit/fit_test.cc
Expected<CameraFit> fit_camera(const CameraData& data, const CameraFitOptions& options);

/// Degrees of freedom that a softer form than the stiffest has to leave: a variance that fewer of
/// them estimate has no finite mean, nu / (nu - 2), in Student's t.
inline constexpr int kFewestCameraFreedoms = 3;

/// Fits the softest form that the data determine; `sufficient` is the stiffest that chi square
/// would allow. Its covariance is that of a form that no datum chose: the number and the places of
/// the observations do.
///
/// A form that leaves open more than the stiffest does, as all with a tilt do through a telecentric
/// lens, counts only where an F test rejects the form without its terms (chance 0.001): a
/// telecentric lens that bends by k2, p1 or p2 as well. Below that a lens may bend by what the test
/// does not see, and the covariance does not count it.
///
/// Not the sufficient one, and no average. A lens that is bent by one or two sigmas of k1 passes
/// for a flat one, and the flat fit's scale is off by as many sigmas of what k1 adds to it, several
/// of its own: no interval about a form that Akaike's criterion chose holds more than a bound far
/// below its level (Kabaila and Leeb 2006), and averages of two nested forms gain little over the
/// interval of the softer one at the same least coverage (Kabaila, Welsh and Abeysekera 2016).
/// docs/formulation.md, "Calibrations", has the figures of this model.
///
/// Fails  as fit_camera, where no form can be fitted
/// Source Leeb and Poetscher 2005; Kabaila and Leeb 2006; Kabaila, Welsh and Abeysekera 2016
/// See    tests/calib/camera/fit/fit_slow_test.cc, tests/reference/coverage/camera_draws.py
Expected<CameraFit> choose_camera(const CameraData& data, const CameraFitOptions& options);

}  // namespace panelcal
