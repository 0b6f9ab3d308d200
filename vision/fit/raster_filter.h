// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/fit/spline_image.h"

// Not installed.
namespace panelcal::internal {

/// The convolution with a Gaussian, mirrored at the border; sigma 0 changes nothing.
Raster blurred(const Raster& in, double sigma_px);

/// Averages factor x factor pixels; what is left over at the right and bottom is dropped.
Raster averaged(const Raster& in, int factor);

/// The sum of the second differences in x and y; the border is continued.
Raster laplacian(const Raster& in);

}  // namespace panelcal::internal
