// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Core>

namespace panelcal {

/// How alike the bendings of two places are.
enum class BendingKernel : std::uint8_t {
  None,       ///< nothing bends
  ThinPlate,  ///< r^2 log r, a covariance up to affine maps
  Matern32,   ///< slopes are continuous
  Matern52,   ///< curvatures are continuous
  Gaussian,   ///< endlessly smooth
  Matern12,   ///< heights are continuous, slopes jump: steps and rough boards
};

/// The covariance for strength 1 at a distance in units of the length.
///
/// Source Rasmussen and Williams 2006, 4.2.1; Duchon 1977
inline double bending_covariance(BendingKernel kernel, double r) {
  switch (kernel) {
    case BendingKernel::None:
      return 0;
    case BendingKernel::ThinPlate:
      return r > 0 ? r * r * std::log(r) : 0;
    case BendingKernel::Matern32: {
      const double a = std::sqrt(3.0) * r;
      return (1 + a) * std::exp(-a);
    }
    case BendingKernel::Matern52: {
      const double a = std::sqrt(5.0) * r;
      return (1 + a + a * a / 3) * std::exp(-a);
    }
    case BendingKernel::Gaussian:
      return std::exp(-0.5 * r * r);
    case BendingKernel::Matern12:
      return std::exp(-r);
  }
  return 0;
}

/// The same of many distances, several times as fast.
inline Eigen::MatrixXd bending_covariance(BendingKernel kernel, const Eigen::ArrayXXd& r) {
  switch (kernel) {
    case BendingKernel::None:
      return Eigen::MatrixXd::Zero(r.rows(), r.cols());
    case BendingKernel::ThinPlate:
      return (r > 0).select(r * r * r.max(1e-300).log(), Eigen::ArrayXXd::Zero(r.rows(), r.cols()));
    case BendingKernel::Matern32: {
      const Eigen::ArrayXXd a = std::sqrt(3.0) * r;
      return (1 + a) * (-a).exp();
    }
    case BendingKernel::Matern52: {
      const Eigen::ArrayXXd a = std::sqrt(5.0) * r;
      return (1 + a + a * a / 3) * (-a).exp();
    }
    case BendingKernel::Gaussian:
      return (-0.5 * r * r).exp();
    case BendingKernel::Matern12:
      return (-r).exp();
  }
  return {};
}

}  // namespace panelcal
