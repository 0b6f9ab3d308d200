// SPDX-License-Identifier: Apache-2.0
#include "tools/history/diff_picture.h"

#include <algorithm>
#include <string_view>

#include "calib/base/append_format.h"
#include "tools/figures/svg.h"
#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::history {
namespace {

using report::ArrowScale;
using report::escaped;
using report::Extent;
using report::fixed;
using report::fixed_signed;
using report::shortest;
using report::View;

constexpr double kDiffWidth = 900;
constexpr double kMaxDiffHeight = 760;
constexpr double kHead = 74;  ///< height of the lines above the map
constexpr double kFoot = 12;
constexpr double kDiffMargin = 16;
constexpr double kLeastWidth = 880;  ///< that the lines above need
/// The longest arrow, as a part of the map's shorter side.
constexpr double kLongest = 0.09;

constexpr std::string_view kShiftStyle = R"css(
.shift{font:12px system-ui,"DejaVu Sans",sans-serif}
.shift text{fill:#4a5560}.shift .title{fill:#111;font-size:18px}.shift .fact{fill:#111;font-size:13px}
.shift .mid{text-anchor:middle}.shift .end{text-anchor:end}
.shift path,.shift rect,.shift circle{fill:none;stroke-linecap:round;stroke-linejoin:round}
.shift .paper{fill:#fff}.shift .grid{stroke:#dde2e7;stroke-width:.6}
.shift .frame{stroke:#7b8794;stroke-width:.8}.shift .bar{stroke:#111;stroke-width:1.3}
.shift .hull{stroke:#7b8794;stroke-dasharray:5 4}.shift .place{fill:#9aa5b1}
.shift .arrow{stroke:#0a5ea8;stroke-width:1.5}.shift .worst{stroke:#b3261e;stroke-width:2.2}
.shift .target{stroke:#8a5a00;stroke-width:1.4}
)css";

std::string shift_circle(const Eigen::Vector2d& at, double radius, std::string_view css_class) {
  return fmt::format("<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"/>",
                     css_class,
                     at.x(),
                     at.y(),
                     radius);
}

std::string outline(const View& view, const std::vector<Position<frame::Nominal>>& corners) {
  if (corners.size() < 2) return {};
  std::string data;
  for (const Position<frame::Nominal>& corner : corners) {
    const Eigen::Vector2d at = view.at(corner.in_mm());
    internal::append_format(data, "{}{:.1f} {:.1f}", data.empty() ? "M" : "L", at.x(), at.y());
  }
  return fmt::format("<path class=\"hull\" d=\"{}Z\"/>\n", data);
}

std::string targets(const View& view, const std::vector<Position<frame::Nominal>>& places) {
  std::string data;
  for (const Position<frame::Nominal>& place : places) {
    const Eigen::Vector2d at = view.at(place.in_mm());
    internal::append_format(data, "M{:.1f} {:.1f}h12m-6 -6v12", at.x() - 6, at.y());
  }
  return data.empty() ? data : fmt::format("<path class=\"target\" d=\"{}\"/>\n", data);
}

std::string arrow(const View& view,
                  const MovedPlace& moved,
                  const ArrowScale& scale,
                  std::string_view css_class) {
  const std::string path = report::arrow_path(
      view.at(moved.place.nominal.in_mm()), scale.magnification * view.along(moved.shift.in_mm()));
  return path.empty() ? path : fmt::format("<path class=\"{}\" d=\"{}\"/>\n", css_class, path);
}

std::string shift_figures_text(const JobShift& shift) {
  const HoleShiftSummary& s = shift.summary;
  if (s.max.in_um() == 0) return "no place moves";
  return fmt::format("max {} um, 95 % within {} um, rms {} um, mean shift ({}, {}) um",
                     fixed(s.max.in_um(), 2),
                     fixed(s.p95.in_um(), 2),
                     fixed(s.rms.in_um(), 2),
                     fixed_signed(s.mean_shift.in_mm().x() * 1e3, 2),
                     fixed_signed(s.mean_shift.in_mm().y() * 1e3, 2));
}

/// Everything inside of the axes.
std::string map(const View& view, const JobShift& shift, const ArrowScale& scale) {
  std::string out = outline(view, shift.hull) + "<g>";
  for (const MovedPlace& moved : shift.sample) {
    out += shift_circle(view.at(moved.place.nominal.in_mm()), 1.6, "place");
  }
  out += "</g>\n" + targets(view, shift.targets);
  for (const MovedPlace& moved : shift.sample) out += arrow(view, moved, scale, "arrow");
  if (!shift.is_uniform()) out += arrow(view, shift.worst, scale, "arrow worst");
  return out;
}

std::string head(const JobShift& shift, const JobShiftFacts& facts, const ArrowScale& scale) {
  std::string third =
      fmt::format("{} of {} places shown", shift.sample.size(), shift.summary.n_holes);
  if (shift.summary.max.in_um() > 0) {
    third += fmt::format("; arrows {} times longer than true", shortest(scale.magnification));
  }
  third += "; dashes: the outline of all; crosses: targets";
  if (!shift.is_uniform()) third += "; red: the largest shift";
  return fmt::format(
      "<text class=\"title\" x=\"{0}\" y=\"26\">{1}</text>\n"
      "<text class=\"fact\" x=\"{0}\" y=\"47\">{2}</text>\n"
      "<text x=\"{0}\" y=\"65\">{3}</text>\n",
      kDiffMargin,
      escaped(facts.program_file + ": " + facts.what),
      escaped(shift_figures_text(shift)),
      escaped(third));
}

}  // namespace

std::string job_shift_svg(const JobShift& shift, const JobShiftFacts& facts) {
  Extent extent;
  for (const auto& corner : shift.hull) extent.add(corner.in_mm());
  for (const auto& target : shift.targets) extent.add(target.in_mm());
  const View view(extent, kDiffWidth, kMaxDiffHeight);
  const ArrowScale scale =
      report::arrow_scale(shift.summary.max.in_mm(), kLongest * view.plot_side(), view.px_per_mm());
  std::string content = view.axes() + map(view, shift, scale) + view.scale_bar();
  if (shift.summary.max.in_um() > 0) {
    content += view.reference_arrow(
        scale.reference_um * scale.px_per_um, "", shortest(scale.reference_um) + " &#181;m");
  }
  std::string description;
  for (const auto& [key, value] : facts.provenance) {
    description += escaped(key + ": " + value) + "\n";
  }
  const double width = std::max(view.width() + 2 * kDiffMargin, kLeastWidth);
  const double height = view.height() + kHead + kFoot;
  return fmt::format(
      "<svg class=\"shift\" xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\">\n"
      "<title>{2}</title>\n<desc>{3}</desc>\n<style>{4}</style>\n"
      "<rect class=\"paper\" width=\"100%\" height=\"100%\"/>\n{5}"
      "<g transform=\"translate({6} {7})\">\n{8}</g>\n</svg>\n",
      width,
      height,
      escaped(facts.what),
      description,
      kShiftStyle,
      head(shift, facts, scale),
      kDiffMargin,
      kHead,
      content);
}

}  // namespace panelcal::history
