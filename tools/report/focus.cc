// SPDX-License-Identifier: Apache-2.0
#include "tools/report/focus.h"

#include <algorithm>
#include <cstddef>

#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

constexpr double kFocusWidth_px = 420;
constexpr double kFocusHeight_px = 160;
constexpr double kFocusMargin_px = 28;
/// More curves do not help.
constexpr std::size_t kMostCurves = 50;

/// Maps heights and sharpnesses to the picture.
struct Chart {
  double low_mm = 0;
  double high_mm = 0;
  double greatest = 0;

  double x(double z_mm) const {
    const double span_mm = std::max(1e-9, high_mm - low_mm);
    return kFocusMargin_px + (kFocusWidth_px - 2 * kFocusMargin_px) * (z_mm - low_mm) / span_mm;
  }
  double y(double sharpness) const {
    const double share = greatest > 0 ? std::max(0.0, sharpness / greatest) : 0;
    return kFocusHeight_px - kFocusMargin_px - (kFocusHeight_px - 2 * kFocusMargin_px) * share;
  }
};

Chart chart_of(const FocusResult& focus) {
  const auto z_mm = [](const FocusResult::Sample& s) { return s.z.in_mm(); };
  const auto [low, high] = std::ranges::minmax_element(focus.curve, {}, z_mm);
  const auto best = std::ranges::max_element(focus.curve, {}, &FocusResult::Sample::sharpness);
  return {low->z.in_mm(), high->z.in_mm(), best->sharpness};
}

std::string curve(const FocusResult& focus) {
  const Chart chart = chart_of(focus);
  std::string out = fmt::format(
      "<svg class=\"panel\" role=\"img\" aria-label=\"sharpness over height\" viewBox=\"0 0 {0} "
      "{1}\" style=\"max-width:{0}px\"><path class=\"frame\" d=\"M{2} {2}V{3}H{4}\"/>",
      kFocusWidth_px,
      kFocusHeight_px,
      kFocusMargin_px,
      kFocusHeight_px - kFocusMargin_px,
      kFocusWidth_px - kFocusMargin_px);
  for (const FocusResult::Sample& s : focus.curve) {
    out += fmt::format("<circle class=\"after\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2\"/>",
                       chart.x(s.z.in_mm()),
                       chart.y(s.sharpness));
  }
  if (focus.is_found) {
    out += fmt::format("<path class=\"before\" d=\"M{0:.1f} {1}V{2}\"/>",
                       chart.x(focus.z.in_mm()),
                       kFocusMargin_px,
                       kFocusHeight_px - kFocusMargin_px);
  }
  for (const double z_mm : {chart.low_mm, chart.high_mm}) {
    out += fmt::format("<text class=\"mid\" x=\"{:.1f}\" y=\"{}\">{} mm</text>",
                       chart.x(z_mm),
                       kFocusHeight_px - 8,
                       fixed(z_mm, 3));
  }
  return out + "</svg>";
}

std::string caption(const FocusResult& focus) {
  std::string out = fmt::format(
      "line {}, at {} mm: ", focus.request.line, point_text(focus.request.expected.in_mm()));
  if (!focus.is_found) return out + "<b>not focused</b>, " + escaped(focus.reason);
  return out + fmt::format("sharpest at z = <b>{} mm</b>, sigma {} &#181;m",
                           fixed(focus.z.in_mm(), 4),
                           fixed(focus.sigma.in_um(), 1));
}

}  // namespace

std::string focus_section(const Survey& survey) {
  if (survey.focus.empty()) return {};
  std::string out = "<h2 id=\"focus\">Focus</h2>\n<section>\n";
  const std::size_t n = std::min(survey.focus.size(), kMostCurves);
  for (std::size_t i = 0; i < n; ++i) {
    const FocusResult& focus = survey.focus[i];
    out += "<figure>";
    if (!focus.curve.empty()) out += curve(focus);
    out += "<figcaption>" + caption(focus) + "</figcaption></figure>\n";
  }
  return out + "</section>\n";
}

}  // namespace panelcal::report
