// SPDX-License-Identifier: Apache-2.0
#include "program/judge/job_verdict.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

std::size_t decade_of(double risk) {
  constexpr double kLowest = 1e-12;
  static_assert(JobVerdict::kLowestDecade == -12);
  if (!(risk > kLowest)) return 0;
  const double steps = std::floor(std::log10(risk) - JobVerdict::kLowestDecade);
  return 1 + static_cast<std::size_t>(
                 std::clamp(steps, 0.0, static_cast<double>(JobVerdict::kDecades - 2)));
}

}  // namespace

// --- figures -----------------------------------------------------------------------------------

Length RadialFigures::mean() const {
  return mm(n == 0 ? 0 : sum_mm / static_cast<double>(n));
}

Length RadialFigures::deviation() const {
  if (n == 0) return {};
  const double mean_mm = mean().in_mm();
  return mm(std::sqrt(std::max(0.0, sum_squares_mm2 / static_cast<double>(n) - mean_mm * mean_mm)));
}

std::optional<double> RadialFigures::cpk(Length tolerance) const {
  const Length scatter = deviation();
  if (!(scatter > Length())) return std::nullopt;
  return (tolerance - mean()) / (3 * scatter);
}

JobVerdict::JobVerdict(const Tolerances& tolerances) : tolerances_(tolerances) {
  // As costly as a thousand holes, and the same for every job.
  static const auto tables = [] {
    std::pair<ByRatio, ByRatio> made;
    for (int i = 0; i <= kRatios; ++i) {
      const PrincipalSigmas sigmas{mm(1), mm(static_cast<double>(i) / kRatios)};
      made.first[static_cast<std::size_t>(i)] = radius_exceeded(sigmas, 0.05).in_mm();
      made.second[static_cast<std::size_t>(i)] = mean_radial_error(sigmas).in_mm();
    }
    return made;
  }();
  std::tie(radii_95_, means_) = tables;
}

Length JobVerdict::interpolated(const ByRatio& table, const PrincipalSigmas& sigmas) {
  if (!(sigmas.large > Length())) return {};
  const double at = std::clamp(sigmas.small / sigmas.large, 0.0, 1.0) * kRatios;
  const auto i = std::min<std::size_t>(static_cast<std::size_t>(at), kRatios - 1);
  const double part = at - static_cast<double>(i);
  return (table[i] + part * (table[i + 1] - table[i])) * sigmas.large;
}

void JobVerdict::begin(const ProgramInfo& info) {
  tools_ = info.tools;
}

JobVerdict::ToolFigures& JobVerdict::figures(int tool) {
  if (last_ != nullptr && tool == tool_) return *last_;
  const auto [found, is_new] = by_tool_.try_emplace(tool);
  const auto known = tools_.find(tool);
  const std::optional<Length> radius =
      tolerances_.radius(tool, known == tools_.end() ? std::nullopt : known->second.diameter);
  std::optional<Length>& kept = found->second.tolerance;
  if (radius && (!kept || *radius < *kept)) kept = radius;
  tool_ = tool;
  last_ = &found->second;
  return *last_;
}

// --- the passing job ---------------------------------------------------------------------------

void JobVerdict::put(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    ++n_places_;
    put_place(operation, drill->tool, *drill);
  } else if (const auto* rout = std::get_if<Rout>(&operation.what)) {
    ++n_places_;
    put_place(operation, rout->tool, *rout);
    router_ = *rout;
  } else if (const auto* move = std::get_if<RapidMove>(&operation.what)) {
    ++n_places_;
    router_ = *move;
  } else if (const auto* plunge = std::get_if<Plunge>(&operation.what)) {
    put_plunge(operation, plunge->tool);
  } else if (const auto* slot = std::get_if<Slot>(&operation.what)) {
    has_slots_ = true;
    put_place(operation, slot->tool, slot->start);
    put_place(operation, slot->tool, slot->end);
  } else if (const auto* step_slot = std::get_if<StepSlot>(&operation.what)) {
    has_slots_ = true;
    put_place(operation, step_slot->tool, step_slot->start);
    put_place(operation, step_slot->tool, step_slot->end);
  } else if (const auto* change = std::get_if<ToolChange>(&operation.what)) {
    if (change->tool.number > 0) tools_[change->tool.number] = change->tool;
    last_ = nullptr;
  }
}

void JobVerdict::put_place(const Operation& operation, int tool_number, const PlacedPoint& place) {
  ToolFigures& tool = figures(tool_number);
  const double square_mm2 = place.cov_mm2.trace();
  // Written so that a NaN counts as a predicted error, and is refused as one.
  if (square_mm2 <= 0 && !place.judged_risk) {
    ++tool.n_uncorrected;
    return;
  }
  const PrincipalSigmas sigmas = principal_sigmas(place.cov_mm2);
  ++tool.predicted.n;
  tool.predicted.sum_mm += interpolated(means_, sigmas).in_mm();
  tool.predicted.sum_squares_mm2 += square_mm2;
  tool.largest_sigma = std::max(tool.largest_sigma, sigmas.large);
  tool.largest_radius_95 = std::max(tool.largest_radius_95, interpolated(radii_95_, sigmas));
  if (place.judged_risk) judge(operation, tool, place);
}

/// The router went there before it was said which tool goes down.
void JobVerdict::put_plunge(const Operation& operation, int tool_number) {
  PlacedPoint place = router_;
  const auto known = tools_.find(tool_number);
  const std::optional<Length> radius = tolerances_.radius(
      tool_number, known == tools_.end() ? std::nullopt : known->second.diameter);
  place.judged_risk.reset();
  if (radius && place.cov_mm2.trace() > 0) {
    place.judged_risk = breaking_probability(place.cov_mm2, *radius);
    // As much is told of it as of the place with the tool that was in use there.
    const bool is_bounded = place.risk && *place.risk >= kMinStatedRisk;
    if (place.risk) {
      place.risk = is_bounded ? std::max(*place.judged_risk, kMinStatedRisk) : place.judged_risk;
    }
  }
  put_place(operation, tool_number, place);
}

void JobVerdict::judge(const Operation& operation, ToolFigures& tool, const PlacedPoint& place) {
  const double risk = *place.judged_risk;
  count_told(operation, tool, place);
  const bool is_held = !(risk <= tolerances_.hold_above);
  const bool is_warned = is_held || !(risk <= tolerances_.warn_above);
  ++tool.n_judged;
  tool.expected_broken += risk;
  if (is_warned) ++tool.n_warned;
  if (is_held) ++tool.n_held;
  Decade& decade = decades_[decade_of(risk)];
  ++(is_held ? decade.n_held : is_warned ? decade.n_warned : decade.n_good);
  if (tool.n_judged > 1 && risk <= tool.worst.risk) return;
  tool.worst.line = operation.line;
  tool.worst.file = operation.file;
  tool.worst.path.assign(operation.path.begin(), operation.path.end());
  tool.worst.nominal = place.nominal;
  tool.worst.risk = risk;
  const bool is_counted = !has_slots_ && std::holds_alternative<Drill>(operation.what);
  tool.worst.number = is_counted ? std::optional(n_places_) : std::nullopt;
  tool.worst.budget_place.reset();
  if (operation.origin != nullptr) {
    tool.worst.budget_place = budget_place(place, *operation.origin);
  }
}

void JobVerdict::count_told(const Operation& operation,
                            ToolFigures& tool,
                            const PlacedPoint& place) {
  if (!place.risk) return;
  ++tool.n_told;
  // Written so that a NaN stays.
  if (!(*place.risk <= tool.stated_risk)) tool.stated_risk = *place.risk;
  if (!(*place.risk > *place.judged_risk)) return;
  if (worst_unseen_ && !(place.unseen > worst_unseen_->shift)) return;
  worst_unseen_ = {operation.line, std::string(operation.file), place.unseen, std::nullopt};
  if (operation.origin != nullptr) {
    worst_unseen_->budget_place = budget_place(place, *operation.origin);
  }
}

// --- the outcome -------------------------------------------------------------------------------

namespace {

template <class T>
T sum_of(const std::map<int, JobVerdict::ToolFigures>& by_tool, T JobVerdict::ToolFigures::*field) {
  T sum = 0;
  for (const auto& [number, tool] : by_tool) sum += tool.*field;
  return sum;
}

}  // namespace

std::int64_t JobVerdict::n_judged() const {
  return sum_of(by_tool_, &ToolFigures::n_judged);
}
std::int64_t JobVerdict::n_told() const {
  return sum_of(by_tool_, &ToolFigures::n_told);
}
std::int64_t JobVerdict::n_uncorrected() const {
  return sum_of(by_tool_, &ToolFigures::n_uncorrected);
}
std::int64_t JobVerdict::n_not_asked() const {
  std::int64_t n = 0;
  for (const auto& [number, tool] : by_tool_) n += tool.predicted.n - tool.n_judged;
  return n;
}
std::int64_t JobVerdict::n_warned() const {
  return sum_of(by_tool_, &ToolFigures::n_warned);
}
std::int64_t JobVerdict::n_held() const {
  return sum_of(by_tool_, &ToolFigures::n_held);
}
std::int64_t JobVerdict::n_unjudged() const {
  std::int64_t sum = 0;
  for (const auto& [number, tool] : by_tool_) {
    if (tool.tolerance) sum += tool.n_uncorrected;
  }
  return sum;
}
double JobVerdict::expected_broken() const {
  return sum_of(by_tool_, &ToolFigures::expected_broken);
}

const JobVerdict::ToolFigures* JobVerdict::worst_tool() const {
  const ToolFigures* worst = nullptr;
  for (const auto& [number, tool] : by_tool_) {
    if (tool.n_judged == 0) continue;
    if (worst == nullptr || tool.worst.risk > worst->worst.risk) worst = &tool;
  }
  return worst;
}

JudgedPlaces JobVerdict::places() const {
  return {.n_judged = n_judged(),
          .n_unjudged = n_unjudged(),
          .n_warned = n_warned(),
          .n_held = n_held(),
          .expected_broken = expected_broken()};
}

bool JobVerdict::tells(double risk) const {
  const bool is_bounded = basis_.kind == RiskBasis::Kind::Bounded;
  return basis_.tells_risk() && !(is_bounded && risk < kMinStatedRisk);
}

/// The figures of the likeliest places.
std::string JobVerdict::risks_sentence() const {
  const auto more_likely = [](std::int64_t n, double limit) {
    return fmt::format("{} more likely than {} to break the tolerance",
                       count_of(n, "place is", "places are"),
                       risk_text(limit));
  };
  std::string out = n_held() > 0     ? more_likely(n_held(), tolerances_.hold_above)
                    : n_warned() > 0 ? more_likely(n_warned(), tolerances_.warn_above)
                                     : "";
  const WorstPlace& worst = worst_tool()->worst;
  const std::string line = line_text(worst.file, worst.line);
  if (!basis_.tells_risk()) {
    // By what is stated; what is not makes it likelier still.
    if (!out.empty()) out += fmt::format(" by sigma alone, the worst in line {}; ", line);
    return out + basis_.words;
  }
  if (basis_.kind == RiskBasis::Kind::Bounded) {
    if (!out.empty()) {
      out += fmt::format("; the worst is line {}, risk {}; ",
                         line,
                         risk_text(std::max(worst.risk, kMinStatedRisk)));
    }
    return out + basis_.words;
  }
  if (out.empty()) {
    out = fmt::format("no place is more likely than {} to break the tolerance",
                      risk_text(tolerances_.warn_above));
  }
  return out + fmt::format("; {} of {} expected to break; the worst is line {}, risk {}",
                           risk_text(expected_broken()),
                           n_judged(),
                           line,
                           risk_text(worst.risk));
}

std::string JobVerdict::sentence() const {
  std::string out(name(decision()));
  if (worst_tool() == nullptr) return out + ": no place has both a tolerance and a correction";
  out += ": " + risks_sentence();
  if (n_uncorrected() > 0) {
    out += fmt::format(
        "; {} not judged",
        count_of(
            n_uncorrected(), "place without a correction is", "places without a correction are"));
  }
  return out;
}

void JobVerdict::report(const std::string& file, DiagnosticLog& log) const {
  bool has_said = false;
  for (const auto& [number, tool] : by_tool_) {
    if (tool.n_warned == 0) continue;
    has_said = true;
    const bool is_held = tool.n_held > 0;
    const WorstPlace& worst = tool.worst;
    log.add({is_held ? Code::ToleranceHold : Code::ToleranceWarning,
             {worst.file.empty() ? file : worst.file, worst.line, 1},
             fmt::format("{} of {} places of tool {} may break the tolerance of {:.4g} um; the "
                         "worst, {}{}",
                         is_held ? tool.n_held : tool.n_warned,
                         tool.n_judged,
                         number,
                         tool.tolerance ? tool.tolerance->in_um() : 0,
                         place_text(worst.nominal, worst.path),
                         tells(worst.risk) ? ", with probability " + risk_text(worst.risk)
                                           : "; " + basis_.words),
             "at most " + risk_text(is_held ? tolerances_.hold_above : tolerances_.warn_above)});
  }
  if (n_unjudged() > 0) {
    log.add({Code::ToleranceWarning,
             {file, 0, 0},
             fmt::format("{} with a tolerance {} drilled without a correction, and the error is "
                         "not known",
                         count_of(n_unjudged(), "place", "places"),
                         n_unjudged() == 1 ? "is" : "are"),
             "a fit in force where holes have a tolerance"});
  }
  auto problem = sum_problem(places(), has_said, file, "places");
  if (!problem) return;
  if (basis_.kind != RiskBasis::Kind::Stated) {
    problem->what = fmt::format("{} places by sigma alone; {}", n_judged(), basis_.words);
  }
  log.add(*std::move(problem));
}

}  // namespace panelcal
