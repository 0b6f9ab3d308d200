// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

namespace panelcal {

/// Covariance function of the bending at two places.
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

}  // namespace panelcal
