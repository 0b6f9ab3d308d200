// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/statistics/random.h"
#include "calib/base/units.h"
#include "calib/camera/mapping.h"
#include "machine/config/machine_config.h"
#include "vision/fit/target.h"
#include "vision/picture/image.h"
#include "vision/render/render.h"
#include <Eigen/Core>

namespace panelcal {

/// The truth of one picture of a single target.
struct SampleTruth {
  std::string file;
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
  /// From the optical axis, on the board; only of a target whose size is in mm.
  std::optional<Eigen::Vector2d> center_mm;
  Angle angle;         ///< in the frame of Target; 0 for discs, holes and rings
  double visible = 1;  ///< part of the outline without debris; of slots near the target
  int n_neighbors = 0;
  /// Of a ring: from its middle to that of its hole.
  std::optional<Eigen::Vector2d> hole_offset_px;
};

/// Pictures of one vision tool's target, each at another place and angle.
struct SampleSet {
  std::uint64_t seed = 1;
  Target target;
  PixelLength size;  ///< as Target::size means it, in undistorted pixels
  double noise = 0;  ///< sigma per pixel, grey levels of the pictures
  double blur_px = 0;
  std::vector<SampleTruth> pictures;
};

/// One picture with its truth; its file has no name yet.
struct Sample {
  Image image;
  SampleTruth truth;
};

/// Renders single targets as [sim] describes camera, light, board, neighbours and debris.
///
/// The target is whole within the picture (a slot runs through it), its place is random to the
/// fraction of a pixel, and its angle within the tool's angle_tolerance, or any for tags.
class SampleRenderer {
 public:
  /// In     a config with a [camera] if the tool's size is in mm
  /// Fails  config-value (no [sim]; a target too large for the picture, or one of no known tag);
  ///        vision-tool-undefined
  static Expected<SampleRenderer> create(const MachineConfig& config, int tool);

  /// Picture number i: a function of i and of the seed.
  Sample draw(int i) const;
  /// The common part of all pictures.
  const SampleSet& common() const { return common_; }

 private:
  SampleRenderer(const MachineConfig& config, const Target& target);
  Eigen::Vector2d draw_place(Random& random) const;
  Angle draw_turn(Random& random) const;
  std::vector<Feature> shortened(std::vector<Feature> mark) const;

  SimConfig sim_;
  Target target_;
  CameraMapping calibrated_;
  Camera camera_;
  SampleSet common_;
  double reach_px_ = 0;
};

/// Writes `count` pictures, 0000.png and so on, and then truth.json: docs/formats/sample_truth.md.
///
/// Fails  device-write; usage (the folder holds pictures of someone else)
Expected<SampleSet> write_samples(const SampleRenderer& renderer,
                                  int count,
                                  const std::filesystem::path& folder);

/// The content of truth.json; numbers in the fewest digits that read back exactly.
std::string sample_truth_text(const SampleSet& samples);

}  // namespace panelcal
