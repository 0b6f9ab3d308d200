// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/statistics/random.h"
#include "calib/camera/mapping.h"
#include "calib/correction/spindle_camera.h"
#include "machine/calibrate/spindle/job_calibration.h"
#include "machine/config/machine_config.h"
#include "machine/look/view_taker.h"
#include "machine/look/vision_procedure.h"
#include "machine/sim/sim_coupon.h"
#include "machine/sim/truth.h"
#include "program/model/measurement.h"
#include "program/walk/walk.h"
#include "vision/picture/image.h"
#include "vision/render/render.h"

namespace panelcal {

/// A virtual machine with a panel on its table.
///
/// For each request it drives the camera to the expected place as a real machine would, with the
/// calibrated spindle-camera offset and table on a stage that errs by [sim.table], renders what the
/// real camera then sees there, and locates the target with the calibrated camera. The truth never
/// enters a measurement.
///
/// Panel and coupon are on one machine: one focus, one lamp and one clock, with which the offset of
/// a cold machine ([sim.coupon] cold_um) goes over to that of the warm one.
///
/// A target where the program has drilled before it looks there is that hole, where the spindle
/// really drilled it. So is one at a place where a calibration of this job has drilled the coupon.
/// Holes at other places are not drawn, and a target that stands on the drilled board itself (a
/// square, a cross) stays whole but for its place.
///
/// On the panel lie all targets of the program, each with its vision tool's shape and size (four
/// marks around a target of four views) and the debris of [sim], and in each view `neighbors` other
/// marks of other sizes. All that is random is a function of the seed and of the request's seq, so
/// the order of requests does not matter to a warm machine, and a seed names one panel for ever.
class SimMachine final : public MeasurementSource, public ViewTaker, public DrilledPanel {
 public:
  /// Walks through the program once to learn where its targets are.
  ///
  /// Fails  config-value (no [sim] or no [camera]); vision-tool-undefined; not-supported; the first
  ///        error of the program
  static Expected<SimMachine> create(const MachineConfig& config,
                                     const Program& program,
                                     PictureObserver observer = {});
  /// The same for a program that was checked.
  ///
  /// In     nominal: what the check has measured on a perfect panel
  static Expected<SimMachine> create(const MachineConfig& config,
                                     const Survey& nominal,
                                     PictureObserver observer = {});

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    return measure(request, *this);
  }
  /// The same, by pictures that pass through other hands.
  Expected<Measurement> measure(const MeasurementRequest& request, ViewTaker& eye);
  Expected<std::optional<FocusResult>> focus(const MeasurementRequest& request) override {
    return procedure_.focus(request, *this);
  }
  /// For the ledger, if calibrations take rows of the coupon.
  void set_taken_by(TakenBy by) { taken_by_ = std::move(by); }

  /// Drills into a virtual coupon ([sim.coupon]) beside the panel, and looks at it.
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override;

  DrilledPanel* drilled_panel() override { return this; }
  /// Drills where the spindle really stands when it is sent to a place, with the wander and the
  /// stage's repeatability of [sim.coupon]. Of a target that the program has there it makes the
  /// hole; the first one stays, which a drill that comes again follows.
  void drill(const DrilledHole& hole) override;

  /// The camera's picture now; the picture's axis is where the machine believes it to be.
  ///
  /// Fails  vision-tool-undefined; what VisionProcedure reports of a request it cannot answer
  Expected<TakenPicture> picture(const MeasurementRequest& request, const View& view) const;
  /// The same; waits before each view, which may warm up meanwhile.
  Expected<TakenPicture> take(const MeasurementRequest& request, const View& view) override;
  bool can_set(CameraSetting setting) const override {
    return setting == CameraSetting::Lamp && sim_.lamp.has_value();
  }

  const VisionProcedure& procedure() const { return procedure_; }
  /// As the orders of the job have found it so far.
  SpindleCameraOffset offset() const { return job_.offset(); }
  const Truth& truth() const { return truth_; }

 private:
  /// A target on the panel: what it and its dirt look like at the optical axis.
  struct Mark {
    Position<frame::Machine> place;
    Position<frame::Machine> programmed;  ///< place by the program
    bool is_hole = false;                 ///< drilled by this machine
    std::vector<Feature> features;
    std::vector<Feature> debris;
    double reach_mm = 0;
  };

  /// Place of a target by the program.
  struct TargetPlace {
    Position<frame::Machine> programmed;
    Position<frame::Machine> work_zero;
    std::size_t i_target = 0;  ///< index into Truth::targets
  };

  SimMachine(const MachineConfig& config, VisionProcedure procedure);
  /// The coupon as the camera at an order's zoom sees it.
  Expected<SimCoupon*> coupon_for(const CalibrationOrder& order);
  Expected<void> place_marks(std::span<const MeasurementRequest> requests,
                             const std::filesystem::path& config_file);
  void tell_holes(std::span<const MeasurementRequest> requests);
  std::vector<TargetPlace> targets_at(const Position<frame::Machine>& programmed) const;
  /// Makes the targets that the program has at a place the hole that was drilled for it.
  void make_hole(const Position<frame::Machine>& programmed, const Position<frame::Machine>& hole);
  Mark make_mark(const MeasurementRequest& request,
                 const Target& target,
                 const Position<frame::Machine>& place,
                 std::size_t i_mark) const;
  void set_light(const MeasurementRequest& request, Scene& scene) const;
  Expected<Camera> camera_for(const MeasurementRequest& request, const View& view) const;
  /// True place of the spindle that was sent to a place, by way of the calibrated table.
  Expected<Position<frame::Machine>> stands_at(const Position<frame::Machine>& spindle) const;
  SpindleCameraOffset true_offset() const {
    return internal::sim_offset_at(now_, warm_offset_, sim_.coupon);
  }
  std::vector<const Mark*> marks_in_view(const Position<frame::Machine>& true_axis) const;

  SimConfig sim_;
  Length stated_focus_;                           ///< [camera] focus_mm, or 0
  std::optional<double> stated_lamp_;             ///< [camera] lamp
  std::shared_ptr<const TableCorrection> table_;  ///< as calibrated; may be null
  SpindleCameraOffset warm_offset_;               ///< the true one, see true_offset()
  Time settle_;
  Time now_;  ///< since the machine was started; only waiting takes time
  JobCalibration job_;
  TakenBy taken_by_;
  std::optional<SimCoupon> coupon_;  ///< none until the first calibration
  CameraMapping calibrated_camera_;
  Camera camera_;
  VisionProcedure procedure_;
  Truth truth_;
  std::vector<Mark> marks_;                 ///< by x, so that a view's are found quickly
  std::vector<TargetPlace> target_places_;  ///< by x
  std::int64_t last_seq_ = -1;              ///< of the requests that pictures were taken for
  double view_radius_mm_ = 0;               ///< of the widest view, from its axis
  double largest_reach_mm_ = 0;             ///< of any mark
};

}  // namespace panelcal
