// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/output/map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "calib/base/append_format.h"
#include "tools/figures/svg.h"
#include "tools/figures/text.h"
#include "tools/plan/output/bands.h"
#include <fmt/format.h>

namespace panelcal::plan {
namespace {

using report::escaped;
using report::Extent;
using report::View;
using Place = Position<frame::Nominal>;

constexpr double kPlanWidth = 560;
constexpr double kMaxPlanHeight = 640;
constexpr double kPlanTitle = 30;  ///< height of the line above the map
constexpr std::size_t kMaxPlanNumbers = 80;

std::string path_data(const View& view, const std::vector<Eigen::Vector2d>& line) {
  std::string out;
  for (const Eigen::Vector2d& p : line) {
    const Eigen::Vector2d at = view.at(p);
    internal::append_format(out, "{}{:.1f} {:.1f}", out.empty() ? "M" : "L", at.x(), at.y());
  }
  return out + "Z";
}

std::string plan_circle(const Eigen::Vector2d& at, double radius, std::string_view css_class) {
  return fmt::format("<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>",
                     css_class,
                     at.x(),
                     at.y(),
                     radius);
}

std::string text(const Eigen::Vector2d& at, std::string_view css_class, std::string_view words) {
  return fmt::format(
      "<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>", css_class, at.x(), at.y(), words);
}

/// Puts labels where there is still room.
class Labels {
 public:
  explicit Labels(const View& view) : view_(view) {}

  bool has_room(const Eigen::Vector2d& at, double distance) const {
    return std::ranges::all_of(
        taken_, [&](const Eigen::Vector2d& other) { return (other - at).norm() > distance; });
  }
  bool is_shown(const Eigen::Vector2d& at) const {
    const Extent shown = view_.shown();
    const Eigen::Vector2d low = view_.at({shown.low_mm.x(), shown.high_mm.y()});
    const Eigen::Vector2d high = view_.at({shown.high_mm.x(), shown.low_mm.y()});
    return at.x() > low.x() + 18 && at.x() < high.x() - 18 && at.y() > low.y() + 12 &&
           at.y() < high.y() - 12;
  }
  void take(const Eigen::Vector2d& at) { taken_.push_back(at); }

 private:
  const View& view_;
  std::vector<Eigen::Vector2d> taken_;
};

/// A rectangle over all that the axes frame.
std::string plot_area(const View& view, std::string_view attributes) {
  const Extent shown = view.shown();
  const Eigen::Vector2d corner = view.at({shown.low_mm.x(), shown.high_mm.y()});
  const Eigen::Vector2d size = shown.size_mm() * view.px_per_mm();
  return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" {}/>",
                     corner.x(),
                     corner.y(),
                     size.x(),
                     size.y(),
                     attributes);
}

/// The bands, and below them the lines' figures.
std::string bands(const LeverageMap& leverage,
                  const SeriesPlan& series,
                  const View& view,
                  std::string_view clip,
                  Labels& labels) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const PlannedPlace& target : series.targets) middle += target.nominal.in_mm();
  middle /= static_cast<double>(std::max<std::size_t>(1, series.targets.size()));
  const Extent shown = view.shown();
  const double size_mm = shown.size_mm().norm();
  const Eigen::Vector2d center = calmest(leverage, middle, size_mm / 4);
  const double least = leverage(position_mm<frame::Nominal>(center));
  double greatest = least;
  for (const double x : {shown.low_mm.x(), shown.high_mm.x()}) {
    for (const double y : {shown.low_mm.y(), shown.high_mm.y()}) {
      greatest = std::max(greatest, leverage(position_mm<frame::Nominal>(x, y)));
    }
  }
  const double farthest_mm = 2 * size_mm + (center - middle).norm();
  std::string areas = plot_area(view, fmt::format("style=\"fill:{}\"", kColors[band_of(greatest)]));
  std::string figures;
  for (std::size_t k = kLevels.size(); k-- > 0;) {
    const double level = kLevels[k];
    if (level <= least || level > greatest) continue;
    const auto line = level_line(leverage, center, level, farthest_mm);
    areas += fmt::format("<path class=\"level{}\" style=\"fill:{}\" d=\"{}\"/>\n",
                         level == 1 ? " one" : "",
                         kColors[k],
                         path_data(view, line));
    for (std::size_t i = 0; i < line.size(); ++i) {
      // Towards the upper right first, then round.
      const Eigen::Vector2d at = view.at(line[(i * 7 + line.size() / 8) % line.size()]);
      if (!labels.is_shown(at) || !labels.has_room(at, 34)) continue;
      figures += text(at + Eigen::Vector2d(0, 4), "figure", fmt::format("{}", level));
      labels.take(at);
      break;
    }
  }
  return fmt::format("<g clip-path=\"url(#{})\">\n{}</g>\n{}\n", clip, areas, figures);
}

std::string place_dots(const std::vector<Place>& places, const View& view) {
  std::set<std::pair<long, long>> drawn;
  std::string path;
  for (const Place& place : places) {
    const Eigen::Vector2d at = view.at(place.in_mm());
    if (!at.allFinite()) continue;
    if (!drawn.emplace(std::lround(2 * at.x()), std::lround(2 * at.y())).second) continue;
    internal::append_format(path, "M{:.1f} {:.1f}h0", at.x(), at.y());
  }
  return fmt::format(
      "<path class=\"dots{}\" d=\"{}\"/>\n", places.size() > 1500 ? " many" : "", path);
}

std::string cross_at(const Eigen::Vector2d& at, double size, std::string_view css_class) {
  return fmt::format("<path class=\"{0}\" d=\"M{1:.1f} {2:.1f}h{3:.1f}M{4:.1f} {5:.1f}v{3:.1f}\"/>",
                     css_class,
                     at.x() - size,
                     at.y(),
                     2 * size,
                     at.x(),
                     at.y() - size);
}

/// Every target as a ring with a cross.
std::string target_marks(const std::vector<PlannedPlace>& targets,
                         const View& view,
                         Labels& labels) {
  std::string out;
  for (const PlannedPlace& target : targets) {
    const Eigen::Vector2d at = view.at(target.nominal.in_mm());
    out += plan_circle(at, 7, "halo") + plan_circle(at, 7, "target") + cross_at(at, 3, "target") +
           "\n";
    labels.take(at);
  }
  return out;
}

std::string pad_marks(const std::vector<PlannedPlace>& pads, const View& view) {
  std::string out;
  for (const PlannedPlace& pad : pads) {
    const Eigen::Vector2d at = view.at(pad.nominal.in_mm());
    out += fmt::format("<g><title>{}</title>{}{}</g>\n",
                       escaped(fmt::format("line {}", pad.line)),
                       plan_circle(at, 8, "pad"),
                       cross_at(at, 4.5, "plus"));
  }
  return out;
}

/// The worst place, with what it has.
std::string worst_mark(const LeverageStats& stats, const View& view) {
  const Eigen::Vector2d at = view.at(stats.worst_place.nominal.in_mm());
  const Extent shown = view.shown();
  const Eigen::Vector2d middle = view.at((shown.low_mm + shown.high_mm) / 2);
  // Towards the middle there is always room.
  const double dx = at.x() > middle.x() ? -14 : 14;
  const double dy = at.y() > middle.y() ? -12 : 20;
  return fmt::format("<g><title>worst place</title>{}{}</g>{}\n",
                     plan_circle(at, 10, "halo"),
                     plan_circle(at, 10, "worst"),
                     text(at + Eigen::Vector2d(dx, dy),
                          dx < 0 ? "worst end" : "worst",
                          fmt::format("worst {:.2f} x", stats.worst)));
}

Extent extent_of(const SeriesPlan& series) {
  Extent extent;
  for (const Place& place : series.sample) extent.add(place.in_mm());
  for (const PlannedPlace& target : series.targets) extent.add(target.nominal.in_mm());
  for (const auto* addition : {&series.one, &series.several}) {
    if (!*addition) continue;
    for (const PlannedPlace& pad : (*addition)->pads) extent.add(pad.nominal.in_mm());
  }
  if (series.n_places > 0) {
    for (const ModelPlan& model : series.models) {
      if (model.fit) extent.add(model.stats.worst_place.nominal.in_mm());
    }
  }
  return extent;
}

Drawing framed(const View& view, std::string_view title, const std::string& content) {
  Drawing drawing{"", view.width(), view.height() + kPlanTitle};
  drawing.content = fmt::format(
      "<rect class=\"paper\" width=\"{:.0f}\" height=\"{:.0f}\"/>{}<g transform=\"translate(0 "
      "{:.0f})\">\n{}</g>\n",
      drawing.width,
      drawing.height,
      text({46, 22}, "title", title),
      kPlanTitle,
      content);
  return drawing;
}

std::string way(const VisitPlan& visits, const std::vector<std::size_t>& order, const View& view) {
  std::string out;
  for (const std::size_t i : order) {
    const Eigen::Vector2d at = view.at(visits.places[i].in_mm());
    internal::append_format(out, "{}{:.1f} {:.1f}", out.empty() ? "M" : "L", at.x(), at.y());
  }
  return out;
}

}  // namespace

const std::string_view kPlanStyle = R"css(
.plan .paper{fill:#fff}
.plan text{font:12px system-ui,"DejaVu Sans",sans-serif;fill:#5b6774}
.plan .mid{text-anchor:middle}.plan .end{text-anchor:end}
.plan text.title{font-size:14px;font-weight:600;fill:#1b2530}
.plan path,.plan circle{fill:none;stroke-linecap:round;stroke-linejoin:round}
.plan .grid{stroke:#1b2530;stroke-opacity:.1;stroke-width:.6}
.plan .frame{fill:none;stroke:#5b6774;stroke-width:.8}.plan .bar{stroke:#1b2530;stroke-width:1.3}
.plan path.level{stroke:#fff;stroke-width:.8;stroke-opacity:.75}
.plan path.one{stroke:#2f6f62;stroke-width:1.2;stroke-opacity:.8}
.plan text.figure{font-size:10.5px;text-anchor:middle;fill:#1b2530;stroke:#fff;stroke-opacity:.7;stroke-width:2.5px;paint-order:stroke}
.plan .dots{stroke:#1b2530;stroke-opacity:.42;stroke-width:2.4}.plan .dots.many{stroke-width:1.4;stroke-opacity:.3}
.plan .hull{stroke:#1b2530;stroke-width:1.2;stroke-dasharray:5 4}
.plan .halo{stroke:#fff;stroke-width:5;stroke-opacity:.85}
.plan .target{stroke:#1b2530;stroke-width:1.8}
.plan circle.pad{fill:#0a5ea8;stroke:#fff;stroke-width:2}.plan .plus{stroke:#fff;stroke-width:2.2}
.plan circle.worst{stroke:#b3261e;stroke-width:2.4}
.plan text.worst{fill:#b3261e;font-weight:700;stroke:#fff;stroke-width:3.5px;paint-order:stroke}
.plan .programmed{stroke:#8b96a2;stroke-width:1.4;stroke-dasharray:2 5}
.plan .short{stroke:#0a5ea8;stroke-width:2}
.plan circle.stop{fill:#fff;stroke:#0a5ea8;stroke-width:1.6}.plan circle.begin{fill:#0a5ea8;stroke:#0a5ea8}
.plan text.number{font-size:9.5px;text-anchor:middle;fill:#0a5ea8}.plan text.first{fill:#fff}
)css";

Drawing leverage_drawing(const SeriesPlan& series, const AdditionPlan* addition) {
  const Extent extent = extent_of(series);
  const auto& fit = addition != nullptr ? addition->fit : series.in_force().fit;
  if (extent.is_empty) return {};
  const View view(extent, kPlanWidth, kMaxPlanHeight);
  const std::string clip =
      fmt::format("clip-{}-{}", series.i_series, addition != nullptr ? addition->pads.size() : 0);
  Labels labels(view);
  const LeverageStats& stats = addition != nullptr ? addition->stats : series.in_force().stats;
  labels.take(view.at(stats.worst_place.nominal.in_mm()));
  const std::string marks = target_marks(series.targets, view, labels);
  std::string out = fmt::format("<clipPath id=\"{}\">{}</clipPath>\n", clip, plot_area(view, ""));
  if (fit) out += bands(LeverageMap(fit->cov), series, view, clip, labels);
  out += view.axes() + place_dots(series.sample, view);
  std::vector<Eigen::Vector2d> hull;
  for (const Place& corner : series.hull) hull.push_back(corner.in_mm());
  if (hull.size() > 1)
    out += fmt::format("<path class=\"hull\" d=\"{}\"/>\n", path_data(view, hull));
  if (fit && stats.n > 0) out += worst_mark(stats, view);
  out += marks;
  if (addition != nullptr) out += pad_marks(addition->pads, view);
  out += view.scale_bar();
  std::string title = addition == nullptr ? "as programmed"
                      : addition->pads.size() == 1
                          ? "with one more target"
                          : fmt::format("with {} more targets", addition->pads.size());
  title += fmt::format(", {}", name(addition != nullptr ? addition->model : series.programmed));
  if (!fit) title += ": not determined";
  return framed(view, title, out);
}

Drawing visits_drawing(const Plan& plan) {
  const VisitPlan& visits = plan.visits;
  Extent extent;
  for (const Place& place : visits.places) extent.add(place.in_mm());
  for (const SeriesPlan& series : plan.series) {
    for (const Place& place : series.sample) extent.add(place.in_mm());
  }
  if (visits.places.size() < 2) return {};
  const View view(extent, kPlanWidth, kMaxPlanHeight);
  std::vector<std::size_t> programmed(visits.places.size());
  for (std::size_t i = 0; i < programmed.size(); ++i) programmed[i] = i;
  std::string out = view.axes();
  for (const SeriesPlan& series : plan.series) out += place_dots(series.sample, view);
  out += fmt::format("<path class=\"programmed\" d=\"{}\"/>\n<path class=\"short\" d=\"{}\"/>\n",
                     way(visits, programmed, view),
                     way(visits, visits.free, view));
  for (std::size_t k = 0; k < visits.free.size() && visits.free.size() <= kMaxPlanNumbers; ++k) {
    const Eigen::Vector2d at = view.at(visits.places[visits.free[k]].in_mm());
    out += plan_circle(at, 8, k == 0 ? "stop begin" : "stop") +
           text(at + Eigen::Vector2d(0, 3.5),
                k == 0 ? "number first" : "number",
                std::to_string(k + 1)) +
           "\n";
  }
  out += view.scale_bar();
  return framed(view,
                fmt::format("order of visits: {:.0f} mm, dotted as programmed {:.0f} mm",
                            visits.free_length.in_mm(),
                            visits.programmed.in_mm()),
                out);
}

Drawing scale_drawing(const SeriesPlan& series) {
  constexpr double kStep = 32;
  Drawing drawing{"", 46 + kStep * static_cast<double>(kColors.size()) + 14, 62};
  std::string out = fmt::format(
      "<rect class=\"paper\" width=\"{:.0f}\" height=\"{:.0f}\"/>", drawing.width, drawing.height);
  for (std::size_t k = 0; k < kColors.size(); ++k) {
    const double x = 46 + kStep * static_cast<double>(k);
    out += fmt::format(
        "<rect x=\"{:.0f}\" y=\"20\" width=\"{:.1f}\" height=\"12\" style=\"fill:{}\"/>",
        x,
        kStep,
        kColors[k]);
    if (k == kLevels.size()) continue;
    out += text({x + kStep, 14}, "mid", fmt::format("{}", kLevels[k]));
    out += text({x + kStep, 47}, "mid", fmt::format("{:.3g}", kLevels[k] * series.noise.in_um()));
  }
  out += text({40, 14}, "end", "x") + text({40, 47}, "end", "&#181;m");
  drawing.content = out + "\n";
  return drawing;
}

}  // namespace panelcal::plan
