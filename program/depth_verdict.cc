// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/depth_verdict.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "panelcal/calib/drift/distributions.h"

namespace panelcal {
namespace {

/// That a normal error is above a limit. Without a sigma it is or is not.
double chance_above(Length limit, Length mean, Length sigma) {
  const Length room = limit - mean;
  if (!(sigma > Length())) return room < Length() ? 1 : 0;
  return normal_exceedance(room / sigma);
}

std::string place_text(const DepthVerdict::WorstPlace& place) {
  const Eigen::Vector2d& at_mm = place.nominal.in_mm();
  const std::string path =
      place.path.empty() ? "" : fmt::format(", copy [{}]", fmt::join(place.path, ","));
  return fmt::format("at nominal ({:.3f}, {:.3f}) mm{}", at_mm.x(), at_mm.y(), path);
}

std::string error_text(const DepthError& error) {
  return fmt::format("{:.1f} um too {} if the map is right, sigma {:.1f} um",
                     std::abs(error.mean.in_um()),
                     error.mean < Length() ? "shallow" : "deep",
                     error.sigma.in_um());
}

}  // namespace

DepthRisk depth_risk(const DepthError& error, const DepthTolerance& tolerance) {
  DepthRisk risk;
  if (tolerance.too_shallow) {
    risk.too_shallow = chance_above(*tolerance.too_shallow, -error.mean, error.sigma);
  }
  if (tolerance.too_deep) {
    risk.too_deep = chance_above(*tolerance.too_deep, error.mean, error.sigma);
  }
  return risk;
}

DepthVerdict::DepthVerdict(const Tolerances& tolerances,
                           Length depth_sigma,
                           Expected<HeightMap> map)
    : tolerances_(tolerances), depth_sigma_(depth_sigma), map_(std::move(map)) {
}

// --- the passing job ---------------------------------------------------------------------------

void DepthVerdict::put(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    put_place(operation, drill->tool, *drill, drill->cut);
  } else if (const auto* rout = std::get_if<Rout>(&operation.what)) {
    put_place(operation, rout->tool, *rout, rout->cut);
    router_ = *rout;
  } else if (const auto* move = std::get_if<RapidMove>(&operation.what)) {
    router_ = *move;
  } else if (const auto* plunge = std::get_if<Plunge>(&operation.what)) {
    put_place(operation, plunge->tool, router_, plunge->cut);
  } else if (const auto* slot = std::get_if<Slot>(&operation.what)) {
    put_place(operation, slot->tool, slot->start, slot->cut);
    put_place(operation, slot->tool, slot->end, slot->cut);
  } else if (const auto* change = std::get_if<ToolChange>(&operation.what)) {
    if (change->tool.number > 0) tools_[change->tool.number] = change->tool;
  }
}

void DepthVerdict::put_place(const Operation& operation,
                             int tool_number,
                             const PlacedPoint& place,
                             const DepthOfCut& cut) {
  if (!cut.depth && !cut.surface) return;
  const auto known = tools_.find(tool_number);
  const DepthTolerance tolerance = tolerances_.depth_of(
      tool_number, known == tools_.end() ? std::nullopt : known->second.diameter);
  if (tolerance.is_empty()) return;
  ToolFigures& tool = figures(tool_number, tolerance);
  const std::optional<DepthError> error = error_at(place, cut);
  if (!error) {
    ++tool.places.n_unjudged;
    return;
  }
  const DepthRisk risk = depth_risk(*error, tolerance);
  const bool is_held = !(risk.either() <= tolerances_.hold_above);
  const bool is_warned = is_held || !(risk.either() <= tolerances_.warn_above);
  ++tool.places.n_judged;
  if (is_warned) ++tool.places.n_warned;
  if (is_held) ++tool.places.n_held;
  tool.places.expected_broken += risk.either();
  tool.expected_too_shallow += risk.too_shallow;
  tool.expected_too_deep += risk.too_deep;
  if (std::abs(error->mean.in_mm()) > std::abs(tool.largest_mean.in_mm())) {
    tool.largest_mean = error->mean;
  }
  tool.largest_sigma = std::max(tool.largest_sigma, error->sigma);
  if (tool.places.n_judged > 1 && risk.either() <= tool.worst.risk.either()) return;
  tool.worst.line = operation.line;
  tool.worst.file = operation.file;
  tool.worst.path.assign(operation.path.begin(), operation.path.end());
  tool.worst.nominal = place.nominal;
  tool.worst.error = *error;
  tool.worst.risk = risk;
}

/// Empty where nobody knows.
std::optional<DepthError> DepthVerdict::error_at(const PlacedPoint& place,
                                                 const DepthOfCut& cut) const {
  if (!cut.surface) {
    if (!(depth_sigma_ > Length())) return std::nullopt;
    return DepthError{{}, depth_sigma_};
  }
  if (!map_) return std::nullopt;
  const auto found = map_->height_at(place.nominal);
  if (!found) return std::nullopt;
  return DepthError{found->height - *cut.surface,
                    mm(std::hypot(found->sigma.in_mm(), depth_sigma_.in_mm()))};
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
        risk_text(is_held ? tolerances_.hold_above : tolerances_.warn_above),
        risk_text(sum.expected_broken),
        sum.n_judged,
        worst->worst.file.empty() ? std::to_string(worst->worst.line)
                                  : worst->worst.file + ":" + std::to_string(worst->worst.line),
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
    const bool is_deep = worst.risk.too_deep >= worst.risk.too_shallow;
    log.add({is_held ? Code::ToleranceHold : Code::ToleranceWarning,
             {worst.file.empty() ? file : worst.file, worst.line, 1},
             fmt::format("{} of {} depths of tool {} may break their tolerance; the worst, {}, is "
                         "more than {:.4g} um too {} with probability {} ({})",
                         is_held ? tool.places.n_held : tool.places.n_warned,
                         tool.places.n_judged,
                         number,
                         place_text(worst),
                         (is_deep ? tool.tolerance.too_deep : tool.tolerance.too_shallow)->in_um(),
                         is_deep ? "deep" : "shallow",
                         risk_text(is_deep ? worst.risk.too_deep : worst.risk.too_shallow),
                         error_text(worst.error)),
             "at most " + risk_text(is_held ? tolerances_.hold_above : tolerances_.warn_above)});
  }
  const JudgedPlaces sum = places();
  if (sum.n_unjudged > 0) {
    log.add({Code::ToleranceWarning,
             {file, 0, 0},
             fmt::format("of {} with a tolerance nobody knows how wrong {}{}",
                         count_of(sum.n_unjudged, "depth", "depths"),
                         sum.n_unjudged == 1 ? "it is" : "they are",
                         map_ ? "" : ": " + map_.error().what),
             "three or more probes about them that state a sigma, or [uncertainty] depth_um where "
             "the machine finds the surface itself"});
  }
  const bool is_held = !(sum.expected_broken < kExpectedToHold);
  if (sum.expected_broken < kExpectedToWarn || (is_held ? sum.n_held > 0 : has_said)) return;
  log.add({is_held ? Code::ToleranceHold : Code::ToleranceWarning,
           {file, 0, 0},
           fmt::format("{} of {} depths are expected to break their tolerance",
                       risk_text(sum.expected_broken),
                       sum.n_judged),
           fmt::format("fewer than {:g}", is_held ? kExpectedToHold : kExpectedToWarn)});
}

}  // namespace panelcal
