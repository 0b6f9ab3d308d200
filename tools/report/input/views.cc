// SPDX-License-Identifier: Apache-2.0
#include "tools/report/input/views.h"

#include <algorithm>

#include "tools/figures/svg.h"
#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

constexpr double kViewWidth_px = 300;
constexpr double kMaxHeight_px = 260;
/// More crops than a four-view target with a few doubtful places would only fill the page.
constexpr std::size_t kMaxCrops = 8;

std::string_view arrow_class(MeasurementStatus status) {
  if (status == MeasurementStatus::Found) return "after";
  return status == MeasurementStatus::NotFound ? "frame" : "arrow refused";
}

std::string view_cross(const Eigen::Vector2d& at, double arm, std::string_view css_class) {
  return fmt::format("<path class=\"{}\" d=\"M{:.1f} {:.1f}h{:.1f}M{:.1f} {:.1f}v{:.1f}\"/>",
                     css_class,
                     at.x() - arm,
                     at.y(),
                     2 * arm,
                     at.x(),
                     at.y() - arm,
                     2 * arm);
}

std::string view_frame(const View& view, const ReportView& seen) {
  std::string path;
  for (const Eigen::Vector2d& corner_mm : seen.frame_mm) {
    const Eigen::Vector2d at = view.at(corner_mm);
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", at.x(), at.y());
  }
  std::string out = fmt::format("<path class=\"{}\" d=\"{}Z\"/>", arrow_class(seen.status), path);
  const Eigen::Vector2d corner = view.at(seen.frame_mm.front());
  out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>",
                     corner.x() + 3,
                     corner.y() + 12,
                     seen.i_view + 1);
  for (const Eigen::Vector2d& place_mm : seen.seen_mm) {
    const bool is_found = seen.status == MeasurementStatus::Found;
    out += view_cross(view.at(place_mm), 6, is_found ? "after" : "arrow refused");
  }
  return out;
}

/// The last picture of each view: of several inspections one is enough.
std::vector<const ReportView*> distinct(std::span<const ReportView> views) {
  std::vector<const ReportView*> out;
  for (const ReportView& view : views) {
    if (view.frame_mm.size() < 3) continue;
    if (!out.empty() && out.back()->i_view == view.i_view) out.pop_back();
    out.push_back(&view);
  }
  return out;
}

}  // namespace

std::string views_figure(const Measurement& measurement, std::span<const ReportView> views) {
  const std::vector<const ReportView*> shown = distinct(views);
  if (shown.size() < 2) return {};
  const MeasurementRequest& request = measurement.request;
  const Eigen::Vector2d& expected_mm = request.expected.in_mm();
  Extent extent;
  for (const ReportView* view : shown) {
    for (const Eigen::Vector2d& corner_mm : view->frame_mm) extent.add(corner_mm);
  }
  extent.add(expected_mm);
  const View plan(extent, kViewWidth_px, kMaxHeight_px);
  std::string out = "<figure>" + plan.open("panel", "the views of this target") + plan.axes();
  for (const ReportView* view : shown) out += view_frame(plan, *view);
  if (request.settings.search_area && !request.settings.delta) {
    const Eigen::Vector2d at = plan.at(expected_mm);
    out += fmt::format("<circle class=\"before\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>",
                       at.x(),
                       at.y(),
                       request.settings.search_area->in_mm() * plan.px_per_mm());
  }
  out += view_cross(plan.at(expected_mm), 4, "before");
  if (measurement.status == MeasurementStatus::Found) {
    out += view_cross(plan.at(measurement.measured.position.in_mm()), 9, "after");
  }
  out += fmt::format(
      "</svg><figcaption>{} views, in mm from work zero; dashed: where the target "
      "was expected</figcaption></figure>\n",
      shown.size());
  std::size_t n_crops = 0;
  for (const ReportView* view : shown) {
    if (view->crop_png.empty() || n_crops == kMaxCrops) continue;
    ++n_crops;
    out += fmt::format(
        "<img tabindex=\"0\" alt=\"view {0}\" title=\"view {0}\" "
        "src=\"data:image/png;base64,{1}\"/>",
        view->i_view + 1,
        base64(view->crop_png));
  }
  return out + (n_crops > 0 ? "\n" : "");
}

}  // namespace panelcal::report
