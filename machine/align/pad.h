// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "program/model/measurement.h"

namespace panelcal {

/// A pad that an alignment looks at.
struct Pad {
  Position<frame::Nominal> nominal;
  int line = 0;      ///< of the file that states it; in a list its number
  std::string name;  ///< "FID1"; empty: none
  std::string command = "G36";
  VisionSettings settings;  ///< one vision tool or more
};

/// The pads of one panel, and the text that they come from.
struct PadList {
  std::string file;   ///< as diagnostics name it
  std::string words;  ///< for people: "4 flashes FiducialPad,Global in F_Cu.gbr"
  std::vector<Pad> pads;
};

}  // namespace panelcal
