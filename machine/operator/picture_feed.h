// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/expected.h"
#include "calib/base/machine_uncertainty.h"
#include "machine/config/settings/vision_options.h"
#include "machine/look/picture_locator.h"
#include "machine/operator/desk.h"
#include "machine/operator/screen.h"

namespace panelcal::internal {

/// A picture's pixels as places.
struct ShownPicture {
  MeasurementRequest request;  ///< that it was taken for
  View view;
  Position<frame::Machine> axis;
  ZoomedCamera camera;
  std::string name;                         ///< file name, empty if it is in no file
  std::vector<ScreenCandidate> candidates;  ///< all places that were fitted

  /// The place that a pixel shows, relative to the request's work zero, with the covariance of
  /// `sigma_px` in each axis.
  PositionEstimate<frame::Actual> place_of(const Eigen::Vector2d& at_px, double sigma_px) const;
  /// d place / d camera calibration.
  CameraJacobian by_camera(const Eigen::Vector2d& at_px) const;
  /// The pixel that shows a place of the request; empty outside of the picture.
  std::optional<Eigen::Vector2d> pixel_of(const Position<frame::Actual>& place) const;
};

/// Brings pictures to the screens, and knows the last one.
class PictureFeed {
 public:
  PictureFeed(Desk& desk, const VisionOptions& vision, double max_blur_px)
      : desk_(desk), vision_(vision), max_blur_px_(max_blur_px) {}

  /// A picture in which a target was looked for.
  void see(const SeenView& seen);
  /// A picture for a person alone.
  void show(const MeasurementRequest& request,
            const View& view,
            const TakenPicture& picture,
            const ZoomedCamera& camera);

  const std::optional<ShownPicture>& shown() const { return shown_; }
  const std::string& jpeg() const { return jpeg_; }  ///< of the shown one; empty: none

 private:
  ScreenView view_of(const ShownPicture& shown, const Image& image) const;
  void put(ShownPicture shown, const Image& image, ScreenView view);

  Desk& desk_;
  VisionOptions vision_;
  double max_blur_px_;
  std::optional<ShownPicture> shown_;
  std::string jpeg_;
};

/// A live picture that no job has asked for, so that its pixels have no place.
void show_plain(Desk& desk, const Image& image);

}  // namespace panelcal::internal
