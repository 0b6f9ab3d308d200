// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// Texture of a board, as a random field of autocovariance
///
///   sigma^2 / 2 (d / range)^2 K_2(d / range),   d the distance
///
/// (Matern, smoothness 2), on top of white noise.
struct Texture {
  double sigma = 0;  ///< grey levels
  double range_px = 1;
  double white_sigma = 1;  ///< grey levels
};

/// A flat piece of picture: residuals by rows, 0 where there is none.
struct FlatResiduals {
  std::span<const float> values;
  int width = 0;
  double n = 0;  ///< number of residuals
};

/// Fits a texture's model to the autocovariance at lags of 0 to 20 px along rows and columns; empty
/// if that has no texture.
std::optional<Texture> texture_of(const FlatResiduals& residuals);

/// A pixel of a linearised fit.
struct TexturedPixel {
  float x = 0;  ///< px, anywhere
  float y = 0;
  float background = 0;  ///< share of what is textured in the pixel, 0 to 1
  float residual = 0;    ///< seen minus model, grey levels
};

/// The result of one step.
struct GeneralizedStep {
  Eigen::VectorXd step;        ///< to add to the parameters
  Eigen::MatrixXd covariance;  ///< of the parameters after it
  double chi_square = 1;       ///< of the whitened residuals, per pixel
};

/// One step of generalised least squares on textured ground:
///
///   residual(u) = J(u) step + background(u) texture(u) + white noise
///
/// The texture is a cubic spline on a lattice that follows its range, with the prior that its
/// autocovariance gives, and is integrated out; that is the best linear estimate whose weights know
/// that neighbouring pixels err together. Cost grows with the pixels times 16^2 and with the
/// lattice.
///
/// In     pixels and jacobian: equally many rows; information, gradient: J^T W J and
///        J^T W residual of pixels that are not in the list since they see no texture (W = 1 /
///        white variance)
/// Out    empty if the equations are singular
/// Cost   about 3 ms for a rim of 40 px radius
/// Source Lindgren, Rue and Lindstroem 2011 (Gaussian field as a sparse precision); Rasmussen and
///        Williams 2006, 2.7 (basis functions with priors integrated out)
/// See    tests/vision/texture/fit_test.cc
std::optional<GeneralizedStep> generalized_step(std::span<const TexturedPixel> pixels,
                                                const Eigen::MatrixXf& jacobian,
                                                const Texture& texture,
                                                const Eigen::MatrixXd& information,
                                                const Eigen::VectorXd& gradient);

}  // namespace panelcal::internal
