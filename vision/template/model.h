// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "vision/fit/spline_image.h"
#include "vision/fit/target.h"
#include <Eigen/Core>
#include <tl/expected.hpp>

namespace panelcal::internal {

/// Sigma of the blur between `raw` and `smooth` below, px: it costs 0.3 % in accuracy on an edge of
/// 1 px blur.
inline constexpr double kTemplateSmoothingPx = 0.5;

/// A template picture made ready for fits.
///
/// Its levels are brought to mean 0 and contrast 1. The residuals of a fit are taken from `raw`,
/// their weights from `smooth`: were the same noisy numbers both, the template's noise would pull
/// places towards halves of pixels, where interpolation averages it away best.
struct TemplateModel {
  SplineImage raw;
  SplineImage smooth;     ///< a little blurred, and flat where nothing but noise is seen
  SplineImage curvature;  ///< the Laplacian of `smooth`: what a slightly other focus adds
  std::vector<SplineImage> reduced;  ///< `smooth` averaged by 2, 4, 8 ...
  /// 1 if `smooth` has structure, 0 if it is the local mean.
  Raster structure;
  Eigen::Vector2d reference;  ///< the target's place, px
  double pitch = 1;           ///< fit frame units per px
  /// -1 if y of the fit frame points up, as with a camera mapping: pictures' points down.
  double y_sign = 1;
  double mean = 0;        ///< grey levels of the template
  double contrast = 1;    ///< brightest minus darkest, grey levels of the template
  double noise = 0;       ///< sigma of `raw`
  double background = 0;  ///< of most of the template's border

  int width() const { return raw.width(); }
  int height() const { return raw.height(); }
  Eigen::Vector2d middle() const { return {0.5 * (width() - 1), 0.5 * (height() - 1)}; }
  /// Its rectangle, px.
  std::array<Eigen::Vector2d, 4> corners() const {
    const double right = width() - 0.5;
    const double bottom = height() - 0.5;
    return {Eigen::Vector2d(-0.5, -0.5), {right, -0.5}, {right, bottom}, {-0.5, bottom}};
  }
  /// `smooth` averaged by 2^level, and where a place is in it.
  const SplineImage& level(int level) const {
    return level == 0 ? smooth : reduced[static_cast<std::size_t>(level) - 1];
  }
};

/// Makes a template ready.
///
/// Its noise is estimated from the picture itself. A template much finer than the camera's pixels
/// is averaged down to them.
///
/// In     picture; width: of the whole template, fit frame units (about px); y_sign as above
/// Out    the model, or why this template cannot be located: too small, flat, or only parallel
///        edges
/// Source Immerkaer 1996 (noise); Lee 1980 (smoothing where nothing is)
/// See    tests/vision/template/detector_test.cc
tl::expected<TemplateModel, std::string> make_template_model(const TemplatePicture& picture,
                                                             double width,
                                                             double y_sign);

}  // namespace panelcal::internal
