// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "machine/devices/camera.h"
#include "program/model/measurement.h"
#include "vision/fit/detection.h"
#include "vision/picture/image.h"

namespace panelcal {

/// A target that was looked for before it was asked for. It is the answer to the very same question
/// only: the same vision tool, zoom and searched circle.
struct KnownDetection {
  int tool = 0;
  std::optional<double> zoom;
  std::optional<Position<frame::Image>> search_center;
  std::optional<PixelLength> search_radius;
  Detection detection;
};

/// A picture and where it was taken.
struct TakenPicture {
  Image image;
  Position<frame::Machine> axis;  ///< place of the optical axis by the calibration
  std::string name;               ///< file name; empty if the picture is in no file
  std::string path;               ///< of that file, for diagnostics
  std::shared_ptr<const KnownDetection> known = {};  ///< its detection, made ahead; may be null
};

/// One look at the panel.
struct View {
  Position<frame::Machine> axis;  ///< wanted place of the optical axis
  int i_view = 0;                 ///< of several places around one target: four views, a spiral
  int i_tool = 0;                 ///< of the request's vision tools, the one to look with
  int i_inspection = 0;           ///< of several pictures of one view
  std::optional<Length> focus_z;  ///< wanted height of the camera's focus axis; absent: as it is
};

/// Shows the panel at a place: a machine with a camera, a simulation of one, a folder of
/// recorded pictures.
class ViewTaker {
 public:
  virtual ~ViewTaker() = default;
  /// Lamp, zoom and exposure are those of the request's settings.
  ///
  /// Fails  picture-missing (recorded pictures: none was taken there); device errors
  virtual Expected<TakenPicture> take(const MeasurementRequest& request, const View& view) = 0;
  /// Requests can set it.
  virtual bool can_set(CameraSetting /*setting*/) const { return false; }
  /// Of the next picture, us; absent where the camera does not tell it.
  virtual std::optional<double> exposure_us() const { return std::nullopt; }
};

}  // namespace panelcal
