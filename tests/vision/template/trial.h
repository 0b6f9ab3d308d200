// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/base/units.h"
#include "vision/fit/target.h"
#include "vision/picture/image.h"
#include "vision/render/render.h"
#include <Eigen/Core>

namespace panelcal::test {

/// Options of a mark's photographs, once as the template and then in the pictures.
struct TemplateTrialOptions {
  std::uint64_t seed = 1;
  int n = 300;
  double contrast = 140;
  double noise = 2;
  double template_noise = 2;
  double blur_px = 1.0;
  double template_blur_px = 1.0;
  double light_gradient = 0;
  double weave = 0;  ///< amplitude, grey levels; in template and pictures
  double max_turn_deg = 3;
  double size_change = 0;  ///< relative, of the mark in the pictures
  int n_debris = 0;        ///< dark and bright crumbs on the mark
  bool with_mapping = true;
  bool fixed_template = false;  ///< the same template in all trials
};

/// Pose of a mark; its size against nominal.
struct MarkPose {
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
  double turn = 0;  ///< rad, in Optical
  double scale = 1;
};

inline constexpr int kTemplateWidth = 92;
inline constexpr int kTemplateHeight = 84;
inline constexpr int kTrialSide = 200;

/// A mark without any symmetry: a ring, bars and a disc. Levels 0 to 1 of full scale.
std::vector<Feature> mark(const Camera& camera, const MarkPose& pose, double level);

/// The template of the mark, its reference in the middle of the mark.
std::shared_ptr<const TemplatePicture> template_of_mark(const TemplateTrialOptions& options,
                                                        const Eigen::Vector2d& phase_px,
                                                        Random& random);

/// A picture with its truth.
struct TemplateTrial {
  Scene scene;
  Camera camera;
  Target target;
  MarkPose pose;
  Image image;
};
TemplateTrial draw_template_trial(const TemplateTrialOptions& options, Random& random);

/// The Cramer-Rao bound of both coordinates, px^2, from the noise-free pictures' numerical
/// derivatives over the template's area, with place, turn, scale, brightness plane, contrast, its
/// gradient and blur unknown. The template's noise counts like the picture's.
Eigen::Matrix2d template_bound(const TemplateTrial& trial, const TemplateTrialOptions& options);

struct TemplateStatistics {
  int n = 0;
  int n_found = 0;
  std::string first_failure;
  Eigen::Vector2d rmse = Eigen::Vector2d::Zero();  ///< in units of the bound
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d rmse_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d peer_rmse_px = Eigen::Vector2d::Zero();  ///< matchTemplate and a parabola
  double nees = 0;
  double angle_nees = 0;
  double milliseconds = 0;
  double mean_score = 0;

  std::string text() const;
};
TemplateStatistics run_template_trials(const TemplateTrialOptions& options);

}  // namespace panelcal::test
