// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "program/walk/reading_terms.h"
#include "tools/cli/options/facts_files.h"

namespace panelcal {

/// The commands of `panelcal surface`.
struct SurfaceOptions {
  std::vector<std::string> files;  ///< fit: of probes; diff: two maps
  std::string map;      ///< query, apply, export; plan: whose shape is believed, may be empty
  std::string machine;  ///< machine.toml; may be empty but with programs
  std::string program;  ///< query, plan: whose places are asked for; may be empty
  std::string output;   ///< fit: the map; plan: the list of places; may be empty; export
  std::string gcode;    ///< apply: the program, and `output` what becomes of it
  FactsFiles facts;
  std::string clock;  ///< as CheckOptions
  std::int64_t max_operations = kUsualMaxOperations;
  ReadingTerms reading;  ///< of `program` and `voids_of`
  // fit
  std::string model = "auto";      ///< or a word of surface_model_words()
  std::string format;              ///< of probes, export too; empty: by the file
  std::optional<double> sigma_um;  ///< empty: as the files say, or 5
  std::string unit;                ///< mm or inch; empty: as the files say, or mm
  std::string profile;             ///< of a Klipper file that has several meshes
  std::vector<double> mesh_mm;     ///< x0, y0, x1, y1 of a Marlin mesh; empty: as its console says
  std::optional<int> z_axis;       ///< of probes with several
  std::optional<double> max_extrapolation_mm;  ///< empty: [surface] grid_hold_mm, or 5
  std::string zones;                           ///< zones.toml; may be empty
  std::vector<std::string> voids_of;           ///< programs whose holes and routs are voids
  std::optional<double> probe_tip_mm;          ///< diameter; empty: as the zones say, or 1
  // query
  std::vector<std::string> places;  ///< "X,Y", or "-" for standard input
  std::string grid;                 ///< export, too: "NXxNY"; empty: none
  // diff, plan
  std::string zone;  ///< of a map of zones; empty: there is only one
  // plan
  std::optional<double> tolerance_um;  ///< of the map's sigma
  std::vector<double> area_mm;         ///< x0, y0, x1, y1; empty: what is asked for
  std::optional<double> amplitude_mm;  ///< these three: of the bending, instead of a map's
  std::optional<double> length_mm;
  std::optional<double> probe_sigma_um;
  bool afresh = false;  ///< another panel of the map's kind: its probes do not count
  // apply
  double height_tolerance_um = 10;
  std::optional<double> safe_mm;       ///< empty: as the program travels
  std::vector<double> zero_mm;         ///< export, too: where Z is 0; empty: the map's own 0
  std::string gcode_unit;              ///< of a program that does not say: mm or inch
  std::optional<double> max_sigma_um;  ///< of the surface under levelled moves
  // export
  bool fill = false;  ///< nodes that no probe vouches for
};

}  // namespace panelcal
