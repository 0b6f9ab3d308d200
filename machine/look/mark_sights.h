// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/camera/fit/fit.h"
#include "calib/ledger/entry/entry.h"
#include "machine/config/machine_config.h"
#include "machine/devices/calibration_devices.h"
#include "vision/picture/files/folder.h"
#include <Eigen/Core>

namespace panelcal {

/// A picture in which the mark was not found.
struct MissedPicture {
  std::string picture;  ///< its file, or where it was taken
  std::string reason;
};

/// One mark in many pictures, each taken from another place.
struct MarkSights {
  CameraData data;                 ///< one dot of unknown place, one pose, a view a picture
  std::vector<std::string> names;  ///< of the pictures, one a view
  std::vector<MissedPicture> missed;
  std::vector<MissedPicture> left_out;  ///< not looked at: a plate's tags contradict other pictures
  std::vector<std::string> without_tag;  ///< of a plate with tags: where they were taken is checked
                                         ///< by none
  int n_skipped = 0;                     ///< pictures of other vision tools or zooms
  int width_px = 0;
  int height_px = 0;
  std::vector<LedgerInput> inputs;  ///< picture files with their digests; none from a live camera
};

/// Options of the views of a mark.
struct MarkViews {
  int tool = 1;                     ///< vision tool: disc, hole or ring
  std::optional<double> zoom = {};  ///< level; absent: as the machine stands
  int per_side = 5;  ///< of the lattice of pixels at which the mark is shown, 3 to 21
  Length approach_distance = mm(1);  ///< every view is come to from so far below, both axes
};

/// The calibration of a zoom level, or of the camera as it stands; null where there is none.
const CameraCalibration* camera_at(const MachineConfig& config, const std::optional<double>& zoom);

/// True if [machine] travel lets the spindle go there.
bool is_in_travel(const MachineConfig& config, const Position<frame::Machine>& spindle);
/// Checks that it does.
///
/// In     at: of the message; what: "a calibration of the camera sends the spindle to"
/// Fails  travel-exceeded
Expected<void> check_travel(const MachineConfig& config,
                            const Position<frame::Machine>& spindle,
                            Place at,
                            std::string_view what,
                            std::string expected = "places within [machine] travel");

/// Drives a mark over the whole picture: a lattice of pixels, each come to from the same side, so
/// that backlash is in all views alike and in none of the camera.
///
/// A first picture at `place` says where the mark really lies; by how much it may be off is
/// [vision] search_radius_mm. It is not one of the views.
///
/// Targets are fitted as circles in the picture itself, without the present calibration, which so
/// has no influence on the next one; the fit knows how their centres are biased. To the detector's
/// covariance comes [uncertainty] stage_repeatability_um, through the present scale.
///
/// In     place: of the mark, where the present calibrations have it
/// Fails  config-value (no [camera], a zoom that is not calibrated, an option); travel-exceeded,
///        before anything moves; vision-tool-undefined; target-invalid (not a round mark);
///        target-not-found (nothing at `place`); picture-mismatch; device errors
/// Cost   per_side^2 + 1 pictures
/// See    tests/machine/calibrate/camera/run_test.cc
Expected<MarkSights> look_at_mark(const MachineConfig& config,
                                  const CalibrationDevices& devices,
                                  const Position<frame::Machine>& place,
                                  const MarkViews& views);

/// The same from recorded pictures, whose x, y say where the axis was sent to. Those of another
/// vision tool or zoom are skipped.
///
/// [camera] may be absent where the vision tool has its size in pixels: so a camera is calibrated
/// for the first time.
/// Fails  vision-tool-undefined; target-invalid; picture-mismatch (not all of one size);
///        travel-exceeded; what reading a picture reports
Expected<MarkSights> look_at_folder(const MachineConfig& config,
                                    const PictureFolder& folder,
                                    const MarkViews& views);

/// Takes all views of recorded pictures to where the optical axis stood (axis_from_listed()). Not
/// for those that a table is calibrated with: they are to show its whole error.
///
/// Fails  travel-exceeded
Expected<void> correct_views(const MachineConfig& config, MarkSights& sights);

/// Lines of a report: which pictures of a plate with tags were left out and why, and how many show
/// no tag.
std::string pictures_report(const std::vector<MissedPicture>& left_out,
                            const std::vector<std::string>& without_tag);

}  // namespace panelcal
