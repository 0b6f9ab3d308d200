// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/statistics/random.h"
#include "calib/camera/mapping.h"
#include "machine/config/machine_config.h"
#include "vision/fit/target.h"
#include "vision/render/render.h"
#include "vision/render/scene_debris.h"

namespace panelcal::internal {

/// The virtual machine's real camera.
Camera sim_camera(const SimConfig& sim, const CameraMapping& calibrated);

/// The marks that a virtual machine shows of a vision tool.
///
/// Fails  config-value (no [sim] or no [camera]); vision-tool-undefined
Expected<Target> sim_target(const MachineConfig& config, int vision_tool);

/// Blur of pictures while the focus axis stands at a height; `camera` has the blur of the height
/// that [sim] focus_z_mm names.
double blur_px_at(const SimConfig& sim, Length focus, const Camera& camera);

/// Board and light as [sim] describes them, without anything on the board.
Scene sim_scene(const SimConfig& sim);

/// Place of one mark before a camera.
struct SimMarkPlace {
  Position<frame::Optical> center;
  Angle turn;          ///< on top of the target's own angle, the same way round
  Length slot_length;  ///< used if [sim] does not state one
};

/// The features of a mark as [sim] has it printed and drilled.
///
/// In     random: of this mark, for its burrs and for how far a ring's hole is off its centre
std::vector<Feature> sim_mark(const SimConfig& sim,
                              const Target& target,
                              const SimMarkPlace& place,
                              const CameraMapping& calibrated,
                              Random random);

/// Adds [sim] neighbors other marks of other sizes at random places where nothing else is: of the
/// same shape if that is a square, diamond or cross, otherwise round.
void add_neighbors(const SimConfig& sim,
                   const Target& target,
                   const Camera& camera,
                   const CameraMapping& calibrated,
                   Random random,
                   std::vector<Feature>& features);

}  // namespace panelcal::internal
