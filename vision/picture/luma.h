// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panelcal::internal {

/// 0.299 R + 0.587 G + 0.114 B (ITU-R BT.601), arranged so that white stays exactly white: then
/// saturation is recognised.
inline float luma(float blue, float green, float red) {
  return green + 0.299F * (red - green) + 0.114F * (blue - green);
}

}  // namespace panelcal::internal
