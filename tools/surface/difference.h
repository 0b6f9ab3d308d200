// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/json/facts.h"
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
/// The figures of it, docs/formats/surface.md.
facts::Json difference_figures(const ComparedMaps& maps);
/// The document of them, with the difference over what both maps probed.
facts::Json difference_facts(const ComparedMaps& maps, const Provenance& provenance);

}  // namespace panelcal::surface
