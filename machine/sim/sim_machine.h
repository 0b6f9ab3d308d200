// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "panelcal/calib/base/expected.h"
#include "panelcal/calib/base/random.h"
#include "panelcal/calib/camera_mapping.h"
#include "panelcal/calib/spindle_camera.h"
#include "panelcal/machine/machine_config.h"
#include "panelcal/machine/picture_locator.h"
#include "panelcal/machine/sim/truth.h"
#include "panelcal/program/measurement.h"
#include "panelcal/program/walk.h"
#include "panelcal/vision/image.h"
#include "panelcal/vision/render.h"

namespace panelcal {

/// A virtual machine with a panel on its table.
///
/// For each request it drives the camera to the expected place as a real machine would, with the
/// calibrated spindle-camera offset, renders what the real camera then sees there, and locates the
/// target with the calibrated camera. The truth never enters a measurement.
///
/// On the panel lie all targets of the program, each with its vision tool's shape and size, and in
/// each view `neighbors` other pads of other sizes. All that is random is a function of the seed
/// and of the request's seq, so the order of requests does not matter and a seed names one panel
/// for ever.
class SimMachine final : public MeasurementSource {
 public:
  /// Walks through the program once to learn where its targets are.
  ///
  /// Fails  config-value (no [sim] or no [camera]); vision-tool-undefined; not-supported; the first
  ///        error of the program
  static Expected<SimMachine> create(const MachineConfig& config,
                                     const Program& program,
                                     PictureObserver observer = {});

  Expected<Measurement> measure(const MeasurementRequest& request) override;

  /// Picture number i of a request; `axis` is where the machine believes the optical axis to be.
  ///
  /// Fails  vision-tool-undefined; not-supported
  Expected<TakenPicture> take_picture(const MeasurementRequest& request, int i) const;

  /// How many pictures a request asks for.
  ///
  /// Fails  not-supported (more than 100)
  static Expected<int> inspections_of(const MeasurementRequest& request);

  const PictureLocator& locator() const { return locator_; }
  const Truth& truth() const { return truth_; }

 private:
  /// A target on the panel.
  struct Mark {
    Position<frame::Machine> place;
    Target target;
  };

  SimMachine(const MachineConfig& config, PictureLocator locator);
  Expected<void> place_marks(std::span<const MeasurementRequest> requests,
                             const std::filesystem::path& config_file);
  Feature feature_of(const Target& target, const Position<frame::Optical>& center) const;
  std::vector<Feature> marks_in_view(const Position<frame::Machine>& true_axis) const;
  void add_neighbors(const Target& target, Random random, std::vector<Feature>& features) const;

  SimConfig sim_;
  SpindleCameraOffset calibrated_offset_;
  CameraMapping calibrated_camera_;
  Camera camera_;
  PictureLocator locator_;
  Truth truth_;
  std::vector<Mark> marks_;  ///< by x, so that a view's are found quickly
  double view_radius_mm_ = 0;
};

}  // namespace panelcal
