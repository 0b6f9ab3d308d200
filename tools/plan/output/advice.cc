// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/output/advice.h"

#include <algorithm>
#include <cctype>
#include <limits>
#include <map>

#include "tools/cli/place_text.h"
#include <fmt/format.h>

namespace panelcal::plan {
namespace {

using report::path_text;
using report::point_text;

/// An order of more targets than this is printed by --json only.
constexpr std::size_t kMostListed = 60;

std::string percent(double after, double before) {
  return before > 0 ? fmt::format("{:+.0f} %", 100 * (after / before - 1)) : std::string("+0 %");
}

std::string share_text(double share) {
  return fmt::format("{:.0f} %", 100 * share);
}

/// The error of a target from which on a job is held, where that is largest, and how often the job
/// names it.
std::string error_text(const SeriesPlan& series, const TargetError& error) {
  if (!error.noticed.from) return "an error of one target alone can go unnoticed at any size";
  std::string out = fmt::format("an error of one target alone is noticed from {:.1f} um on ({})",
                                *error.noticed.from * series.noise.in_um(),
                                name(error.noticed.by));
  if (!error.at_once || !error.at_twice) return out;
  return out + fmt::format(", and named in {} of such cases, at twice the size in {}",
                           share_text(error.at_once->named_share()),
                           share_text(error.at_twice->named_share()));
}

/// The target of the series where an error is noticed latest.
const TargetError& latest_of(const SeriesPlan& series) {
  return *std::ranges::max_element(series.errors, {}, [](const TargetError& error) {
    return error.noticed.from.value_or(std::numeric_limits<double>::infinity());
  });
}

std::string chosen_text(const SeriesPlan& series) {
  return fmt::format(
      "By the model that the targets speak for, the worst has {} to {} times the noise, {} to {} "
      "um, in 90 % of simulated jobs, whatever a panel is deformed by.",
      times(series.chosen->low),
      times(series.chosen->high),
      um_of(series.chosen->low, series),
      um_of(series.chosen->high, series));
}

std::string pads_text(const AdditionPlan& addition) {
  std::string out;
  for (std::size_t i = 0; i < addition.pads.size(); ++i) {
    const PlannedPlace& pad = addition.pads[i];
    out += fmt::format(
        "{}{} {}", i == 0 ? "" : "; ", pad.is_target ? "target" : "hole", place_text(pad));
  }
  return out;
}

/// Text for further targets that make a job fit another model: which, and why.
std::string change_text(const Plan& plan, const SeriesPlan& series, const AdditionPlan& addition) {
  if (addition.model == series.programmed) return {};
  return fmt::format("the model becomes {} instead of {} ({})",
                     name(addition.model),
                     name(series.programmed),
                     plan.fixes_model     ? "[vision] model"
                     : plan.chooses_model ? "auto: the manual's for this number"
                                          : "the manual's for this number");
}

/// Text for a fixed model that would make more of the same targets.
std::string kept_text(const Plan& plan, const SeriesPlan& series, const AdditionPlan& addition) {
  if (plan.fixes_model) return {};
  const double kept = addition.worst_if_kept.value_or(addition.stats.worst);
  if (kept > 0.99 * addition.stats.worst) return {};
  return fmt::format(
      " As [vision] model = \"{}\" the worst would have {} times the noise, but what "
      "only {} takes out of the panel would stay in it.",
      name(series.programmed),
      times(kept),
      name(addition.model));
}

std::string addition_text(const Plan& plan,
                          const SeriesPlan& series,
                          const AdditionPlan& addition) {
  const std::size_t n = addition.pads.size();
  const std::string what = n == 1 ? "One more target" : fmt::format("{} more targets", n);
  if (!addition.fit) {
    return what + " among the program's own pads do not make it determine the model.";
  }
  const ModelPlan& before = series.in_force();
  std::string change = change_text(plan, series, addition);
  if (!change.empty()) change += ", ";
  const auto places = places_word(plan, series);
  const std::string after = fmt::format("{} times the noise, {} um",
                                        times(addition.stats.worst),
                                        um_of(addition.stats.worst, series));
  const std::string errors =
      addition.latest ? "; " + error_text(series, *addition.latest) : std::string();
  if (!before.fit) {
    return fmt::format("{} would determine it: {}. Then {}the worst of the {} has {}{}.",
                       what,
                       pads_text(addition),
                       change,
                       places,
                       after,
                       errors);
  }
  const bool helps = addition.stats.worst < 0.99 * before.stats.worst;
  if (!helps) {
    return fmt::format(
        "{} would not help the worst of the {}: {}{} -> {} times the noise at the best ({}).{}{}",
        what,
        places,
        change,
        times(before.stats.worst),
        times(addition.stats.worst),
        pads_text(addition),
        kept_text(plan, series, addition),
        n == 1 && series.n_addable > 1 ? " Several together may: --add 2." : "");
  }
  return fmt::format(
      "{} help{} most at {}: {}worst {} -> {} times the noise ({}), {} -> {} um; mean "
      "{} -> {}{}.{}{}",
      what,
      n == 1 ? "s" : "",
      pads_text(addition),
      change,
      times(before.stats.worst),
      times(addition.stats.worst),
      percent(addition.stats.worst, before.stats.worst),
      um_of(before.stats.worst, series),
      um_of(addition.stats.worst, series),
      times(before.stats.mean()),
      times(addition.stats.mean()),
      errors,
      addition.is_best ? "" : " Found by search: another choice may be a little better.",
      kept_text(plan, series, addition));
}

/// The lines of each kind of series in their new order, where it differs.
std::string exchanged_lines(const VisitPlan& visits, const Survey& survey) {
  std::map<std::size_t, std::size_t> series_of;
  for (std::size_t s = 0; s < survey.series.size(); ++s) {
    for (const std::size_t i : survey.series[s].measurements) series_of[i] = s;
  }
  std::map<std::string, bool> seen;
  std::string out;
  for (std::size_t k = 0; k < visits.within_series.size();) {
    const auto of = series_of.find(visits.within_series[k]);
    std::string lines;
    bool is_changed = false;
    std::size_t end = k;
    do {
      const std::size_t i = visits.within_series[end];
      is_changed = is_changed || i != end;
      const MeasurementRequest& request = survey.measurements[i].request;
      lines += fmt::format("{}{}", lines.empty() ? "" : ", ", request.line);
      ++end;
    } while (of != series_of.end() && end < visits.within_series.size() &&
             series_of.contains(visits.within_series[end]) &&
             series_of.at(visits.within_series[end]) == of->second);
    if (is_changed && seen.emplace(lines, true).second) out += (out.empty() ? "" : "; ") + lines;
    k = end;
  }
  return out;
}

}  // namespace

std::string with_capital(std::string text) {
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string times(double leverage) {
  return fmt::format("{:.2f}", leverage);
}

std::string um_of(double leverage, const SeriesPlan& series) {
  return fmt::format("{:.2f}", leverage * series.noise.in_um());
}

std::string_view why(FitFailure failure) {
  switch (failure) {
    case FitFailure::TooFewTargets:
      return "too few targets";
    case FitFailure::Degenerate:
      return "targets coincide, or lie in one line";
    default:
      break;
  }
  return "no usable noise";
}

std::string place_text(const PlannedPlace& place) {
  std::string out = fmt::format("{}, ", point_text(place.nominal.in_mm()));
  if (!place.file.empty()) out += escaped_controls(place.file) + " ";
  out += fmt::format("line {}", place.line);
  if (!place.is_target && place.tool > 0) out += fmt::format(", T{}", place.tool);
  if (!place.path.empty()) out += ", copy " + path_text(place.path);
  return out;
}

std::string places_word(const Plan& plan, const SeriesPlan& series) {
  if (series.serves_targets) return "board targets";
  return plan.has_routs ? "places" : "holes";
}

std::vector<std::string> series_advice(const Plan& plan, const SeriesPlan& series) {
  std::vector<std::string> out;
  const ModelPlan& programmed = series.in_force();
  if (!programmed.fit) {
    out.push_back(fmt::format(
        "The targets do not determine the model \"{}\": {}. `panelcal run` will refuse it.",
        name(series.programmed),
        why(programmed.failure)));
  } else {
    if (series.chosen) out.push_back(chosen_text(series));
    if (!series.errors.empty()) {
      out.push_back(with_capital(error_text(series, latest_of(series))) + ".");
    }
  }
  if (series.n_places == 0) {
    out.emplace_back("Nothing is drilled with this correction.");
    return out;
  }
  const auto n = static_cast<std::int64_t>(series.n_places);
  if (series.n_outside > 0) {
    out.push_back(
        fmt::format("Outside of the targets' hull: {} of {} {}, the farthest by {:.1f} mm at {}.",
                    report::grouped(series.n_outside),
                    report::grouped(n),
                    places_word(plan, series),
                    series.farthest.in_mm(),
                    place_text(series.farthest_place)));
  } else {
    out.push_back(fmt::format("All {} {} lie inside of the targets' hull.",
                              report::grouped(n),
                              places_word(plan, series)));
  }
  for (const auto* addition : {&series.one, &series.several}) {
    if (*addition) out.push_back(addition_text(plan, series, **addition));
  }
  if (series.n_addable == 0) {
    out.emplace_back(
        series.has_slots
            ? "No advice on further targets: a slot shows one axis only (measurement mode 5)."
            : "No target can be added: a pattern measures at most two (CAMA).");
  }
  if (series.is_thinned) {
    out.push_back(fmt::format(
        "{} of the places were candidates, one in each cell of a {} x {} grid and the outermost.",
        report::grouped(static_cast<std::int64_t>(series.candidates.size())),
        CandidatePool::kCells,
        CandidatePool::kCells));
  }
  return out;
}

std::vector<std::string> visit_advice(const Plan& plan, const Survey& survey) {
  const VisitPlan& visits = plan.visits;
  std::vector<std::string> out;
  if (visits.places.size() < 2) return out;
  const double programmed_mm = visits.programmed.in_mm();
  out.push_back(fmt::format("{:.1f} mm as programmed.", programmed_mm));
  const std::string lines = exchanged_lines(visits, survey);
  if (!lines.empty()) {
    out.push_back(fmt::format("{:.1f} mm ({}) if lines change places inside their series: {}.",
                              visits.within_series_length.in_mm(),
                              percent(visits.within_series_length.in_mm(), programmed_mm),
                              lines));
  }
  if (visits.free_length.in_mm() < visits.within_series_length.in_mm() - 1e-3) {
    std::string text = fmt::format(
        "{:.1f} mm ({}) in any order that takes the targets of the panel before those of its "
        "boards, {}",
        visits.free_length.in_mm(),
        percent(visits.free_length.in_mm(), programmed_mm),
        visits.is_exact ? "the shortest there is" : "found by search");
    if (visits.free.size() <= kMostListed) {
      text += ": seq";
      for (const std::size_t i : visits.free) text += fmt::format(" {}", i);
    }
    out.push_back(text + ".");
  }
  out.emplace_back(
      "Advice only: panelcal measures in the order of the program. Inside a series targets may "
      "change "
      "places freely; whole series may where no step and repeat and no M52 fixes their order, or "
      "where "
      "another vision system takes the measurements and hands them over (--measurements).");
  return out;
}

}  // namespace panelcal::plan
