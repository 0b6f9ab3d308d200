// SPDX-License-Identifier: Apache-2.0
#include "tools/figures/svg.h"

#include <algorithm>
#include <cmath>

#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

constexpr double kAxisLeft = 46;
constexpr double kAxisRight = 14;
constexpr double kAxisTop = 12;
constexpr double kAxisBottom = 62;
/// Room around the outermost holes, as a part of the longer side.
constexpr double kViewMargin = 0.04;

}  // namespace

void Extent::add(const Eigen::Vector2d& p_mm) {
  if (!p_mm.allFinite()) return;
  low_mm = is_empty ? p_mm : Eigen::Vector2d(low_mm.cwiseMin(p_mm));
  high_mm = is_empty ? p_mm : Eigen::Vector2d(high_mm.cwiseMax(p_mm));
  is_empty = false;
}

View::View(const Extent& extent, double width, double max_height) : shown_(extent) {
  const double margin_mm = std::max(1.0, kViewMargin * extent.size_mm().maxCoeff());
  shown_.low_mm.array() -= margin_mm;
  shown_.high_mm.array() += margin_mm;
  const Eigen::Vector2d size_mm = shown_.size_mm();
  px_per_mm_ = std::min((width - kAxisLeft - kAxisRight) / size_mm.x(),
                        (max_height - kAxisTop - kAxisBottom) / size_mm.y());
  // A narrow strip would leave no room for the texts: show more of the table around it.
  const double least_mm = 0.3 * (width - kAxisLeft - kAxisRight) / px_per_mm_;
  for (int axis = 0; axis < 2; ++axis) {
    const double missing_mm = std::max(0.0, least_mm - size_mm[axis]);
    shown_.low_mm[axis] -= missing_mm / 2;
    shown_.high_mm[axis] += missing_mm / 2;
  }
  width_ = kAxisLeft + kAxisRight + shown_.size_mm().x() * px_per_mm_;
  height_ = kAxisTop + kAxisBottom + shown_.size_mm().y() * px_per_mm_;
}

Eigen::Vector2d View::at(const Eigen::Vector2d& p_mm) const {
  return {kAxisLeft + (p_mm.x() - shown_.low_mm.x()) * px_per_mm_,
          kAxisTop + (shown_.high_mm.y() - p_mm.y()) * px_per_mm_};
}

Eigen::Vector2d View::along(const Eigen::Vector2d& v_mm) const {
  return {v_mm.x() * px_per_mm_, -v_mm.y() * px_per_mm_};
}

double View::plot_side() const {
  return shown_.size_mm().minCoeff() * px_per_mm_;
}

std::string View::open(std::string_view css_class, std::string_view label) const {
  return fmt::format(
      "<svg class=\"{}\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0f} {:.0f}\" "
      "style=\"max-width:{:.0f}px\" role=\"img\" aria-label=\"{}\">\n",
      css_class,
      width_,
      height_,
      width_,
      label);
}

std::string View::ticks(int axis) const {
  const double span_mm = shown_.size_mm()[axis];
  const double step_mm = nice_below(span_mm / 3.5);
  const int n_decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step_mm) + 1e-9)));
  const double bottom = height_ - kAxisBottom;
  std::string grid;
  std::string labels;
  const double first = std::ceil(shown_.low_mm[axis] / step_mm);
  const double last = std::floor(shown_.high_mm[axis] / step_mm);
  // Counted in steps from the first one: far from zero a step may be below the number's last bit.
  for (int i = 0; i <= 20 && first + i <= last; ++i) {
    const double value_mm = (first + i) * step_mm;
    const Eigen::Vector2d p = at(Eigen::Vector2d::Constant(value_mm));
    const std::string text = fixed(value_mm, n_decimals);
    if (axis == 0) {
      grid += fmt::format("M{:.1f} {:.1f}V{:.1f}", p.x(), kAxisTop, bottom);
      labels += fmt::format(
          "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"mid\">{}</text>", p.x(), bottom + 15, text);
    } else {
      grid += fmt::format("M{:.1f} {:.1f}H{:.1f}", kAxisLeft, p.y(), width_ - kAxisRight);
      labels += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"end\">{}</text>",
                            kAxisLeft - 5,
                            p.y() + 4,
                            text);
    }
  }
  return fmt::format("<path class=\"grid\" d=\"{}\"/>{}\n", grid, labels);
}

std::string View::axes() const {
  const double bottom = height_ - kAxisBottom;
  return ticks(0) + ticks(1) +
         fmt::format(
             "<rect class=\"frame\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
             "height=\"{:.1f}\"/>"
             "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"mid\">x mm</text>"
             "<text class=\"mid\" transform=\"translate(11 {:.1f}) rotate(-90)\">y mm</text>\n",
             kAxisLeft,
             kAxisTop,
             width_ - kAxisLeft - kAxisRight,
             bottom - kAxisTop,
             (kAxisLeft + width_ - kAxisRight) / 2,
             bottom + 29,
             (kAxisTop + bottom) / 2);
}

std::string View::scale_bar() const {
  const double length_mm = nice_below(0.3 * shown_.size_mm().x());
  const double right = width_ - kAxisRight;
  const double left = right - length_mm * px_per_mm_;
  const double y = height_ - 12;
  return fmt::format(
      "<path class=\"bar\" d=\"M{0:.1f} {2:.1f}v-8M{0:.1f} {3:.1f}H{1:.1f}M{1:.1f} {2:.1f}v-8\"/>"
      "<text x=\"{4:.1f}\" y=\"{5:.1f}\" class=\"mid\">{6} mm</text>\n",
      left,
      right,
      y + 4,
      y,
      (left + right) / 2,
      y - 6,
      shortest(length_mm));
}

std::string View::reference_arrow(double length,
                                  std::string_view css_class,
                                  std::string_view text) const {
  const double y = height_ - 12;
  return fmt::format(
      "<path class=\"arrow {}\" d=\"{}\"/><text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n",
      css_class,
      arrow_path({kAxisLeft, y}, {length, 0}),
      kAxisLeft + length + 6,
      y + 4,
      text);
}

std::string arrow_path(const Eigen::Vector2d& from, const Eigen::Vector2d& v) {
  const Eigen::Vector2d tip = from + v;
  const double length = v.norm();
  if (!from.allFinite() || !v.allFinite() || length < 0.05) return {};
  std::string path =
      fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", from.x(), from.y(), tip.x(), tip.y());
  const double head = std::min(6.0, 0.45 * length);
  const Eigen::Vector2d back = -head / length * v;
  const Eigen::Vector2d side(-0.45 * back.y(), 0.45 * back.x());
  const Eigen::Vector2d left = tip + back + side;
  const Eigen::Vector2d right = tip + back - side;
  return path + fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}",
                            left.x(),
                            left.y(),
                            tip.x(),
                            tip.y(),
                            right.x(),
                            right.y());
}

ArrowScale arrow_scale(double longest_mm, double longest_px, double px_per_mm) {
  ArrowScale scale;
  if (!(longest_mm > 0)) return scale;
  scale.magnification = nice_below(longest_px / (longest_mm * px_per_mm));
  scale.px_per_um = scale.magnification * px_per_mm * 1e-3;
  scale.reference_um = nice_below(longest_px / scale.px_per_um);
  return scale;
}

}  // namespace panelcal::report
