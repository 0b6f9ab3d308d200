// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "panelcal/surface/files/probe_file.h"
#include "panelcal/surface/map_file.h"
#include "panelcal/tools/surface_facts.h"

namespace panelcal::surface {

/// A map that was just made, and what about its probes the map itself does not keep.
struct MadeMap {
  StoredMap stored;
  MapFacts facts;
  std::vector<MissingProbe> missing;  ///< places that were to be probed and have no height
  std::string file;                   ///< of the map
};

/// "2.7 um"
std::string um_text(Length value);
/// "(15.000, 89.026)"
std::string place_text(const Position<frame::Nominal>& place);
/// `probes.jsonl:13: column 5 row 1 is 0.503 mm above ..., 122 sigma; chance below 1e-9`
std::string left_out_text(const StoredMap& stored, const SurfaceOutlier& outlier);
/// Filled areas in one sentence.
std::string coverage_text(const MapFacts& facts);

/// What `panelcal surface fit` prints: a line for each thing that an operator asks.
std::string made_text(const MadeMap& made);
/// The same as one JSON object, docs/formats/surface.md.
std::string made_json(const MadeMap& made);

}  // namespace panelcal::surface
