// SPDX-License-Identifier: Apache-2.0
#include "tools/nightly/figures.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/base/clock.h"
#include "calib/drift/amount.h"
#include "tools/figures/svg.h"
#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::nightly {

const std::string_view kFigureStyle = R"css(
svg.drift{display:block;width:100%;height:auto}
svg.drift .night{stroke:var(--link);stroke-width:1.4}svg.drift .dot{fill:var(--link);stroke:var(--link)}
svg.drift .force{stroke:var(--shift);stroke-width:1.6}
svg.drift .zero{stroke:var(--quiet);stroke-dasharray:2 4}
svg.drift .fresh{stroke:var(--warn);stroke-dasharray:6 4}
svg.drift .refused{stroke:var(--bad);stroke-width:2}svg.drift .ring{stroke:var(--warn);stroke-width:1.8}
svg.drift .band{fill:var(--good-soft);stroke:var(--good);stroke-width:1}
svg.drift text.bad{fill:var(--bad);font-weight:600}
.charts{display:grid;grid-template-columns:repeat(auto-fit,minmax(430px,1fr));gap:8px 20px;align-items:start}
@media (max-width:720px){.charts{grid-template-columns:minmax(0,1fr)}}
)css";

namespace {

using report::escaped;

constexpr double kNightWidth = 560;
constexpr double kNightHeight = 230;
constexpr double kNightLeft = 58;
constexpr double kNightRight = 16;
constexpr double kNightTop = 14;
constexpr double kNightBottom = 34;
constexpr double kBandSigmas = 3;
constexpr double kBandHalfWidth = 6;

/// The unit that people read: a series in mm is drawn in um.
struct Unit {
  double factor = 1;
  std::string name;
};

Unit shown_unit(const std::string& unit) {
  if (unit == "mm") return {1e3, "um"};
  if (unit == "rad") return {1e6, "urad"};
  return {1, unit};
}

std::optional<double> at(const std::vector<double>& values, std::size_t i) {
  if (i >= values.size() || !std::isfinite(values[i])) return std::nullopt;
  return values[i];
}

struct FigureRange {
  double low = 0;
  double high = 0;

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

class DriftFigure {
 public:
  DriftFigure(const NightStep& step, std::size_t i_axis)
      : step_(step), i_axis_(i_axis), axis_(step.axes[i_axis]), unit_(shown_unit(axis_.unit)) {
    find_zero();
    find_ranges();
  }

  bool is_worth_it() const { return n_shown_ >= 2; }

  std::string draw() const {
    const std::string label = escaped(
        fmt::format("{} of {} {} over {} nights", axis_.name, step_.kind, step_.subject, n_shown_));
    return fmt::format(
               "<svg class=\"drift\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" "
               "role=\"img\" aria-label=\"{}\">\n",
               kNightWidth,
               kNightHeight,
               label) +
           axes() + tonight() + in_force() + nights() + "</svg>\n";
  }

 private:
  /// Values are shown against what is in force now, else against the last night's.
  void find_zero() {
    for (const NightPlotPoint& p : step_.series) {
      if (const auto value = at(p.value, i_axis_)) zero_ = *value;
    }
    if (step_.series.empty()) return;
    if (const auto value = at(step_.series.back().in_force, i_axis_)) zero_ = *value;
  }

  double shown(double value) const { return (value - zero_) * unit_.factor; }

  /// A refused result may be anywhere, and what was before a fresh start as well; the others are
  /// what the picture is for.
  void find_ranges() {
    bool is_first = true;
    const std::size_t i_begin = last_fresh_start();
    for (std::size_t i = 0; i < step_.series.size(); ++i) {
      const NightPlotPoint& p = step_.series[i];
      const double t = seconds_of(p.time);
      time_s_ = is_first ? FigureRange{t, t} : time_s_;
      time_s_.add(t);
      is_first = false;
      const auto value = at(p.value, i_axis_);
      n_shown_ += value ? 1 : 0;
      if (i < i_begin) continue;
      if (const auto old = at(p.in_force, i_axis_)) value_.add(shown(*old));
      if (!value || p.is_refused) continue;
      const double sigma = at(p.sigma, i_axis_).value_or(0) * unit_.factor;
      value_.add(shown(*value) - sigma);
      value_.add(shown(*value) + sigma);
    }
    if (const auto band = predicted()) {
      value_.add(band->low);
      value_.add(band->high);
    }
    const double margin = std::max(0.08 * (value_.high - value_.low), 1e-9);
    value_ = {value_.low - margin, value_.high + margin};
    if (time_s_.low == time_s_.high) time_s_ = {time_s_.low - 43200, time_s_.high + 43200};
  }

  std::size_t last_fresh_start() const {
    for (std::size_t i = step_.series.size(); i > 0; --i) {
      if (step_.series[i - 1].is_fresh_start) return i - 1;
    }
    return 0;
  }

  std::optional<FigureRange> predicted() const {
    if (!axis_.expected || !axis_.expected_sigma) return std::nullopt;
    // The nights before say nothing about a fresh start.
    if (!step_.series.empty() && step_.series.back().is_fresh_start) return std::nullopt;
    const double middle = shown(*axis_.expected);
    const double half = kBandSigmas * *axis_.expected_sigma * unit_.factor;
    if (!std::isfinite(middle) || !std::isfinite(half)) return std::nullopt;
    return FigureRange{middle - half, middle + half};
  }

  static double seconds_of(std::chrono::sys_seconds time) {
    return static_cast<double>(time.time_since_epoch().count());
  }
  double x(std::chrono::sys_seconds time) const {
    // Room on the right for tonight's band.
    const double width = kNightWidth - kNightLeft - kNightRight - 2 * kBandHalfWidth;
    return kNightLeft + kBandHalfWidth +
           width * (seconds_of(time) - time_s_.low) / (time_s_.high - time_s_.low);
  }
  double y(double value) const {
    const double inside = std::clamp(value, value_.low, value_.high);
    return kNightHeight - kNightBottom -
           (kNightHeight - kNightTop - kNightBottom) * (inside - value_.low) /
               (value_.high - value_.low);
  }

  std::string axes() const {
    const double step = report::nice_below((value_.high - value_.low) / 3);
    const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
    std::string out;
    const double first = std::ceil(value_.low / step);
    for (int i = 0; i < 20 && (first + i) * step <= value_.high; ++i) {
      const double value = (first + i) * step;
      out += fmt::format(
          "<path class=\"grid\" d=\"M{} {:.1f}H{}\"/><text class=\"end\" x=\"{}\" "
          "y=\"{:.1f}\">{}</text>\n",
          kNightLeft,
          y(value),
          kNightWidth - kNightRight,
          kNightLeft - 5,
          y(value) + 4,
          value == 0 ? "0" : report::fixed_signed(value, decimals));
    }
    out += fmt::format(
        "<path class=\"zero\" d=\"M{} {:.1f}H{}\"/>"
        "<rect class=\"frame\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n",
        kNightLeft,
        y(0),
        kNightWidth - kNightRight,
        kNightLeft,
        kNightTop,
        kNightWidth - kNightLeft - kNightRight,
        kNightHeight - kNightTop - kNightBottom);
    const auto day = [](double time_s) {
      const std::chrono::seconds whole(static_cast<std::int64_t>(time_s));
      return iso_8601(std::chrono::sys_seconds(whole)).substr(0, 10);
    };
    return out + fmt::format(
                     "<text x=\"{0}\" y=\"{2}\">{3}</text>"
                     "<text class=\"end\" x=\"{1}\" y=\"{2}\">{4}</text>"
                     "<text class=\"mid\" transform=\"translate(12 {5}) rotate(-90)\">{6}</text>\n",
                     kNightLeft,
                     kNightWidth - kNightRight,
                     kNightHeight - kNightBottom + 18,
                     day(time_s_.low),
                     day(time_s_.high),
                     (kNightTop + kNightHeight - kNightBottom) / 2,
                     escaped(axis_.name + ", " + unit_.name));
  }

  /// Mark of tonight's predicted value.
  std::string tonight() const {
    const auto band = predicted();
    if (!band || step_.series.empty()) return {};
    const double middle = x(step_.series.back().time);
    return fmt::format(
        "<rect class=\"band\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{:.1f}\"/>\n",
        middle - kBandHalfWidth,
        y(band->high),
        2 * kBandHalfWidth,
        std::max(1.0, y(band->low) - y(band->high)));
  }

  /// Line of the value with which holes were drilled from each night on.
  std::string in_force() const {
    std::string path;
    for (const NightPlotPoint& p : step_.series) {
      const auto value = at(p.in_force, i_axis_);
      if (!value) continue;
      const double height = y(shown(*value));
      path += path.empty() ? fmt::format("M{:.1f} {:.1f}", x(p.time), height)
                           : fmt::format("H{:.1f}V{:.1f}", x(p.time), height);
    }
    return path.empty() ? path : fmt::format("<path class=\"force\" d=\"{}\"/>\n", path);
  }

  std::string nights() const {
    std::string out;
    for (const NightPlotPoint& p : step_.series) {
      if (p.is_fresh_start) {
        out += fmt::format("<path class=\"fresh\" d=\"M{:.1f} {}V{}\"/>\n",
                           x(p.time),
                           kNightTop,
                           kNightHeight - kNightBottom);
      }
      if (const auto value = at(p.value, i_axis_)) out += night(p, *value);
    }
    return out;
  }

  std::string night(const NightPlotPoint& p, double value) const {
    const double px = x(p.time);
    const double py = y(shown(value));
    std::string out;
    if (const auto sigma = at(p.sigma, i_axis_)) {
      const double half = *sigma * unit_.factor;
      out += fmt::format("<path class=\"night\" d=\"M{:.1f} {:.1f}V{:.1f}\"/>",
                         px,
                         y(shown(value) - half),
                         y(shown(value) + half));
    }
    if (p.is_alarm) {
      out += fmt::format("<circle class=\"ring\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"7\"/>", px, py);
    }
    if (!p.is_refused) {
      return out +
             fmt::format("<circle class=\"dot\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.4\"/>\n", px, py);
    }
    out += fmt::format(
        "<path class=\"refused\" d=\"M{:.1f} {:.1f}l8 8m0 -8l-8 8\"/>\n", px - 4, py - 4);
    const bool is_beyond = shown(value) > value_.high || shown(value) < value_.low;
    if (!is_beyond) return out;
    const bool is_right = px > kNightWidth / 2;
    return out + fmt::format("<text class=\"bad{}\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n",
                             is_right ? " end" : "",
                             px + (is_right ? -9 : 9),
                             std::clamp(py + 4, kNightTop + 12, kNightHeight - kNightBottom - 4),
                             escaped(signed_amount(value - zero_, axis_.unit)));
  }

  const NightStep& step_;
  std::size_t i_axis_;
  const NightAxis& axis_;
  Unit unit_;
  double zero_ = 0;
  int n_shown_ = 0;
  FigureRange time_s_;
  FigureRange value_;
};

}  // namespace

std::string drift_figure(const NightStep& step, std::size_t i_axis) {
  if (i_axis >= step.axes.size()) return {};
  const DriftFigure figure(step, i_axis);
  if (!figure.is_worth_it()) return {};
  return fmt::format(
      "<figure>\n{}<figcaption><b>{}</b> against what is in force now</figcaption>"
      "</figure>\n",
      figure.draw(),
      escaped(step.axes[i_axis].name));
}

std::string holes_figure(const NightStep& step) {
  if (step.holes.empty()) return {};
  report::Extent extent;
  double longest_mm = 0;
  for (const NightHole& hole : step.holes) {
    if (!hole.place_mm.allFinite() || !hole.residual_mm.allFinite()) continue;
    extent.add(hole.place_mm);
    longest_mm = std::max(longest_mm, hole.residual_mm.norm());
  }
  if (extent.is_empty) return {};
  const report::View view(extent, 440, 320);
  const auto scale = report::arrow_scale(longest_mm, 0.16 * view.plot_side(), view.px_per_mm());
  std::string marks;
  for (const NightHole& hole : step.holes) {
    if (!hole.place_mm.allFinite() || !hole.residual_mm.allFinite()) continue;
    const Eigen::Vector2d from = view.at(hole.place_mm);
    const std::string arrow =
        report::arrow_path(from, scale.magnification * view.along(hole.residual_mm));
    const std::string_view css = hole.is_outlier ? " refused" : "";
    marks += fmt::format(
        "<g class=\"mark{0}\"><circle cx=\"{1:.1f}\" cy=\"{2:.1f}\" r=\"4\"/></g>"
        "<path class=\"arrow{0}\" d=\"{3}\"/>\n",
        css,
        from.x(),
        from.y(),
        arrow);
  }
  return "<figure>\n" + view.open("panel", "Holes of the coupon and their residuals") +
         view.axes() + marks + view.scale_bar() +
         view.reference_arrow(scale.reference_um * scale.px_per_um,
                              "",
                              report::shortest(scale.reference_um) + " &#181;m") +
         fmt::format(
             "</svg>\n<figcaption><b>Where the drill went.</b> Each hole about the fit, drawn "
             "{} times larger than true; the longest arrow is {} "
             "&#181;m.{}</figcaption></figure>\n",
             report::shortest(scale.magnification),
             report::fixed(longest_mm * 1e3, 1),
             std::ranges::any_of(step.holes, &NightHole::is_outlier) ? " Red: left out." : "");
}

}  // namespace panelcal::nightly
