// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "tests/bench/locate/scene.h"
#include "tests/bench/locate/texture.h"

namespace panelcal::bench {

/// The picture around a mark as a function of all that is unknown, linearised at the truth.
///
/// Columns of `jacobian`: centre x, centre y, then the nuisance parameters: size, level of the
/// mark, level of the background, light gradient x and y, blur; for rings also the inner size, for
/// squares and crosses the angle, for crosses the bars' width. Grey levels of 255 per px (or unit).
struct LinearModel {
  int side_px = 0;  ///< of the square window, mark in the middle
  Eigen::VectorXd value;
  Eigen::MatrixXd jacobian;
  /// Share of the background, which carries the weave, that a pixel sees.
  Eigen::VectorXd background_share;
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(side_px) +
           static_cast<std::size_t>(x);
  }
};

/// Half the window's side beyond the mark's radius: generous, so that the gradient is well known.
inline constexpr int kWindowMarginPx = 40;

/// Numeric derivatives of renderings without noise.
///
/// In     offset_px: the mark's centre from the window's middle pixel; margin_px: of the window
///        about the mark's radius
LinearModel linearise(const Condition& condition,
                      const Mark& mark,
                      const Eigen::Vector2d& offset_px = Eigen::Vector2d::Zero(),
                      int margin_px = kWindowMarginPx);

/// Cramer-Rao bound of the centre's coordinates, everything else unknown: 2 x 2, px^2.
///
/// In     visible: 1 where a pixel counts, else 0; empty: all count
Eigen::Matrix2d white_bound(const LinearModel& model,
                            double noise,
                            const Eigen::VectorXd& visible = {});

/// The same for noise that is white plus texture on the background: F = J' C^-1 J,
/// C = noise^2 I + D T D with D the background's share and T the texture's covariance.
Eigen::Matrix2d coloured_bound(const LinearModel& model, double noise, const Texture& texture);

/// C^-1 J of the coloured model: also what the best linear estimate needs.
Eigen::MatrixXd solve_coloured(const LinearModel& model, double noise, const Texture& texture);

/// n / C sqrt(2 s / (sqrt(pi) r)) with s the blur of lens and pixel.
double closed_form_bound(const Condition& condition, double radius_px);

/// 1 for the pixels around a sample's mark that nothing else than mark and background touches, in
/// the window of LinearModel about the pixel nearest to the mark's centre.
Eigen::VectorXd visible_pixels(const Sample& sample);

}  // namespace panelcal::bench
