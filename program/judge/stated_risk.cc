// SPDX-License-Identifier: Apache-2.0
#include "program/judge/stated_risk.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/correction/unseen_shift.h"
#include "program/judge/job_decision.h"
#include "program/judge/job_verdict.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal {
namespace {

bool is_rejected(const SeriesResult& series) {
  return series.reliability != nullptr && series.reliability->is_rejected;
}

std::string rejected_words(const SeriesResult& series) {
  return fmt::format(
      "the targets of line {} break a gate or do not fit each other (chi square), and limits or "
      "--force release them",
      series.line);
}

/// "12.3 um", "1.5 mm".
std::string length_text(double length_mm) {
  return length_mm < 1 ? fmt::format("{:.3g} um", length_mm * 1e3)
                       : fmt::format("{:.3g} mm", length_mm);
}

std::string size_text(const UnseenError& error) {
  return error.is_unlimited ? "any size" : "up to " + length_text(error.error_mm.norm());
}

const SeriesResult* series_at(const std::optional<std::size_t>& i, const Survey& survey) {
  return i ? &survey.series[*i] : nullptr;
}

std::string shift_words(const UnseenShift& shift, const Position<frame::Nominal>& nominal) {
  const double shift_mm = shift_at(shift, nominal).in_mm();
  if (!shift.error->is_unlimited) return "by " + length_text(shift_mm);
  return fmt::format("by {:.2g} times as much", shift_mm / shift.error->error_mm.norm());
}

/// The errors that the targets behind a place would not show.
std::string untold_words(const BudgetPlace& at,
                         const std::string& place,
                         const Survey& survey,
                         const MachineUncertainty& machine) {
  if (at.i_measurement) {
    return fmt::format(
        "no other target checks the one of line {}, which is drilled where it was "
        "seen: its error would pass unnoticed",
        survey.measurements[*at.i_measurement].request.line);
  }
  const SeriesResult* const base = series_at(at.base_series, survey);
  const SeriesResult* const nested = series_at(at.nested_series, survey);
  const auto of = [](const SeriesResult* series) {
    return series == nullptr ? nullptr : series->reliability.get();
  };
  const CorrectionStack stack = corrections_at(at, survey, machine);
  const std::vector<UnseenShift> shifts = unseen_shifts(stack, of(base), of(nested));
  const UnseenShift* const worst = furthest(shifts, at.nominal);
  if (worst == nullptr) return "a smooth model takes up an error of one target";
  const SeriesResult& series = worst->is_nested ? *nested : *base;
  const std::size_t i_measurement = series.points[worst->error->i_target];
  const MeasurementRequest& request = survey.measurements[i_measurement].request;
  // People count from 1, and over all targets of the series.
  const auto number = 1 + std::ranges::count_if(series.measurements,
                                                [&](std::size_t i) { return i < i_measurement; });
  std::string out = fmt::format(
      "an error of {} of target {} ({} in line {}) would pass unnoticed "
      "and move {} {}",
      size_text(*worst->error),
      number,
      request.command,
      request.line,
      place,
      shift_words(*worst, at.nominal));
  double noise_ratio2 = 1;
  for (const SeriesResult* one : {base, nested}) {
    if (one != nullptr && one->reliability) {
      noise_ratio2 = std::max(noise_ratio2, one->reliability->noise_ratio2);
    }
  }
  if (std::isfinite(noise_ratio2) && noise_ratio2 > 1) {
    out += fmt::format("; so would noise {:.2g} times the stated one", std::sqrt(noise_ratio2));
  }
  return out;
}

}  // namespace

std::string unstated_words(const MachineUncertainty& machine) {
  const std::vector<std::string_view> terms = machine.unstated();
  if (terms.empty()) return {};
  std::string out(terms.front());
  for (std::size_t i = 1; i < terms.size(); ++i) {
    out += i + 1 == terms.size() ? " and " : ", ";
    out += terms[i];
  }
  return out + " not stated";
}

RiskBasis risk_basis(const JobVerdict& verdict,
                     const Survey& survey,
                     const MachineUncertainty& machine) {
  RiskBasis basis;
  const std::string unstated = unstated_words(machine);
  basis.is_of_fit_only = !unstated.empty();
  if (verdict.n_judged() == 0) return basis;
  if (verdict.n_told() < verdict.n_judged()) {
    basis.kind = RiskBasis::Kind::Unknown;
    if (!unstated.empty()) {
      basis.words = "no risk figure: " + unstated + "; sigma is of the fit only";
      return basis;
    }
    const auto refused = std::ranges::find_if(survey.series, is_rejected);
    basis.words = "no risk figure";
    if (refused != survey.series.end()) basis.words += ": " + rejected_words(*refused);
  } else if (const JobVerdict::UnseenPlace* const worst = verdict.worst_unseen()) {
    basis.kind = RiskBasis::Kind::Bounded;
    basis.words = fmt::format("no risk below {:g} can be stated", kMinStatedRisk);
    if (worst->budget_place) {
      const std::string place =
          fmt::format("the place of line {}", line_text(worst->file, worst->line));
      basis.words += ": " + untold_words(*worst->budget_place, place, survey, machine);
    }
  }
  return basis;
}

std::string risk_words(const PlacedPoint& place,
                       const BudgetPlace& at,
                       const Survey& survey,
                       const MachineUncertainty& machine) {
  if (place.risk && *place.risk <= *place.judged_risk) return risk_text(*place.risk);
  if (place.risk) {
    return fmt::format("{}, and none below can be stated: {}",
                       risk_text(*place.risk),
                       untold_words(at, "this place", survey, machine));
  }
  const std::string unstated = unstated_words(machine);
  if (!unstated.empty()) return "no figure: " + unstated;
  for (const auto& i : {at.base_series, at.nested_series}) {
    if (i && is_rejected(survey.series[*i])) {
      return "no figure: " + rejected_words(survey.series[*i]);
    }
  }
  return "no figure";
}

}  // namespace panelcal
