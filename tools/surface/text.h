// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "surface/files/probe_file.h"
#include "surface/map/file.h"
#include "tools/surface/facts.h"

namespace panelcal::surface {

/// The map of a zone, or of all without zones, and what an operator asks of it.
struct MadeZone {
  std::string name;  ///< empty without zones
  StoredMap stored;
  MapFacts facts;
};

/// A file of probes that was read.
struct ProbeSource {
  std::string file;
  ProbeFormat format = ProbeFormat::RecordedProbes;
  std::string unit, zero;  ///< as ProbeFile
  std::size_t n_probes = 0;
  std::size_t n_missing = 0;
};

/// A map that was just made, and what about its probes the map itself does not keep.
struct MadeMap {
  StoredZones stored;
  std::vector<MadeZone> zones;        ///< one without zones
  std::vector<MissingProbe> missing;  ///< places that were to be probed and have no height
  std::string file;                   ///< of the map
  std::vector<ProbeSource> sources;   ///< in the order that they were read in

  bool has_zones() const { return !stored.map.zones().empty(); }
};

MadeMap made_map(StoredZones stored,
                 std::vector<MissingProbe> missing,
                 std::string file,
                 std::vector<ProbeSource> sources);

/// "2.7 um"
std::string um_text(Length value);
/// "(15.000, 89.026)"
std::string place_text(const Position<frame::Nominal>& place);
/// `probes.jsonl:13: column 5 row 1 is 0.503 mm above ..., 122 sigma; chance below 1e-9`
std::string left_out_text(const StoredMap& stored, const SurfaceOutlier& outlier);
/// `probes.jsonl:13: column 5 row 1 at (50.000, 10.000): it lies in "clamp" (zones.toml:9)`
std::string unused_text(const StoredZones& stored, const UnusedProbe& unused);
/// `24: 20 round, 3 routed, 1 other; no probe counts within 0.5 mm of one`
std::string voids_text(const Voids& voids);
/// Filled areas in one sentence.
std::string coverage_text(const MapFacts& facts);

/// The output of `panelcal surface fit`: a line for each figure.
std::string made_text(const MadeMap& made);

}  // namespace panelcal::surface
