// SPDX-License-Identifier: Apache-2.0
#include "tools/figures/arrow_plot.h"

#include <algorithm>
#include <cmath>

#include "tools/figures/svg.h"
#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr double kSide_px = 640;  ///< the longer one of the plotted area
constexpr double kArrowMargin_px = 60;
constexpr double kLongest_px = 48;  ///< arrow
constexpr double kArrowDot_px = 1.6;

/// From places to the sheet.
class Sheet {
 public:
  explicit Sheet(const ArrowPlot& plot)
      : plot_(plot), per_unit_(kSide_px / (plot.high - plot.low).maxCoeff()) {}

  Eigen::Vector2d area_px() const { return per_unit_ * (plot_.high - plot_.low); }
  Eigen::Vector2d at(const Eigen::Vector2d& place) const {
    Eigen::Vector2d p_px = per_unit_ * (place - plot_.low);
    if (!plot_.y_is_down) p_px.y() = area_px().y() - p_px.y();
    return p_px + Eigen::Vector2d::Constant(kArrowMargin_px);
  }
  Eigen::Vector2d along(const Eigen::Vector2d& v) const {
    return {v.x(), plot_.y_is_down ? v.y() : -v.y()};
  }

 private:
  const ArrowPlot& plot_;
  double per_unit_;
};

bool is_drawn(const ArrowPlot::Arrow& arrow) {
  return arrow.at.allFinite() && arrow.size.allFinite();
}

std::string plot_frame(const ArrowPlot& plot, const Sheet& sheet) {
  const Eigen::Vector2d area_px = sheet.area_px();
  const double bottom_px = kArrowMargin_px + area_px.y();
  const double right_px = kArrowMargin_px + area_px.x();
  const double top = plot.y_is_down ? plot.low.y() : plot.high.y();
  const double bottom = plot.y_is_down ? plot.high.y() : plot.low.y();
  return fmt::format(
      R"(<rect class="frame" x="{0:.1f}" y="{0:.1f}" width="{1:.1f}" height="{2:.1f}"/>
<text x="{0:.1f}" y="{3:.1f}">{4:g} {9}</text>
<text x="{5:.1f}" y="{3:.1f}" text-anchor="end">{6:g} {9}</text>
<text x="{10:.1f}" y="{11:.1f}" text-anchor="end">{7:g}</text>
<text x="{10:.1f}" y="{12:.1f}" text-anchor="end">{8:g}</text>
)",
      kArrowMargin_px,
      area_px.x(),
      area_px.y(),
      bottom_px + 18,
      plot.low.x(),
      right_px,
      plot.high.x(),
      top,
      bottom,
      plot.place_unit,
      kArrowMargin_px - 6,
      kArrowMargin_px + 10,
      bottom_px);
}

}  // namespace

std::string arrow_svg(const ArrowPlot& plot) {
  const Sheet sheet(plot);
  double longest = 0;
  for (const ArrowPlot::Arrow& arrow : plot.arrows) {
    if (is_drawn(arrow)) longest = std::max(longest, arrow.size.norm());
  }
  const double per_unit_px = longest > 0 ? kLongest_px / longest : 0;
  const Eigen::Vector2d size_px =
      sheet.area_px() + Eigen::Vector2d(2 * kArrowMargin_px, 2 * kArrowMargin_px + 24);
  std::string out = fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {:.0f} {:.0f}" width="{:.0f}">
<style>text{{font:13px sans-serif}}.title{{font-weight:bold}}.frame{{fill:none;stroke:#888}}.arrow{{fill:none;stroke:#1f5fa8;stroke-width:1.3}}.dot{{fill:#1f5fa8}}.reference{{fill:none;stroke:#000;stroke-width:1.5}}</style>
<rect width="100%" height="100%" fill="#fff"/>
<text class="title" x="{}" y="30">{}</text>
)",
      size_px.x(),
      size_px.y(),
      size_px.x(),
      kArrowMargin_px,
      report::escaped(plot.title));
  out += plot_frame(plot, sheet);
  for (const ArrowPlot::Arrow& arrow : plot.arrows) {
    if (!is_drawn(arrow)) continue;
    const Eigen::Vector2d from_px = sheet.at(arrow.at);
    out += fmt::format("<circle class=\"dot\" cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\"/>",
                       from_px.x(),
                       from_px.y(),
                       kArrowDot_px);
    out += fmt::format("<path class=\"arrow\" d=\"{}\"/>\n",
                       report::arrow_path(from_px, per_unit_px * sheet.along(arrow.size)));
  }
  const double y_px = kArrowMargin_px + sheet.area_px().y() + 40;
  if (longest > 0) {
    const double reference = report::nice_below(longest);
    const double length_px = reference * per_unit_px;
    out += fmt::format(
        "<path class=\"reference\" d=\"{}\"/><text x=\"{:.1f}\" y=\"{:.1f}\">{:g} {}</text>\n",
        report::arrow_path({kArrowMargin_px, y_px}, {length_px, 0}),
        kArrowMargin_px + length_px + 8,
        y_px + 4,
        reference,
        plot.arrow_unit);
  }
  return out + "</svg>\n";
}

}  // namespace panelcal
