// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "surface/map/difference.h"
#include "tools/cli/provenance.h"

namespace panelcal::surface {

/// Two maps and what changed from one to the other.
struct ComparedMaps {
  std::string before_file, after_file;
  StoredMap before, after;
  MapDifference difference;
};

/// Smaller chances than this say that the panel changed.
inline constexpr double kSignificant = 0.01;

std::string difference_text(const ComparedMaps& maps);
/// One JSON object, docs/formats/surface.md.
std::string difference_json(const ComparedMaps& maps);
/// Contours of the difference over what both maps probed.
std::string difference_svg(const ComparedMaps& maps, const Provenance& provenance);

}  // namespace panelcal::surface
