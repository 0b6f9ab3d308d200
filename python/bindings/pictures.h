// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "calib/camera/mapping.h"
#include "python/bindings/convert.h"
#include "vision/picture/image.h"

namespace panelcal::python {

/// A picture of an array's pixels: one copy, made without the GIL.
///
/// Fails  raises usage (shape, type, a pixel outside of the range)
Image image_of(const py::array& pixels, std::optional<double> full_scale);

}  // namespace panelcal::python
