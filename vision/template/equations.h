// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "vision/fit/frame.h"
#include "vision/picture/image.h"
#include "vision/template/model.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// Parameter order; units are the fit frame's (about px), rad and grey levels.
enum TemplateParameter {
  kPlaceX,  ///< of the template's reference
  kPlaceY,
  kTurn,      ///< angle in the frame
  kLogScale,  ///< log of the seen size over the nominal one
  kLevel,     ///< brightness plane at the window's middle, then its slopes per window unit
  kLevelX,
  kLevelY,
  kGain,  ///< grey levels per contrast of the template, then its slopes: light multiplies
  kGainX,
  kGainY,
  kFocus,  ///< share of the template's curvature: half the difference of the squared blurs, px^2
  kTemplateParameters
};
inline constexpr int kPoseParameters = 4;
inline constexpr int kLinearStart = kLevel;

using TemplateVector = Eigen::Matrix<double, kTemplateParameters, 1>;
using TemplateMatrix = Eigen::Matrix<double, kTemplateParameters, kTemplateParameters>;

/// A pixel, or an average of some, that takes part in a fit.
struct TemplatePixel {
  Eigen::Vector2d at;     ///< in the fit frame
  Eigen::Vector3d plane;  ///< (1, x, y) from the window's middle, in window units
  double value = 0;       ///< grey level
  double weight = 1;      ///< 1 / variance of its noise
  int x = 0;              ///< in the picture, at level 0
  int y = 0;
  bool is_excluded = false;
};

/// The part of a picture that a template covers.
struct TemplateWindow {
  std::vector<TemplatePixel> pixels;
  int level = 0;  ///< pixels and the template are averaged by 2^level
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< of the template, fit frame
  double unit = 1;        ///< half the template's larger side, fit frame units
  double seen_share = 1;  ///< part of the template that is inside the picture
  int x0 = 0;             ///< bounding box in the picture, at level 0
  int y0 = 0;
  int width = 0;
  int height = 0;
};

/// Fit frame places of template pixels and back.
class TemplateMap {
 public:
  TemplateMap(const TemplateModel& model, const TemplateVector& p);

  Eigen::Vector2d to_template(const Eigen::Vector2d& x) const {
    return reference_ + px_from_frame_ * (x - place_);
  }
  Eigen::Vector2d to_frame(const Eigen::Vector2d& t) const {
    return place_ + frame_from_px_ * (t - reference_);
  }
  /// d template px / d (place, turn, log scale) at a place of the template.
  Eigen::Matrix<double, 2, 4> derivative(const Eigen::Vector2d& t) const;

 private:
  Eigen::Vector2d place_;
  Eigen::Vector2d reference_;
  Eigen::Matrix2d px_from_frame_;
  Eigen::Matrix2d frame_from_px_;
  Eigen::Matrix2d turn_;  ///< d t / d turn = turn_ (t - reference)
};

/// Collects the pixels that a pose's template covers, but for the template's outermost ones.
TemplateWindow make_template_window(const Image& image,
                                    const FitFrame& fit_frame,
                                    const TemplateModel& model,
                                    const TemplateVector& pose,
                                    int level);

/// The picture of a template as a function of the parameters, at one pixel.
///
///   I(u) = plane(u) + gain(u) T(pose(u)) + focus curvature(pose(u))
struct TemplateValue {
  double level = 0;
  double smooth_level = 0;  ///< with the smooth template
  double gain = 0;
  Eigen::Vector2d at;         ///< in the template, px of its level
  Eigen::Vector2d slope;      ///< of the picture's model, smooth, per template px
  TemplateVector smooth_row;  ///< d smooth_level / d parameters
  TemplateVector row;         ///< d level / d parameters; only if asked for
};

/// Evaluates it; empty if the pose has left the pixel outside of the template.
std::optional<TemplateValue> evaluate(const TemplateModel& model,
                                      const TemplateWindow& window,
                                      const TemplateMap& map,
                                      const TemplatePixel& pixel,
                                      const TemplateVector& p,
                                      bool with_row);

/// The prior of turn and scale before the picture is seen; it keeps what the data does not
/// tell, such as a disc's angle, where it is expected.
struct TemplatePrior {
  double turn = 0;  ///< rad
  double turn_sigma = 1;
  double log_scale_sigma = 1;

  /// Its part of the information matrix, and what it adds to J^T W (data - model).
  TemplateVector information() const;
  TemplateVector pull(const TemplateVector& p) const;
};

}  // namespace panelcal::internal
