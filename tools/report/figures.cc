// SPDX-License-Identifier: Apache-2.0
#include "tools/report/figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "calib/base/append_format.h"
#include "tools/figures/svg.h"
#include "tools/figures/text.h"
#include "tools/report/shift_figures.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

constexpr double kPanelWidth = 620;
constexpr double kMaxPanelHeight = 760;
/// More marks than this would write their numbers over each other.
constexpr std::size_t kMaxLabels = 60;

/// Eight colours that colour-blind people tell apart (after Okabe and Ito), on light and dark; then
/// the golden angle, so that neighbouring tools differ.
std::string tool_color(std::size_t i_tool) {
  constexpr std::array<std::string_view, 8> kFirst = {
      "#0a7bc0", "#d96a00", "#009b6e", "#c2589b", "#b08a00", "#3aa6dc", "#8a5fd0", "#7d8794"};
  if (i_tool < kFirst.size()) return std::string(kFirst[i_tool]);
  return fmt::format("hsl({:.0f},55%,48%)", std::fmod(137.508 * static_cast<double>(i_tool), 360));
}

/// Holes of one tool as one path of dots in tenths of a pixel; dots on each other are drawn once.
struct Dots {
  std::string path;
  std::set<std::pair<int, int>> drawn;
  std::pair<int, int> last = {0, 0};

  void add(const Eigen::Vector2d& p_px) {
    if (!p_px.allFinite()) return;
    const std::pair<int, int> p(static_cast<int>(std::lround(10 * p_px.x())),
                                static_cast<int>(std::lround(10 * p_px.y())));
    if (!drawn.insert(p).second) return;
    internal::append_format(path, "m{} {}h0", p.first - last.first, p.second - last.second);
    last = p;
  }
};

double dot_px(const Tally& tally, int tool, const View& view) {
  const auto known = tally.tools().find(tool);
  const bool has_diameter = known != tally.tools().end() && known->second.diameter.has_value();
  const double diameter_px = has_diameter ? known->second.diameter->in_mm() * view.px_per_mm() : 0;
  return std::max(diameter_px, tally.sample().size() > 5000 ? 1.2 : 2.0);
}

std::string hole_dots(const Tally& tally, const View& view) {
  std::map<int, Dots> by_tool;
  for (const HoleMark& hole : tally.sample()) by_tool[hole.tool].add(view.at(hole.nominal.in_mm()));
  std::string out = "<g class=\"holes\" transform=\"scale(.1)\">\n";
  for (const auto& [tool, n] : tally.holes_by_tool()) {
    const auto dots = by_tool.find(tool);
    if (dots == by_tool.end()) continue;
    const auto i_tool =
        std::distance(tally.holes_by_tool().begin(), tally.holes_by_tool().find(tool));
    out += fmt::format("<path stroke=\"{}\" stroke-width=\"{:.0f}\" d=\"{}\"/>\n",
                       tool_color(static_cast<std::size_t>(i_tool)),
                       10 * dot_px(tally, tool, view),
                       dots->second.path);
  }
  return out + "</g>\n";
}

std::string_view css_class(TargetState state) {
  switch (state) {
    case TargetState::Refused:
      return "refused";
    case TargetState::Suspect:
    case TargetState::Dropped:
      return "suspect";
    case TargetState::Good:
      break;
  }
  return "good";
}

/// Marked and named however many there are.
bool is_singled_out(const TargetFact& fact) {
  return fact.state == TargetState::Refused || fact.state == TargetState::Dropped;
}

/// A ring for the panel's targets, a square for a board's, a diamond for measured holes.
std::string mark_shape(const TargetFact& fact, const Eigen::Vector2d& p, double size) {
  if (fact.series == nullptr) {
    return fmt::format(
        "<path d=\"M{0:.1f} {1:.1f}l{2:.1f} {2:.1f}l-{2:.1f} {2:.1f}l-{2:.1f}-{2:.1f}z\"/>",
        p.x(),
        p.y() - 5 * size,
        5 * size);
  }
  if (fact.series->level == CorrectionLevel::Base) {
    return fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>", p.x(), p.y(), 6 * size);
  }
  return fmt::format("<rect x=\"{0:.1f}\" y=\"{1:.1f}\" width=\"{2:.1f}\" height=\"{2:.1f}\"/>",
                     p.x() - 4 * size,
                     p.y() - 4 * size,
                     8 * size);
}

/// The mark at the nominal place, with a cross if nothing was found there; it leads to its card.
std::string target_mark(const TargetFact& fact, const View& view, double size, bool is_labelled) {
  const MeasurementRequest& request = fact.measurement->request;
  const Eigen::Vector2d p = view.at(request.nominal.in_mm());
  if (!p.allFinite()) return {};
  std::string shape = mark_shape(fact, p, size);
  if (fact.measurement->status != MeasurementStatus::Found) {
    shape += fmt::format("<path d=\"M{:.1f} {:.1f}l14 14m0-14l-14 14\"/>", p.x() - 7, p.y() - 7);
  }
  if (is_labelled) {
    shape +=
        fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>", p.x() + 8, p.y() - 6, request.seq);
  }
  return fmt::format("<a href=\"#target-{}\" class=\"mark {}\"><title>{}</title>{}</a>\n",
                     request.seq,
                     css_class(fact.state),
                     escaped(target_name(request)),
                     shape);
}

std::string residual_arrows(std::span<const TargetFact> facts,
                            const View& view,
                            const ArrowScale& scale) {
  std::map<TargetState, std::string> paths;
  for (const TargetFact& fact : facts) {
    if (!fact.residual_mm) continue;
    paths[fact.state] += arrow_path(view.at(fact.measurement->request.nominal.in_mm()),
                                    scale.magnification * view.along(*fact.residual_mm));
  }
  std::string out;
  for (const auto& [state, path] : paths) {
    out += fmt::format("<path class=\"arrow {}\" d=\"{}\"/>\n", css_class(state), path);
  }
  return out;
}

/// 0 if there are none beyond rounding, which is not worth showing.
double longest_residual_mm(std::span<const TargetFact> facts) {
  double longest_mm = 0;
  for (const TargetFact& fact : facts) {
    if (fact.residual_mm && fact.residual_mm->allFinite()) {
      longest_mm = std::max(longest_mm, fact.residual_mm->norm());
    }
  }
  constexpr double kRounding_mm = 1e-9;
  return longest_mm > kRounding_mm ? longest_mm : 0;
}

std::string tool_legend(const Tally* tally) {
  if (tally == nullptr || tally->n_holes() == 0) return {};
  std::string out = "<ul class=\"legend\">\n";
  std::size_t i_tool = 0;
  for (const auto& [number, n] : tally->holes_by_tool()) {
    const auto tool = tally->tools().find(number);
    const bool has_diameter = tool != tally->tools().end() && tool->second.diameter.has_value();
    out += fmt::format(
        "<li><span class=\"dot\" style=\"background:{}\"></span>T{} "
        "<span class=\"quiet\">{}, {}</span></li>\n",
        tool_color(i_tool++),
        number,
        has_diameter ? fixed(tool->second.diameter->in_mm(), 3) + " mm" : "diameter unknown",
        counted(n, "hole"));
  }
  return out + "</ul>\n";
}

std::string panel_caption(const ReportInput& input, double longest_mm, const ArrowScale& scale) {
  std::string out = "Holes and fiducials at their nominal places, work zero at (0, 0). ";
  if (longest_mm > 0) {
    out += fmt::format(
        "Arrows show the residuals (measured minus fitted), drawn <b>{} times</b> "
        "longer than true; the longest is {} &#181;m. ",
        shortest(scale.magnification),
        fixed(longest_mm * 1e3, 2));
  } else if (!survey_of(input).measurements.empty()) {
    out += "No residuals to show. ";
  }
  if (input.tally == nullptr) out += "Holes are shown once a program is written. ";
  if (input.tally != nullptr &&
      static_cast<std::int64_t>(input.tally->sample().size()) < input.tally->n_holes()) {
    out += fmt::format("Of {}, {} are drawn. ",
                       counted(input.tally->n_holes(), "hole"),
                       grouped(static_cast<std::int64_t>(input.tally->sample().size())));
  }
  return out;
}

std::string panel_figure(const ReportInput& input,
                         std::span<const TargetFact> facts,
                         const Extent& extent) {
  const View view(extent, kPanelWidth, kMaxPanelHeight);
  const double longest_mm = longest_residual_mm(facts);
  const ArrowScale scale = arrow_scale(longest_mm, 0.12 * view.plot_side(), view.px_per_mm());
  // Many marks become small ones.
  const double size =
      std::clamp(std::sqrt(kMaxLabels / (1.0 + static_cast<double>(facts.size()))), 0.35, 1.0);
  std::string out = "<figure class=\"main\">\n" +
                    view.open(size < 0.7 ? "panel many" : "panel",
                              "The panel with holes, fiducials and residual arrows") +
                    view.axes();
  if (input.tally != nullptr) out += hole_dots(*input.tally, view);
  for (const TargetFact& fact : facts) {
    out += target_mark(fact,
                       view,
                       is_singled_out(fact) ? 1.0 : size,
                       facts.size() <= kMaxLabels || is_singled_out(fact));
  }
  out += residual_arrows(facts, view, scale) + view.scale_bar();
  if (longest_mm > 0) {
    out += view.reference_arrow(scale.reference_um * scale.px_per_um,
                                "good",
                                shortest(scale.reference_um) + " &#181;m residual");
  }
  return out + "</svg>\n" + tool_legend(input.tally) + "<figcaption>" +
         panel_caption(input, longest_mm, scale) + "</figcaption>\n</figure>\n";
}

}  // namespace

std::string panel_figures(const ReportInput& input, std::span<const TargetFact> facts) {
  Extent extent;
  for (const TargetFact& fact : facts) extent.add(fact.measurement->request.nominal.in_mm());
  if (input.tally != nullptr) {
    for (const HoleMark& hole : input.tally->sample()) extent.add(hole.nominal.in_mm());
  }
  if (extent.is_empty) return "<p class=\"quiet\">Neither holes nor targets to draw.</p>\n";
  const std::string shifts = shift_figures(input, facts, extent);
  return fmt::format("<div class=\"figures{}\">\n{}{}</div>\n",
                     shifts.empty() ? " single" : "",
                     panel_figure(input, facts, extent),
                     shifts);
}

}  // namespace panelcal::report
