// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace panelcal {

/// Answers of `panelcal init`. An empty one is asked for at a terminal, or assumed.
struct InitOptions {
  std::string kind;  ///< empty: asked for
  std::string output = "machine.toml";
  std::string name;
  std::string camera;  ///< address
  std::string device;
  std::string host;
  std::string calibration;          ///< a camera calibration that exists
  std::optional<double> um_per_px;  ///< of the one that is assumed
  std::vector<int> picture_px;      ///< width and height
  std::vector<double> fiducials_mm;
  std::vector<double> travel_mm;  ///< left, lower, right, upper edge
  std::vector<double> camera_offset_mm;
  std::optional<double> camera_offset_sigma_um;
  std::optional<double> safe_z_mm;
};

}  // namespace panelcal
