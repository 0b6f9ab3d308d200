// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "tests/vision/tag/trial.h"

namespace panelcal::test {

/// Root of the mean square of one coordinate's error, px.
struct Rmse {
  double sum = 0;
  int n = 0;

  void add(const Eigen::Vector2d& error);
  double value() const;
};

struct TagErrors {
  Rmse center;
  Rmse corners;
  int n_found = 0;
  double ms = 0;  ///< of processor time a picture
};

struct TagAccuracy {
  TagErrors ours;
  TagErrors library;  ///< its half pixel corrected
  TagErrors opencv;   ///< cornerSubPix from the library's corners; the time comes on top
  Rmse center_bound;
  Rmse corner_bound;
  double center_chi_square = 0;  ///< mean of e^T cov^-1 e / 2: 1 for an honest covariance
  double corner_chi_square = 0;
  std::string first_failure;
};

struct TagTrials {
  std::uint64_t seed = 20261121;
  int n = 320;
  std::string family = "tag36h11";
  int id = 7;
  double side_px = 120;
  double tilt_rad = 0.5;  ///< largest
  /// Bounds differ by a few per cent from picture to picture: every so many'th gives the mean.
  int bound_each = 20;
  /// Covered part of every second tag's face, and of the others' outline.
  double dirt = 0;
  int n_scratches = 0;
  int n_neighbours = 0;
};

/// Finds a tag in many poses, with others' methods beside on the same pictures.
///
/// In     scene: its pattern and pose are set here
TagAccuracy run_tag_trials(TagScene scene, const TagTrials& trials);

/// Contrast 140, noise 2, blur 1; and contrast 100, noise 5, blur 1.5 with a gradient of light.
TagScene clean_tag_scene();
TagScene typical_tag_scene();
/// Contrast 40, noise 12, blur 2.5.
TagScene dim_tag_scene();
/// The trials of hard pictures, for dim_tag_scene(): a tenth covered, two scratches, neighbours.
TagTrials hard_tag_trials();

}  // namespace panelcal::test
