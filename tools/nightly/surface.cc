// SPDX-License-Identifier: Apache-2.0
#include "tools/nightly/surface.h"

#include "tools/surface/picture.h"

namespace panelcal::nightly {

std::string surface_figures(const NightStep& step) {
  if (!step.surface) return {};
  std::string out = "<h3>The surface tonight</h3>\n<div class=\"charts\">\n";
  const StoredMap& probed = *step.surface;
  const surface::MadeMap made = surface::made_map(
      {probed.points, ZonedMap(probed.map), probed.sources, probed.made_by}, {}, {});
  for (const report::Drawing& drawing : surface::zone_drawings(made, 0)) {
    out += "<figure>\n" + contours::inline_svg(drawing, "Contours over the table") + "</figure>\n";
  }
  return out +
         "</div>\n<p class=\"quiet\">Dots: probes; red crosses: probes left out, with how far they "
         "are off in mm; hatched: extrapolated, or filled where a probe is missing.</p>\n";
}

}  // namespace panelcal::nightly
