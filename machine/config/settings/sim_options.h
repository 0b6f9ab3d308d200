// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/camera/mapping.h"
#include "vision/render/scene_debris.h"
#include <Eigen/Core>

// The virtual machine of machine.toml, section by section.
namespace panelcal {

/// Area that is broken out of a surface.
struct SimulatedChip {
  Position<frame::Actual> place;
  Length radius;
  Length depth;
};

/// The properties of a simulated board, and of the probe that touches it.
struct SimulatedProbeOptions {
  std::uint64_t seed = 1;
  Length height = mm(1.6);  ///< of the surface above Z0, at work zero
  double slope_x_ppm = 0;   ///< rise along x: 1000 is 1 mm in a metre
  double slope_y_ppm = 0;
  /// A bowl, or with a negative value a hill: how much the surface rises from bow_center to
  /// bow_radius away from it. The bow takes no part in `height`.
  Length bow;
  Position<frame::Actual> bow_center;  ///< relative to work zero
  Length bow_radius = mm(300);         ///< above 0
  std::optional<SimulatedChip> chip;   ///< radius and depth above 0
  /// The height that each Z axis reads too high; at least one.
  std::vector<Length> axis_offsets = {Length()};
  Length noise_sigma = um(2);  ///< of one reading; 0 or more

  /// Fails  config-value, without a place
  Expected<void> validate() const;
};

/// The table's own surface, which moves from night to night: the hidden truth of a night's probing.
struct SimTableSurface {
  SimulatedProbeOptions surface;     ///< as it is at `since`; in machine coordinates
  std::chrono::sys_seconds since{};  ///< before that it stands still
  Length height_per_day;             ///< rise
  Eigen::Vector2d slope_ppm_per_day = Eigen::Vector2d::Zero();
  std::optional<SimulatedChip> chip;  ///< that is not there from the beginning
  std::chrono::sys_seconds chip_since{};
};

/// Stops of a virtual machine's stage.
struct SimStops {
  Length stage_repeatability;  ///< of every stop, per axis
  /// Per axis: it stops half of that too low when it moved up, too high when it moved down.
  Displacement<frame::Machine> backlash;
  /// After a move it swings along it: amplitude exp(-t / decay) cos(2 pi frequency t).
  Length swing;
  Time swing_decay = seconds(0.05);
  double swing_hz = 20;
};

/// The properties of a virtual machine over a coupon, on top of [sim]: [sim.coupon].
struct SimCouponOptions : SimStops {
  std::uint64_t seed = 1;
  Length wander;        ///< of the drill, per axis
  int vision_tool = 1;  ///< its drill makes holes of this vision tool's kind and size
  /// Something fixed to the table, of a vision tool's look; absent: nothing is there.
  std::optional<Position<frame::Machine>> mark;
  int mark_tool = 1;
  /// Displacement of the spindle-camera offset of a machine that was just started from that of the
  /// warm one; after a time t the rest of it is cold exp(-t / warm_up).
  Displacement<frame::Machine> cold;
  Time warm_up = seconds(600);
};

/// [sim.table]: where the virtual machine's stage really stands, commanded c mm from `center`.
///
///   x error = scale_x x + squareness y + bow_y (y / r)^2
///   y error = scale_y y + bow_x (x / r)^2,                 (x, y) = c - center, r = bow_radius
///
/// in the convention of TableGeometry: the x axis lies along x, and the angle between the axes is
/// 90 degrees minus the squareness.
struct SimTable {
  double scale_x_ppm = 0;
  double scale_y_ppm = 0;
  Angle squareness;
  Length bow_x;  ///< of the x axis: in y, at its ends
  Length bow_y;  ///< of the y axis: in x
  Length bow_radius = mm(300);
  Position<frame::Machine> center;

  Eigen::Vector2d error_mm(const Position<frame::Machine>& command) const;

  friend bool operator==(const SimTable&, const SimTable&) = default;
};

/// [sim]: the hidden truth of the virtual machine. Only machine/sim and `synth` read it.
struct SimConfig {
  std::uint64_t seed = 1;
  // The panel: actual = R(rotation) diag(1 + stretch) nominal + offset, about work zero.
  Displacement<frame::Actual> panel_offset;
  Angle panel_rotation;
  double stretch_x_ppm = 0;
  double stretch_y_ppm = 0;
  // Every step-and-repeat instance on top of it: normal scatter of one standard deviation per axis,
  // the rotation about the instance's own first target.
  Length board_offset_sigma;
  Angle board_rotation_sigma;
  /// The real camera, of which [camera] is the calibration. Absent: the calibration is exact.
  std::optional<CameraMapping::Parameters> camera;
  /// The real offset; absent: as calibrated.
  std::optional<Displacement<frame::Machine>> spindle_camera_offset;
  int width_px = 640;  ///< as [camera] was calibrated for, if there is one
  int height_px = 480;
  double blur_px = 1.0;         ///< sigma of the lens, 0.3 or more
  double noise = 0;             ///< sigma in grey levels of 255
  double background = 0.3;      ///< 0 to 1 of full scale
  double target_level = 0.7;    ///< of bright targets; dark ones are as much darker, down to black
  double light_gradient = 0;    ///< relative change from the left to the right edge of the picture
  double light_gradient_y = 0;  ///< from top to bottom
  double vignetting = 0;        ///< relative loss of light in the corners
  double weave_amplitude = 0;   ///< of full scale
  Length weave_period = mm(0.5);
  int neighbors = 0;        ///< other pads in each view
  double full_scale = 255;  ///< or 65535; noise is in levels of 255 in either case
  double shot_noise = 0;    ///< grey levels per electron
  double hot_pixels = 0;    ///< share of the pixels
  Angle tilt;               ///< of the board against the picture's plane, see Camera
  Angle tilt_axis;
  Length burrs;                       ///< rms of the radius of holes
  Length ring_offset_sigma;           ///< per axis, of holes against their rings
  std::optional<Length> slot_length;  ///< absent: through the whole picture
  DebrisOptions debris;               ///< on each mark
  /// The `$uvis,lamp` at which pictures are as bright as said above; brightness goes with it.
  /// Absent: lamp orders change nothing.
  std::optional<double> lamp;
  /// Height at which the camera is sharp; unfocused it stands at [camera] focus_mm, or 0. Absent:
  /// anywhere.
  std::optional<Length> focus_z;
  Length focus_depth = mm(0.1);   ///< so far from there edges are sqrt(2) times as wide
  SimulatedProbeOptions surface;  ///< of the board, and how well it is probed
  /// [sim.table_surface]: of the table itself, which a night probes.
  std::optional<SimTableSurface> table_surface;
  SimCouponOptions coupon;        ///< [sim.coupon], with the seed of [sim]
  std::optional<SimTable> table;  ///< [sim.table]; absent: the stage stands where it is sent
};

}  // namespace panelcal
