// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace panelcal {

struct SeenView;

/// Sees every picture that is looked at, for reports and overlays.
using PictureObserver = std::function<void(const SeenView&)>;

}  // namespace panelcal
