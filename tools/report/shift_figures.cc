// SPDX-License-Identifier: Apache-2.0
#include "tools/report/shift_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

using Pair = TargetPair<frame::Actual, frame::Nominal>;
using Map = Transform<frame::Actual, frame::Nominal>;

constexpr double kShiftWidth = 440;
constexpr double kMaxShiftHeight = 360;
constexpr int kFigureCells = 14;  ///< arrows along the longer side
/// Shifts below this are nothing to draw.
constexpr double kLeast_mm = 1e-6;

Pair moved(const Eigen::Vector2d& from_mm, const Eigen::Vector2d& to_mm) {
  return {position_mm<frame::Nominal>(from_mm),
          {position_mm<frame::Actual>(to_mm), Eigen::Matrix2d::Identity()}};
}

/// The hole nearest to the middle of each cell of a coarse grid.
std::vector<Pair> holes_on_grid(const Tally& tally, const Extent& extent) {
  const double cell_mm = std::max(1e-3, extent.size_mm().maxCoeff() / kFigureCells);
  struct Candidate {
    const HoleMark* hole;
    double distance;
  };
  std::map<std::pair<int, int>, Candidate> nearest;
  for (const HoleMark& hole : tally.sample()) {
    const Eigen::Vector2d cells = (hole.nominal.in_mm() - extent.low_mm) / cell_mm;
    if (!cells.allFinite() || !hole.corrected.in_mm().allFinite()) continue;
    const Eigen::Vector2d floor = cells.array().floor();
    const double distance = (cells - floor - Eigen::Vector2d::Constant(0.5)).norm();
    const std::pair<int, int> key(static_cast<int>(floor.x()), static_cast<int>(floor.y()));
    const auto [at, is_new] = nearest.try_emplace(key, Candidate{&hole, distance});
    if (!is_new && distance < at->second.distance) at->second = {&hole, distance};
  }
  std::vector<Pair> pairs;
  for (const auto& [key, candidate] : nearest) {
    pairs.push_back(moved(candidate.hole->nominal.in_mm(), candidate.hole->corrected.in_mm()));
  }
  return pairs;
}

std::vector<Pair> found_targets(std::span<const TargetFact> facts) {
  std::vector<Pair> pairs;
  for (const TargetFact& fact : facts) {
    if (fact.measurement->status != MeasurementStatus::Found) continue;
    const Eigen::Vector2d& measured_mm = fact.measurement->measured.position.in_mm();
    if (!measured_mm.allFinite()) continue;
    pairs.push_back(moved(fact.measurement->request.nominal.in_mm(), measured_mm));
  }
  return pairs;
}

/// The least-squares map of `model`; the mean shift where the points do not determine it.
Map fitted(const std::vector<Pair>& pairs, PanelModel model) {
  for (const PanelModel candidate : {model, PanelModel::Rigid, PanelModel::Offset}) {
    if (candidate > model) continue;
    const auto result = fit_panel<frame::Actual, frame::Nominal>(pairs, candidate);
    if (result.fit) return result.fit->map.map;
  }
  return {};
}

/// Part of the shifts that is left when `taken_out` is undone, mm in nominal directions.
Eigen::Vector2d remainder_mm(const Map& taken_out, const Pair& pair) {
  return taken_out.inverse()(pair.measured.position).in_mm() - pair.nominal.in_mm();
}

/// The outline of everything shown, dashed, and where the points say it went, magnified.
std::string outlines(const Extent& extent,
                     const View& view,
                     const Map& whole,
                     const Map& taken_out,
                     double magnification) {
  const std::array<Eigen::Vector2d, 4> corners = {
      extent.low_mm,
      Eigen::Vector2d(extent.high_mm.x(), extent.low_mm.y()),
      extent.high_mm,
      Eigen::Vector2d(extent.low_mm.x(), extent.high_mm.y())};
  std::string before;
  std::string after;
  for (const Eigen::Vector2d& corner_mm : corners) {
    const Eigen::Vector2d p = view.at(corner_mm);
    const Pair pair = moved(corner_mm, whole(position_mm<frame::Nominal>(corner_mm)).in_mm());
    const Eigen::Vector2d q = p + magnification * view.along(remainder_mm(taken_out, pair));
    before += fmt::format("{}{:.1f} {:.1f}", before.empty() ? "M" : "L", p.x(), p.y());
    after += fmt::format("{}{:.1f} {:.1f}", after.empty() ? "M" : "L", q.x(), q.y());
  }
  return fmt::format(
      "<path class=\"before\" d=\"{}z\"/><path class=\"after\" d=\"{}z\"/>\n", before, after);
}

struct ShiftFigure {
  std::string_view label;
  std::string caption;
  Map taken_out;
};

std::string draw(const ShiftFigure& figure, const std::vector<Pair>& pairs, const Extent& extent) {
  const View view(extent, kShiftWidth, kMaxShiftHeight);
  double longest_mm = 0;
  for (const Pair& pair : pairs) {
    longest_mm = std::max(longest_mm, remainder_mm(figure.taken_out, pair).norm());
  }
  if (!(longest_mm > kLeast_mm)) {
    return fmt::format(
        "<figure><figcaption><b>{}.</b> {}Nothing is left to draw.</figcaption>"
        "</figure>\n",
        figure.label,
        figure.caption);
  }
  const ArrowScale scale = arrow_scale(longest_mm, 0.13 * view.plot_side(), view.px_per_mm());
  std::string path;
  for (const Pair& pair : pairs) {
    path += arrow_path(view.at(pair.nominal.in_mm()),
                       scale.magnification * view.along(remainder_mm(figure.taken_out, pair)));
  }
  return "<figure>\n" + view.open("panel", figure.label) + view.axes() +
         outlines(extent,
                  view,
                  fitted(pairs, PanelModel::Affine),
                  figure.taken_out,
                  scale.magnification) +
         fmt::format("<path class=\"arrow shift\" d=\"{}\"/>\n", path) + view.scale_bar() +
         view.reference_arrow(scale.reference_um * scale.px_per_um,
                              "shift",
                              shortest(scale.reference_um) + " &#181;m") +
         fmt::format(
             "</svg>\n<figcaption><b>{}.</b> {}Drawn <b>{} times</b> larger than true; the "
             "longest arrow is {} &#181;m.</figcaption>\n</figure>\n",
             figure.label,
             figure.caption,
             shortest(scale.magnification),
             fixed(longest_mm * 1e3, 1));
}

}  // namespace

std::string shift_figures(const ReportInput& input,
                          std::span<const TargetFact> facts,
                          const Extent& extent) {
  const bool has_holes = input.tally != nullptr && input.tally->n_holes() > 0;
  const std::vector<Pair> pairs =
      has_holes ? holes_on_grid(*input.tally, extent) : found_targets(facts);
  const bool has_moved = std::ranges::any_of(pairs, [](const Pair& pair) {
    return (pair.measured.position.in_mm() - pair.nominal.in_mm()).norm() > kLeast_mm;
  });
  if (!has_moved) return {};

  Eigen::Vector2d mean_mm = Eigen::Vector2d::Zero();
  for (const Pair& pair : pairs) {
    mean_mm += pair.measured.position.in_mm() - pair.nominal.in_mm();
  }
  mean_mm /= static_cast<double>(pairs.size());
  const Map rigid = fitted(pairs, PanelModel::Rigid);
  const double rotation_rad = deformation_of(rigid.linear()).rotation_rad;

  std::string middle = fmt::format("The middle of {} moved by ({}, {}) mm; that is taken out. ",
                                   has_holes ? "the holes" : "the targets found",
                                   fixed_signed(mean_mm.x(), 3),
                                   fixed_signed(mean_mm.y(), 3));
  std::string turned = fmt::format("The rotation by {} mrad is taken out as well. ",
                                   fixed_signed(rotation_rad * 1e3, 3));
  return draw({"How the panel turned and stretched",
               std::move(middle),
               Map(Eigen::Matrix2d::Identity(), mean_mm)},
              pairs,
              extent) +
         draw({"What is left without shift and rotation", std::move(turned), rigid}, pairs, extent);
}

}  // namespace panelcal::report
