// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace panelcal {

/// A picture of the camera, as JPEG.
struct Frame {
  std::uint64_t number = 0;  ///< grows with each picture
  std::string jpeg;
};

/// The document "screen" (share/schema/screen.schema.json) as text, one line.
struct ShownState {
  std::uint64_t number = 0;  ///< grows with each change
  std::string json;
};

}  // namespace panelcal
