// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/camera/calibration/calibration_file.h"
#include "calib/camera/fit/fit.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/calibrate/spindle/camera_run.h"
#include "machine/config/machine_config.h"
#include "machine/look/mark_sights.h"
#include "vision/picture/files/folder.h"

namespace panelcal {

/// Options of a camera's calibration.
struct CameraRunOptions {
  MarkViews views = {};
  std::optional<CameraForm> form = {};  ///< absent: the softest that the pictures determine
  /// Distance of the panel over the scale, from the lens' data sheet; infinite if telecentric.
  /// Absent: that of the camera in force, or telecentric if there is none.
  std::optional<double> focal_px = {};
};

/// A calibrated camera, and from what. Nothing is installed.
struct CameraRun {
  MarkSights sights;
  CameraFit fit;
  CameraCalibration calibration;  ///< without date and provenance
  /// By how much the views scatter more than detector and [uncertainty] say; 1 where they do not.
  double excess = 1;
  /// The factor by which the views' scatter and number enlarge sigmas, that of the views' mean
  /// where they state several: sqrt(chi square / (nu - 2)) of nu degrees of freedom where they
  /// state one, 1 or more.
  double sigma_factor = 1;
  /// Looks that do not fit the others, which are among `sights.missed` then.
  int n_left_out = 0;
  /// Scale and rotation that neither the views nor a camera in force determine; they are made up.
  std::vector<CameraParameter> guessed;
  bool loses_tilt = false;  ///< the camera in force has a tilt, which these views leave open
  /// Of the place that the picture's corners are seen at, the worst direction of the worst corner.
  double corner_sigma_um = 0;
};

/// Calibrates the camera on one mark that lies at `place`, a drilled hole or one fixed to the
/// table, by driving it over the whole picture.
///
/// Fails  what look_at_mark reports; calibration-data (too few views show the mark; the fit)
/// See    tests/machine/calibrate/camera/run_test.cc
Expected<CameraRun> calibrate_camera(const MachineConfig& config,
                                     const CalibrationDevices& devices,
                                     const Position<frame::Machine>& place,
                                     const CameraRunOptions& options = {});

/// The same from recorded pictures of one mark.
Expected<CameraRun> calibrate_camera(const MachineConfig& config,
                                     const PictureFolder& folder,
                                     const CameraRunOptions& options);

/// Fits the camera to what was seen of a mark or a plate.
///
/// The views' own scatter is taken for what it is: if the form leaves more than the covariances say
/// (noise, or the misfit of a form that was asked for), a variance is added to all of them, with
/// which chi square is nu - 2: nu / (nu - 2) is the variance of Student's t, so that 1.96 sigma
/// hold 95 % also where few degrees of freedom nu estimate the scatter. Before that, looks that do
/// not fit the others are left out (a speck taken for the mark, a stop that was missed).
///
/// Fails  calibration-data; calibration-invalid (a lens that no reader would accept)
Expected<CameraRun> fit_camera_run(const MachineConfig& config,
                                   MarkSights sights,
                                   const CameraRunOptions& options);

/// The reason not to use this camera without a look at its residuals; empty if nothing speaks
/// against it. Limits are on looks left out, a tilt that is lost, on the held-out check in um, and
/// on the excess.
std::string refusal(const CameraRun& run);

/// In lines: parameters with their sigmas, what is undetermined, residuals, held-out check, sigma
/// at the corners, pictures without the mark.
std::string report(const CameraRun& run);

/// "camera", or "zoom 3": the ledger's subject.
LedgerKey camera_key(const MachineConfig& config, const std::optional<double>& zoom);

/// For the ledger: the eight parameters with their covariance, the file as the result, machine.toml
/// and the pictures as inputs.
///
/// Fails  file-unreadable (machine.toml is gone)
Expected<LedgerDraft> camera_draft(const MachineConfig& config,
                                   const CameraRun& run,
                                   const RecordWords& words);

}  // namespace panelcal
