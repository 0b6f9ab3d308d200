// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "vision/round/model/model.h"
#include "vision/round/model/window.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// Sigma of a pixel's noise in each zone, grey levels.
struct RimNoise {
  std::array<double, kRimZones> sigma = {1, 1, 1};

  double operator[](RimZone zone) const { return sigma[static_cast<std::size_t>(zone)]; }
};

struct RimFitOptions {
  RimFreedom freedom;
  RimNoise noise;
  double tolerance_px = 0.012;  ///< stop at smaller steps; the next would be about its square
};

/// End of a fit.
struct RimSolution {
  RimVector parameters = RimVector::Zero();
  RimFreedom freedom;
  Eigen::MatrixXd information;  ///< J^T W J of the free parameters, in their order
  int n_evaluations = 0;
  bool converged = false;
};

/// Maximises the likelihood of the window's pixels by Levenberg-Marquardt with analytic gradients.
///
/// A clipped pixel says that the level is at least (at most) the scale's end, no more and no less:
/// its likelihood is that of the noise beyond.
///
/// In     window: collected about `start`, with the band pixels' weights set
/// Cost   about 10 ns a band pixel and evaluation; good starts take one or two
/// Source Nocedal and Wright 2006, 10.3; Tobin 1958 (clipped observations); Huber 1964
RimSolution fit_rim(const RimWindow& window, const RimVector& start, const RimFitOptions& options);

/// The largest blur a fit allows for: a blurrier rim is no rim, and the fit stays at this limit.
double max_edge_sigma(double radius);

/// Sets the band pixels' weights for noise that differs on the target and around it.
void set_weights(RimWindow& window, const RimVector& parameters, const RimNoise& noise);

}  // namespace panelcal::internal
