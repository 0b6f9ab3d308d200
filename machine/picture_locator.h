// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "panelcal/calib/base/expected.h"
#include "panelcal/calib/camera_mapping.h"
#include "panelcal/machine/machine_config.h"
#include "panelcal/program/measurement.h"
#include "panelcal/vision/image.h"
#include "panelcal/vision/locate.h"
#include "panelcal/vision/target.h"

namespace panelcal {

/// Sees every picture that is looked at and what was found in it, for reports and overlays.
using PictureObserver =
    std::function<void(const MeasurementRequest&, const Image&, const Detection&)>;

/// A picture and where it was taken.
struct TakenPicture {
  Image image;
  Position<frame::Machine> axis;  ///< where the optical axis stood, as the calibration has it
  std::string name;               ///< file name; empty if the picture is in no file
  std::string path;               ///< of that file, for diagnostics
};

/// From pictures to the answer to a measurement request: all that recorded, simulated and live
/// pictures have in common.
///
///   measured = axis + K(u) - work zero
///
/// The covariance is the detection's, brought to mm. What all pictures of a machine share is left
/// out: errors of the camera calibration and of the spindle-camera offset move every target of a
/// panel alike, so that as independent errors of single targets they would be averaged away.
class PictureLocator {
 public:
  /// Fails  config-value (no [camera])
  static Expected<PictureLocator> create(const MachineConfig& config,
                                         PictureObserver observer = {});

  /// Gives picture number i of a request, from 0.
  using NextPicture = std::function<Expected<TakenPicture>(int i)>;

  /// Finds the request's target in `n_pictures` >= 1 pictures and averages them with the weights of
  /// their covariances; one picture without the target decides for all of them. The score is the
  /// least one, the image the first one's.
  ///
  /// Averaging takes the pictures' errors as independent, as noise is. What does not change from
  /// picture to picture, such as weave, is not averaged away: the covariance of many pictures of
  /// one place is then too small.
  ///
  /// Fails  vision-tool-undefined; not-supported (targets seen in four views); picture-missing (the
  ///        expected place is outside of the picture); picture-mismatch (size); what `next` reports
  Expected<Measurement> measure(const MeasurementRequest& request,
                                int n_pictures,
                                const NextPicture& next) const;

  /// The vision tool a request asks for.
  ///
  /// Fails  vision-tool-undefined; not-supported (targets seen in four views)
  Expected<Target> target_of(const MeasurementRequest& request) const;

  /// Where a place is seen in a picture taken at `axis`; empty if outside of the picture.
  std::optional<Position<frame::Image>> pixel_of(const Position<frame::Machine>& place,
                                                 const Position<frame::Machine>& axis) const;

 private:
  explicit PictureLocator(const MachineConfig& config, PictureObserver observer);
  Expected<Measurement> measure_one(const MeasurementRequest& request,
                                    const Target& target,
                                    const TakenPicture& picture) const;
  Expected<Position<frame::Image>> check_picture(const MeasurementRequest& request,
                                                 const TakenPicture& picture) const;

  std::filesystem::path config_file_;
  CameraMapping mapping_;
  int width_px_;
  int height_px_;
  LocateOptions locate_;
  std::map<int, Target> vision_tools_;
  PictureObserver observer_;
};

/// "G46 target 7 (line 12)", as messages name a request.
std::string describe(const MeasurementRequest& request);

}  // namespace panelcal
