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
#include "calib/camera/model.h"
#include <Eigen/Core>

namespace panelcal {

/// Which parameters of the camera model are free, from stiff to soft; each form has all of the one
/// before it.
enum class CameraForm {
  Flat,          ///< scale, rotation
  Radial,        ///< and k1
  Tilted,        ///< and the tilt
  TiltedRadial,  ///< and k2
  Tangential,    ///< and p1, p2
};
inline constexpr std::array kCameraForms = {CameraForm::Flat,
                                            CameraForm::Radial,
                                            CameraForm::Tilted,
                                            CameraForm::TiltedRadial,
                                            CameraForm::Tangential};
std::string_view name(CameraForm form);
std::vector<CameraParameter> free_parameters(CameraForm form);

struct CameraObservation {
  std::size_t i_view = 0;
  std::size_t i_dot = 0;
  PositionEstimate<frame::Image> seen;
};

/// Pictures of a plate, or of one target at known stage places, at one zoom level.
struct CameraData {
  std::vector<PlateView> views;
  std::vector<PlateDot> dots;
  std::vector<CameraObservation> seen;
};

struct CameraFitOptions {
  CameraForm form = CameraForm::Flat;
  Eigen::Vector2d axis_px = Eigen::Vector2d::Zero();  ///< as a rule the picture's middle
  /// Distance of the panel over the scale, from the lens' data sheet; infinite if telecentric.
  double focal_px = std::numeric_limits<double>::infinity();
  /// Where stage and plate leave them open; otherwise only the rotation is used, to begin with.
  double scale_mm_per_px = 0.01;
  double rotation_rad = 0;
  /// Residuals beyond this number of sigmas count by their length instead of its square (Huber); 0:
  /// none does. What is not noise hardly moves the result then, and honest noise costs it 5 %
  /// at 1.35.
  double huber_sigmas = 0;
  /// One in this number of observations is left out for the held-out check; 0: there is none.
  int held_out_every = 5;
};

/// A fitted camera, and what the data say about it.
struct CameraFit {
  CameraForm form = CameraForm::Flat;
  CameraModel::Parameters parameters;
  CameraModelCovariance covariance = CameraModelCovariance::Zero();  ///< of held ones 0
  /// Parameters of the form that the data leave open; they are held at their start.
  std::vector<CameraParameter> undetermined;
  std::vector<PlatePose> poses;  ///< up to a shift and turn of the whole, if no dot is certified
  std::vector<Position<frame::Plate>> dots;
  std::vector<Displacement<frame::Image>> residuals;  ///< seen minus fitted, as CameraData::seen
  double chi_square = 0;                              ///< by a Huber loss where there is one
  int degrees_of_freedom = 0;
  double rms_px = 0;  ///< of the residuals' lengths
  /// The same of observations that a second fit did not see.
  std::optional<double> held_out_rms_px;
  std::size_t n_held_out = 0;

  CameraModel model() const { return CameraModel(parameters); }
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
/// See    tests/calib/camera/fit_test.cc
Expected<CameraFit> fit_camera(const CameraData& data, const CameraFitOptions& options);

/// Fits all forms whose parameters the data determine and returns the stiffest whose criterion is
/// within kWorthASofterModel of the least. Its covariance does not count that it was chosen.
///
/// Fails  as fit_camera, where not even the flat one can be fitted
Expected<CameraFit> choose_camera(const CameraData& data, const CameraFitOptions& options);

}  // namespace panelcal
