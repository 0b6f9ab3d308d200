// SPDX-License-Identifier: Apache-2.0
#include "tools/figures/contour_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "calib/base/append_format.h"
#include "program/writers/svg/sheet.h"
#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::contours {
namespace {

using Eigen::Vector2d;
using report::Drawing;
using report::View;
using svg::Color;

constexpr double kContourWidth = 560;
constexpr double kMaxContourHeight = 640;
constexpr double kContourTitle = 30;  ///< height of the line above the map
constexpr double kStrip = 52;         ///< height of the colours below it
constexpr double kContourGap = 16;
/// Between labels, and the shortest line that has one.
constexpr double kLabelRoom = 46;
constexpr double kLetter = 7;  ///< of the strip, px
constexpr double kMarkRoom = 19;
constexpr double kShortest = 60;
constexpr int kArcSteps = 8;  ///< of a round corner's quarter

constexpr std::array<Color, 5> kHeights = {
    {{66, 120, 168}, {158, 202, 222}, {240, 241, 222}, {235, 200, 140}, {190, 112, 66}}};
constexpr std::array<Color, 4> kSigmas = {
    {{236, 245, 238}, {250, 228, 168}, {236, 158, 94}, {174, 58, 52}}};
constexpr std::array<Color, 5> kDifferences = {
    {{58, 106, 170}, {160, 198, 226}, {247, 247, 244}, {242, 182, 156}, {178, 56, 48}}};

/// A colour of a scale, t from 0 to 1.
Color between(std::span<const Color> scale, double t) {
  const double at = std::clamp(t, 0.0, 1.0) * static_cast<double>(scale.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), scale.size() - 2);
  const double part = at - static_cast<double>(i);
  const auto mixed = [&](int a, int b) {
    return static_cast<int>(std::lround(a + part * (b - a)));
  };
  return {mixed(scale[i].red, scale[i + 1].red),
          mixed(scale[i].green, scale[i + 1].green),
          mixed(scale[i].blue, scale[i + 1].blue)};
}

/// One more than levels.
std::vector<std::string> colors_of(const ContourMap& map) {
  std::vector<std::string> out;
  const std::size_t n = map.levels.size();
  for (std::size_t k = 0; k <= n; ++k) {
    double t = n == 0 ? 0.5 : static_cast<double>(k) / static_cast<double>(n);
    if (map.palette == Palette::Differences && n > 0) {
      // The middle of the band by the greatest level, so that white is zero.
      const double low = k == 0 ? map.levels.front() : map.levels[k - 1];
      const double high = k == n ? map.levels.back() : map.levels[k];
      const double most = std::max(std::abs(map.levels.front()), std::abs(map.levels.back()));
      t = most > 0 ? 0.5 + (low + high) / (4 * most) : 0.5;
    }
    const std::span<const Color> scale = map.palette == Palette::Heights ? std::span(kHeights)
                                         : map.palette == Palette::Sigmas
                                             ? std::span<const Color>(kSigmas)
                                             : std::span(kDifferences);
    out.push_back(between(scale, t).hex());
  }
  return out;
}

std::string path_of(const View& view, const Line& line) {
  std::string out;
  for (const Vector2d& p : line.points) {
    const Vector2d at = view.at(p);
    internal::append_format(out, "{}{:.1f} {:.1f}", out.empty() ? "M" : "L", at.x(), at.y());
  }
  return out + (line.is_closed ? "Z" : "");
}

/// True if a place is within a convex outline, counter-clockwise.
bool is_within(const std::vector<Vector2d>& outline, const Vector2d& p) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d side = outline[(i + 1) % outline.size()] - outline[i], to = p - outline[i];
    if (side.x() * to.y() - side.y() * to.x() < 0) return false;
  }
  return true;
}

/// A figure on each line that is long enough, where no other one is near.
std::string labels_of(const ContourMap& map, const View& view) {
  std::vector<Vector2d> taken, marks;
  for (const Vector2d& place : map.marked) marks.push_back(view.at(place));
  const auto is_free = [](const std::vector<Vector2d>& others, const Vector2d& at, double room) {
    return std::ranges::all_of(others,
                               [&](const Vector2d& other) { return (other - at).norm() > room; });
  };
  std::string out;
  const int n_decimals = decimals_of(map.levels);
  for (const double level : map.levels) {
    for (const Line& line : level_lines(map.field, level)) {
      if (line.length() * view.px_per_mm() < kShortest) continue;
      const std::size_t n = line.points.size();
      // From the middle of the line to its ends.
      for (std::size_t k = 0; k < n; ++k) {
        const std::size_t i = (n / 2 + (k % 2 == 0 ? k / 2 : n - k / 2 - 1)) % n;
        const Vector2d at = view.at(line.points[i]);
        const bool has_room = is_free(taken, at, kLabelRoom) && is_free(marks, at, kMarkRoom);
        if (!has_room || !is_within(map.outline, line.points[i])) continue;
        if (map.is_covered && map.is_covered(line.points[i])) continue;
        out += fmt::format("<text class=\"figure\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>",
                           at.x(),
                           at.y() + 4,
                           report::fixed(level, n_decimals));
        taken.push_back(at);
        break;
      }
    }
  }
  return out + "\n";
}

/// The colours in a row, with the levels between them.
std::string strip(const ContourMap& map, const std::vector<std::string>& colors, double width) {
  const int n_decimals = decimals_of(map.levels);
  const double step = std::min(46.0, (width - 110) / static_cast<double>(colors.size()));
  std::size_t n_letters = 0;
  for (const double level : map.levels) {
    n_letters = std::max(n_letters, report::fixed(level, n_decimals).size());
  }
  const double room = kLetter * static_cast<double>(n_letters) + 8;
  const auto every = static_cast<std::size_t>(std::ceil(room / step));
  std::string out;
  for (std::size_t k = 0; k < colors.size(); ++k) {
    const double x = 46 + step * static_cast<double>(k);
    out +=
        fmt::format("<rect x=\"{:.1f}\" y=\"6\" width=\"{:.1f}\" height=\"12\" style=\"fill:{}\"/>",
                    x,
                    step,
                    colors[k]);
    // Of narrow bands only some have room for their level.
    if (k == map.levels.size() || k % every != 0) continue;
    out += fmt::format("<text class=\"mid\" x=\"{:.1f}\" y=\"34\">{}</text>",
                       x + step,
                       report::fixed(map.levels[k], n_decimals));
  }
  return out + fmt::format("<text x=\"{:.1f}\" y=\"17\">{}</text>\n",
                           46 + step * static_cast<double>(colors.size()) + 8,
                           report::escaped(map.unit));
}

}  // namespace

const std::string_view kContourStyle = R"css(
.contour .paper{fill:#fff}
.contour text{font:12px system-ui,"DejaVu Sans",sans-serif;fill:#5b6774}
.contour .mid{text-anchor:middle}.contour .end{text-anchor:end}
.contour text.title{font-size:14px;font-weight:600;fill:#1b2530}
.contour path,.contour circle{fill:none;stroke-linecap:round;stroke-linejoin:round}
.contour .grid{stroke:#1b2530;stroke-opacity:.1;stroke-width:.6}
.contour rect.frame{fill:none;stroke:#5b6774;stroke-width:.8}.contour .bar{stroke:#1b2530;stroke-width:1.3}
.contour path.band{fill-rule:evenodd}
.contour path.level{stroke:#1b2530;stroke-width:.7;stroke-opacity:.55}
.contour text.figure{font-size:10.5px;text-anchor:middle;fill:#1b2530;stroke:#fff;stroke-opacity:.8;stroke-width:2.5px;paint-order:stroke}
.contour .hull{stroke:#1b2530;stroke-width:1.2;stroke-dasharray:5 4}
.contour .hatch{stroke:#1b2530;stroke-width:1;stroke-opacity:.45}
.contour .dense{stroke:#7a1f6e;stroke-width:1.3;stroke-opacity:.7}
.contour circle.probe{fill:#1b2530;stroke:#fff;stroke-width:1}
.contour circle.old{fill:#8b96a2;stroke:#fff;stroke-width:1}
.contour .wrong{stroke:#b3261e;stroke-width:2.2}
.contour path.blank{fill:#fff;fill-rule:evenodd}.contour path.gap{stroke:#fff}
.contour path.edge{stroke:#5b6774;stroke-width:1.6}
.contour circle.halo{stroke:#fff;stroke-width:5}.contour circle.ring{stroke:#1b2530;stroke-width:2}
.contour path.zone{stroke:#0a5ea8;stroke-width:1;stroke-opacity:.6}.contour path.own{stroke-width:2;stroke-opacity:1}
.contour .missing{stroke:#7a1f6e;stroke-width:1.6}
.contour text.wrong{fill:#b3261e;font-weight:700;stroke:#fff;stroke-width:3.5px;paint-order:stroke}
.contour .way{stroke:#0a5ea8;stroke-width:1.4;stroke-opacity:.8}
.contour circle.stop{fill:#fff;stroke:#0a5ea8;stroke-width:1.6}.contour circle.begin{fill:#0a5ea8;stroke:#0a5ea8}
.contour text.number{font-size:9.5px;text-anchor:middle;fill:#0a5ea8}.contour text.first{fill:#fff}
.contour .dots{stroke:#1b2530;stroke-opacity:.5;stroke-width:2.2}
)css";

void set_levels(ContourMap& map, int n) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const Field& field = map.field;
  for (std::size_t j = 0; j < field.y.size(); ++j) {
    for (std::size_t i = 0; i < field.x.size(); ++i) {
      const Vector2d node(field.x[i], field.y[j]);
      if (!is_within(map.outline, node) || (map.is_covered && map.is_covered(node))) continue;
      low = std::min(low, field.at(i, j));
      high = std::max(high, field.at(i, j));
    }
  }
  if (low < high) map.levels = round_levels(low, high, n);
}

View view_of(const std::vector<Vector2d>& outline) {
  report::Extent extent;
  for (const Vector2d& corner : outline) extent.add(corner);
  return {extent, kContourWidth, kMaxContourHeight};
}

Drawing contour_drawing(const ContourMap& map, const View& view, const std::string& marks) {
  const std::vector<std::string> colors = colors_of(map);
  std::string bands = fmt::format("<path class=\"band\" style=\"fill:{}\" d=\"{}\"/>\n",
                                  colors[0],
                                  polygon_path(view, map.outline));
  std::string lines;
  for (std::size_t k = 0; k < map.levels.size(); ++k) {
    std::string area;
    for (const Line& line : level_area(map.field, map.levels[k])) area += path_of(view, line);
    bands +=
        fmt::format("<path class=\"band\" style=\"fill:{}\" d=\"{}\"/>\n", colors[k + 1], area);
    for (const Line& line : level_lines(map.field, map.levels[k])) lines += path_of(view, line);
  }
  Drawing out{"", view.width(), view.height() + kContourTitle + kStrip};
  out.content = fmt::format(
      R"svg(<rect class="paper" width="{0:.0f}" height="{1:.0f}"/><text class="title" x="46" y="22">{2}</text>
<g transform="translate(0 {3:.0f})">
<clipPath id="{4}-outline"><path d="{5}"/></clipPath>
<g clip-path="url(#{4}-outline)">
{6}<path class="level" d="{7}"/>
</g>
{8}<clipPath id="{4}-frame"><path d="{14}"/></clipPath>
<g clip-path="url(#{4}-frame)">
{9}</g>
{10}{11}</g>
<g transform="translate(0 {12:.0f})">{13}</g>
)svg",
      out.width,
      out.height,
      report::escaped(map.title),
      kContourTitle,
      map.id,
      polygon_path(view, map.outline),
      bands,
      lines,
      view.axes(),
      marks,
      labels_of(map, view),
      view.scale_bar(),
      kContourTitle + view.height() + 4,
      strip(map, colors, out.width),
      frame_path(view));
  return out;
}

std::string frame_path(const View& view) {
  return polygon_path(view,
                      {view.shown().low_mm,
                       {view.shown().high_mm.x(), view.shown().low_mm.y()},
                       view.shown().high_mm,
                       {view.shown().low_mm.x(), view.shown().high_mm.y()}});
}

std::string polygon_path(const View& view, const std::vector<Vector2d>& corners) {
  return path_of(view, {corners, true});
}

std::vector<Vector2d> widened(const std::vector<Vector2d>& corners, double by_mm) {
  std::vector<Vector2d> out;
  const std::size_t n = corners.size();
  const auto heading = [&](std::size_t i) {
    const Vector2d side = corners[(i + 1) % n] - corners[i % n];
    return std::atan2(side.y(), side.x());
  };
  for (std::size_t i = 0; i < n; ++i) {
    const double from = heading(i + n - 1);
    double turn = heading(i) - from;
    if (turn < 0) turn += 2 * std::numbers::pi;
    const int n_steps = std::max(1, static_cast<int>(std::ceil(kArcSteps * turn)));
    for (int k = 0; k <= n_steps; ++k) {
      const double normal = from + turn * k / n_steps - std::numbers::pi / 2;
      out.push_back(corners[i] + by_mm * Vector2d(std::cos(normal), std::sin(normal)));
    }
  }
  return out;
}

std::string sheet_svg(std::string_view title,
                      const std::vector<std::vector<Drawing>>& rows,
                      const std::vector<std::pair<std::string, std::string>>& provenance) {
  constexpr double kHead = 44;
  std::string content, description;
  double y = kHead, width = 0;
  for (const std::vector<Drawing>& row : rows) {
    double x = kContourGap, height = 0;
    for (const Drawing& drawing : row) {
      content += fmt::format(
          "<g transform=\"translate({:.0f} {:.0f})\">\n{}</g>\n", x, y, drawing.content);
      x += drawing.width + kContourGap;
      height = std::max(height, drawing.height);
    }
    y += height + kContourGap;
    width = std::max(width, x);
  }
  for (const auto& [key, value] : provenance) {
    description += report::escaped(key + ": " + value) + "\n";
  }
  return fmt::format(
      R"(<svg class="contour" xmlns="http://www.w3.org/2000/svg" width="{0:.0f}" height="{1:.0f}" viewBox="0 0 {0:.0f} {1:.0f}">
<title>{2}</title>
<desc>{3}</desc>
<style>{4}</style>
<rect class="paper" width="100%" height="100%"/>
<text class="title" x="{5:.0f}" y="30" style="font-size:18px">{2}</text>
{6}</svg>
)",
      width,
      y,
      report::escaped(title),
      description,
      kContourStyle,
      kContourGap,
      content);
}

std::string inline_svg(const Drawing& drawing, std::string_view label) {
  return fmt::format(
      "<svg class=\"contour\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0f} {:.0f}\" "
      "style=\"max-width:{:.0f}px\" role=\"img\" aria-label=\"{}\">\n{}</svg>\n",
      drawing.width,
      drawing.height,
      drawing.width,
      report::escaped(label),
      drawing.content);
}

}  // namespace panelcal::contours
