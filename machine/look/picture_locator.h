// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/camera/calibration/shared_error.h"
#include "calib/camera/mapping.h"
#include "calib/camera/model.h"
#include "machine/config/machine_config.h"
#include "machine/devices/picture_observer.h"
#include "machine/look/view_taker.h"
#include "program/model/measurement.h"
#include "vision/fit/target.h"
#include "vision/locate/locate.h"
#include "vision/picture/image.h"

namespace panelcal {

/// A camera with a tilt or a lens that CameraMapping does not know.
struct TiltedCamera {
  CameraModel model;
  SharedCameraError error;
};

/// A camera at one zoom.
struct ZoomedCamera {
  /// All of the camera, or what targets are searched and fitted with if there is `tilted`.
  CameraMapping mapping;
  int width_px = 0;
  int height_px = 0;
  std::optional<TiltedCamera> tilted = {};

  /// The pixel that shows a place relative to the axis; empty where no picture does.
  std::optional<Position<frame::Image>> image_of(const Position<frame::Optical>& place) const;
  /// Derivative by the calibration of a place seen at a pixel; see SharedCameraError.
  CameraJacobian by_calibration(const Position<frame::Image>& pixel) const;
  /// Pixel at which a place is seen in a picture taken at `axis`; empty if outside of the picture.
  std::optional<Position<frame::Image>> pixel_of(const Position<frame::Machine>& place,
                                                 const Position<frame::Machine>& axis) const;
};

/// The target of one view.
struct Look {
  View view;
  Target target;
  Position<frame::Machine> expected;  ///< of the target: middle of where it may be
  std::optional<Length> radius;       ///< of where it may be; absent: anywhere in the picture
  /// The picture has to show this place: the expected one, but for the outer views of a search.
  Position<frame::Machine> shown;
  std::string words;  ///< ", view 2 of 4" for messages; empty for the only view
};

/// The result of one view.
struct Sight {
  MeasurementStatus status = MeasurementStatus::NotFound;
  std::string reason;
  std::string image;  ///< file name of the picture
  std::optional<double> score;
  PositionEstimate<frame::Actual> place;              ///< if found; relative to work zero
  CameraJacobian by_camera = CameraJacobian::Zero();  ///< as SharedCameraError::by, if found
  /// Slots: the unit vector, machine directions, along which nothing was measured. `place` is then
  /// the foot of the expected place on the slot's middle line.
  std::optional<Eigen::Vector2d> blind;
  std::optional<Displacement<frame::Actual>> scatter;  ///< of repeated inspections
  std::vector<MeasuredCandidate> candidates;           ///< not of slots
  std::optional<ListedArea> listed;

  bool is_found() const { return status == MeasurementStatus::Found; }
};

/// One picture that was looked at and what was found in it.
struct SeenView {
  const MeasurementRequest& request;
  const View& view;
  const TakenPicture& picture;
  const ZoomedCamera& camera;
  const Detection& detection;
};

/// From one picture to a place on the machine.
///
///   measured = axis + K(u) - work zero
///
/// With a camera of CameraModel's full form a target is still fitted in the simple one, in which it
/// lies to a part in 1000 as it does in truth; its centre in the picture becomes mm by the full
/// model then, less the bias of circle centres that the simple form did not know of.
///
/// The covariance is the detection's, brought to mm. What all pictures of a machine share is left
/// out: errors of the camera calibration and of the spindle-camera offset move every target of a
/// panel alike, so that as independent errors of single targets they would be averaged away.
/// Instead there is how the place moves with the calibration's parameters, so that corrections can
/// add up such errors before squaring them.
class PictureLocator {
 public:
  /// Fails  config-value (no [camera])
  static Expected<PictureLocator> create(const MachineConfig& config,
                                         PictureObserver observer = {});

  /// The request's vision tool, or the i-th of four.
  ///
  /// Fails  vision-tool-undefined
  Expected<Target> target_of(const MeasurementRequest& request, int i_tool = 0) const;
  /// The camera at the request's zoom.
  ///
  /// Fails  config-value (a zoom that is not calibrated)
  Expected<ZoomedCamera> camera_of(const MeasurementRequest& request) const;
  /// Checks before the first picture is taken that there is everything a request asks for.
  ///
  /// Fails  vision-tool-undefined; config-value (zoom); not-supported (algorithm, more than 100
  ///        inspections, another number of vision tools than one or four); target-invalid (a slot
  ///        for both coordinates)
  Expected<void> check(const MeasurementRequest& request) const;

  /// Looks for a target in a picture ahead of look(), which then takes this for its answer if it
  /// asks the same. Empty for a picture that look() refuses. May be called on any thread.
  std::optional<KnownDetection> look_ahead(const MeasurementRequest& request,
                                           const Look& look,
                                           const TakenPicture& picture) const;

  /// Looks for a target in a picture.
  ///
  /// Fails  picture-mismatch (size); picture-missing (the picture does not show `look.shown`); what
  ///        camera_of reports
  Expected<Sight> look(const MeasurementRequest& request,
                       const Look& look,
                       const TakenPicture& picture,
                       bool is_observed = true) const;

 private:
  explicit PictureLocator(const MachineConfig& config, PictureObserver observer);
  Expected<void> check_tools(const MeasurementRequest& request) const;
  Expected<void> check_picture(const MeasurementRequest& request,
                               const Look& look,
                               const TakenPicture& picture,
                               const ZoomedCamera& camera) const;
  /// Everything that was seen, for the series to choose among.
  void list_candidates(const MeasurementRequest& request,
                       const Look& look,
                       const TakenPicture& picture,
                       const ZoomedCamera& camera,
                       const Detection& detection,
                       Sight& sight) const;
  LocateOptions options_of(const Look& look,
                           const TakenPicture& picture,
                           const ZoomedCamera& camera) const;

  std::filesystem::path config_file_;
  ZoomedCamera camera_;
  std::map<double, ZoomedCamera> zooms_;
  std::vector<int> algorithms_;
  LocateOptions locate_;
  std::map<int, Target> vision_tools_;
  PictureObserver observer_;
};

/// "G46 target 7 (line 12)", as messages name a request.
std::string describe(const MeasurementRequest& request);

/// The radius of the circle about a target's place that holds all of it.
Length outer_radius(const Target& target, const CameraMapping& mapping);

}  // namespace panelcal
