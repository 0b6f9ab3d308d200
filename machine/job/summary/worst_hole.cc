// SPDX-License-Identifier: Apache-2.0
#include "machine/job/summary/worst_hole.h"

namespace panelcal {

void WorstHole::put(const Operation& operation) {
  const auto* drill = std::get_if<Drill>(&operation.what);
  if (drill == nullptr || operation.origin == nullptr) return;
  if (!sigma_.add(drill->cov_mm2)) return;
  hole_.line = operation.line;
  hole_.file = operation.file;
  hole_.path.assign(operation.path.begin(), operation.path.end());
  hole_.tool = drill->tool;
  hole_.nominal = drill->nominal;
  place_ = budget_place(*drill, *operation.origin);
}

std::optional<HoleBudget> WorstHole::budget(const Survey& survey,
                                            const MachineUncertainty& machine) const {
  if (!(sigma_.value() > Length())) return std::nullopt;
  HoleBudget out = hole_;
  out.budget = error_budget(place_, survey, machine);
  return out;
}

namespace {

/// Of the worst place; a risk that cannot be told from a smaller one is not its own.
std::optional<double> stated_risk(const JobVerdict& verdict) {
  const double risk = verdict.worst_tool()->worst.risk;
  switch (verdict.basis().kind) {
    case RiskBasis::Kind::Stated:
      return risk;
    case RiskBasis::Kind::Bounded:
      return risk >= kMinStatedRisk ? std::optional(risk) : std::nullopt;
    case RiskBasis::Kind::Unknown:
      break;
  }
  return std::nullopt;
}

}  // namespace

std::optional<HoleBudget> likeliest_to_break(const JobVerdict& verdict,
                                             const Survey& survey,
                                             const MachineUncertainty& machine) {
  const JobVerdict::ToolFigures* const worst_tool = verdict.worst_tool();
  if (worst_tool == nullptr || !worst_tool->worst.budget_place) return std::nullopt;
  const JobVerdict::WorstPlace& worst = worst_tool->worst;
  HoleBudget out{.line = worst.line,
                 .file = worst.file,
                 .path = worst.path,
                 .nominal = worst.nominal,
                 .is_likeliest_to_break = true,
                 .risk = stated_risk(verdict),
                 .budget = error_budget(*worst.budget_place, survey, machine)};
  for (const auto& [number, tool] : verdict.by_tool()) {
    if (&tool == worst_tool) out.tool = number;
  }
  return out;
}

}  // namespace panelcal
