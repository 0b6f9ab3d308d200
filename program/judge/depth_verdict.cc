// SPDX-License-Identifier: Apache-2.0
#include "program/judge/depth_verdict.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "program/walk/execution/emitter.h"
#include <Eigen/Geometry>
#include <fmt/format.h>

namespace panelcal {

// --- the passing job ---------------------------------------------------------------------------

void DepthVerdict::put(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    Counted hole;
    add(hole, operation, drill->tool, drill->nominal, drill->cut);
  } else if (const auto* rout = std::get_if<Rout>(&operation.what)) {
    add_way(contour_, operation, *rout);
    router_ = *rout;
    router_cut_ = rout->cut;
  } else if (const auto* move = std::get_if<RapidMove>(&operation.what)) {
    contour_ = {};
    router_ = *move;
  } else if (const auto* plunge = std::get_if<Plunge>(&operation.what)) {
    contour_ = {};
    add(contour_, operation, plunge->tool, router_.nominal, plunge->cut);
    router_cut_ = plunge->cut;
  } else if (const auto* slot = std::get_if<Slot>(&operation.what)) {
    Counted whole;
    add_line(whole, operation, *slot);
  } else if (const auto* change = std::get_if<ToolChange>(&operation.what)) {
    contour_ = {};
    judge_.take(*change);
  }
}

/// One a cell of the finest map's lattice, so that no bend of the surface is overlooked.
int DepthVerdict::n_samples(double length_mm) const {
  constexpr double kMost = 1000;
  double n = 1;
  for (const Expected<ZonedMap>& map : errors().maps()) {
    if (map) n = std::max(n, std::ceil(length_mm / map->finest_cell().in_mm()));
  }
  return static_cast<int>(std::min(n, kMost));
}

/// The nominal way is the corrected one, turned and stretched onto the nominal ends.
void DepthVerdict::add_way(Counted& counted, const Operation& operation, const Rout& rout) {
  const Eigen::Vector2d from_mm = router_.nominal.in_mm(), to_mm = rout.nominal.in_mm();
  Eigen::Vector2d center_mm = 0.5 * (from_mm + to_mm);
  double sweep_rad = 0;
  if (rout.kind != RoutKind::Line) {
    const auto complex = [](const Eigen::Vector2d& p_mm) {
      return std::complex<double>(p_mm.x(), p_mm.y());
    };
    const std::complex<double> begin = complex(router_.corrected.in_mm());
    const std::complex<double> chord = complex(rout.corrected.in_mm()) - begin;
    const std::complex<double> center = complex(rout.corrected_center.in_mm());
    const std::complex<double> turned =
        complex(from_mm) + (center - begin) / chord * complex(to_mm - from_mm);
    center_mm = {turned.real(), turned.imag()};
    sweep_rad = std::arg((begin + chord - center) / (begin - center));
    const bool is_clockwise = rout.kind == RoutKind::Clockwise;
    if (is_clockwise == (sweep_rad > 0)) sweep_rad += (is_clockwise ? -2 : 2) * std::numbers::pi;
  }
  const Eigen::Vector2d arm_mm = from_mm - center_mm;
  const bool is_arc = sweep_rad != 0 && center_mm.allFinite();
  const double length_mm = is_arc ? std::abs(sweep_rad) * arm_mm.norm() : (to_mm - from_mm).norm();
  const int n = n_samples(length_mm);
  for (int i = 1; i <= n; ++i) {
    const double share = static_cast<double>(i) / n;
    const Eigen::Vector2d at_mm =
        is_arc ? Eigen::Vector2d(center_mm + Eigen::Rotation2Dd(share * sweep_rad) * arm_mm)
               : Eigen::Vector2d(from_mm + share * (to_mm - from_mm));
    add(counted,
        operation,
        rout.tool,
        position_mm<frame::Nominal>(at_mm),
        interpolate(router_cut_, rout.cut, share));
  }
}

void DepthVerdict::add_line(Counted& counted, const Operation& operation, const Slot& slot) {
  const Eigen::Vector2d from_mm = slot.start.nominal.in_mm();
  const Eigen::Vector2d along_mm = slot.end.nominal.in_mm() - from_mm;
  const int n = n_samples(along_mm.norm());
  for (int i = 0; i <= n; ++i) {
    const Eigen::Vector2d at_mm = from_mm + static_cast<double>(i) / n * along_mm;
    add(counted, operation, slot.tool, position_mm<frame::Nominal>(at_mm), slot.cut);
  }
}

/// Takes a place into account; of what counts once the worst place so far stays.
void DepthVerdict::add(Counted& counted,
                       const Operation& operation,
                       int tool_number,
                       const Position<frame::Nominal>& place,
                       const DepthOfCut& cut) {
  const DepthTolerance tolerance = judge_.tolerance_of(tool_number, cut);
  if (tolerance.is_empty()) return;
  ToolFigures& tool = figures(tool_number, tolerance);
  const std::optional<DepthError> error = errors().worst_at(place, cut, tolerance);
  if (!error) {
    tool.places.n_unjudged += counted.is_unjudged ? 0 : 1;
    counted.is_unjudged = true;
    return;
  }
  if (std::abs(error->mean.in_mm()) > std::abs(tool.largest_mean.in_mm())) {
    tool.largest_mean = error->mean;
  }
  tool.largest_sigma = std::max(tool.largest_sigma, error->sigma);
  const DepthRisk risk = depth_risk(*error, tolerance);
  const bool is_first = tool.places.n_judged == 0;
  if (!counted.is_judged || risk.either() > counted.risk.either()) {
    if (counted.is_judged) count(tool, counted.risk, -1);
    count(tool, risk, 1);
    counted.is_judged = true;
    counted.risk = risk;
  }
  // Many places may be as sure to break; the farthest off says most.
  const std::pair order(risk.either(), std::abs(error->mean.in_mm()));
  if (!is_first &&
      order <= std::pair(tool.worst.risk.either(), std::abs(tool.worst.error.mean.in_mm()))) {
    return;
  }
  tool.worst.line = operation.line;
  tool.worst.file = operation.file;
  tool.worst.path.assign(operation.path.begin(), operation.path.end());
  tool.worst.nominal = place;
  tool.worst.error = *error;
  tool.worst.tolerance = tolerance;
  tool.worst.risk = risk;
}

void DepthVerdict::count(ToolFigures& tool, const DepthRisk& risk, int sign) const {
  const bool is_held = !(risk.either() <= tolerances().hold_above);
  const bool is_warned = is_held || !(risk.either() <= tolerances().warn_above);
  tool.places.n_judged += sign;
  if (is_warned) tool.places.n_warned += sign;
  if (is_held) tool.places.n_held += sign;
  tool.places.expected_broken += sign * risk.either();
  tool.expected_too_shallow += sign * risk.too_shallow;
  tool.expected_too_deep += sign * risk.too_deep;
}

DepthVerdict::ToolFigures& DepthVerdict::figures(int tool, const DepthTolerance& tolerance) {
  ToolFigures& kept = by_tool_[tool];
  // Of a tool whose diameter the program changes, the stricter one is shown.
  const auto stricter = [](std::optional<Length>& shown, const std::optional<Length>& asked) {
    if (asked && (!shown || *asked < *shown)) shown = asked;
  };
  stricter(kept.tolerance.too_shallow, tolerance.too_shallow);
  stricter(kept.tolerance.too_deep, tolerance.too_deep);
  return kept;
}

// --- the outcome -------------------------------------------------------------------------------

JudgedPlaces DepthVerdict::places() const {
  JudgedPlaces sum;
  for (const auto& [number, tool] : by_tool_) {
    sum.n_judged += tool.places.n_judged;
    sum.n_unjudged += tool.places.n_unjudged;
    sum.n_warned += tool.places.n_warned;
    sum.n_held += tool.places.n_held;
    sum.expected_broken += tool.places.expected_broken;
  }
  return sum;
}

const DepthVerdict::ToolFigures* DepthVerdict::worst_tool() const {
  const ToolFigures* worst = nullptr;
  for (const auto& [number, tool] : by_tool_) {
    if (tool.places.n_judged == 0) continue;
    if (worst == nullptr || tool.worst.risk.either() > worst->worst.risk.either()) worst = &tool;
  }
  return worst;
}

std::string DepthVerdict::sentence() const {
  const JudgedPlaces sum = places();
  std::string out(name(decision()));
  const ToolFigures* worst = worst_tool();
  if (worst == nullptr) {
    out += ": of no depth with a tolerance it is known how wrong it may be";
  } else {
    const bool is_held = sum.n_held > 0;
    const std::int64_t n = is_held ? sum.n_held : sum.n_warned;
    out += fmt::format(
        ": {} more likely than {} to be too shallow or too deep; {} of {} expected to be; the "
        "worst is line {}, {}",
        n == 0 ? "no depth is" : count_of(n, "depth is", "depths are"),
        risk_text(is_held ? tolerances().hold_above : tolerances().warn_above),
        risk_text(sum.expected_broken),
        sum.n_judged,
        line_text(worst->worst.file, worst->worst.line),
        error_text(worst->worst.error));
  }
  if (sum.n_unjudged > 0) {
    out += fmt::format("; {} not judged", count_of(sum.n_unjudged, "depth is", "depths are"));
  }
  return out;
}

void DepthVerdict::report(const std::string& file, DiagnosticLog& log) const {
  bool has_said = false;
  for (const auto& [number, tool] : by_tool_) {
    if (tool.places.n_warned == 0) continue;
    has_said = true;
    const bool is_held = tool.places.n_held > 0;
    const WorstPlace& worst = tool.worst;
    const bool is_deep =
        worst.risk.too_deep > worst.risk.too_shallow || !worst.tolerance.too_shallow;
    log.add({is_held ? Code::ToleranceHold : Code::ToleranceWarning,
             {worst.file.empty() ? file : worst.file, worst.line, 1},
             fmt::format("{} of {} depths of tool {} may break their tolerance; the worst, {}, is "
                         "more than {:.4g} um too {} with probability {} ({})",
                         is_held ? tool.places.n_held : tool.places.n_warned,
                         tool.places.n_judged,
                         number,
                         place_text(worst.nominal, worst.path),
                         (is_deep ? worst.tolerance.too_deep : worst.tolerance.too_shallow)
                             .value_or(Length())
                             .in_um(),
                         is_deep ? "deep" : "shallow",
                         risk_text(is_deep ? worst.risk.too_deep : worst.risk.too_shallow),
                         error_text(worst.error)),
             "at most " + risk_text(is_held ? tolerances().hold_above : tolerances().warn_above)});
  }
  const JudgedPlaces sum = places();
  if (sum.n_unjudged > 0) {
    std::string problem;
    for (const Expected<ZonedMap>& map : errors().maps()) {
      if (!map && problem.empty()) problem = ": " + map.error().what;
    }
    log.add({Code::ToleranceWarning,
             {file, 0, 0},
             fmt::format("the error of {} with a tolerance is not known{}",
                         count_of(sum.n_unjudged, "depth", "depths"),
                         problem),
             "twelve or more probes about them that state a sigma, or [uncertainty] depth_um where "
             "the machine finds the surface itself"});
  }
  if (auto problem = sum_problem(sum, has_said, file, "depths")) log.add(*std::move(problem));
}

}  // namespace panelcal
