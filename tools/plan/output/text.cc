// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/output/text.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/panel/smooth_panel.h"
#include "tools/cli/place_text.h"
#include "tools/plan/output/advice.h"
#include <fmt/format.h>

namespace panelcal::plan {
namespace {

using report::counted;
using report::path_text;

bool has_machine_terms(const Plan& plan) {
  return !(plan.machine.shared_mm2() + plan.machine.of_hole_mm2()).isZero(0);
}

std::string lines_text(const SeriesPlan& series) {
  const auto [first, last] = std::ranges::minmax(
      series.targets, {}, [](const PlannedPlace& target) { return target.line; });
  if (first.line == last.line) return fmt::format("line {}", first.line);
  return fmt::format("lines {} to {}", first.line, last.line);
}

std::string wrapped(const std::string& text, std::size_t indent) {
  constexpr std::size_t kWidth = 110;
  std::string out(indent, ' ');
  std::size_t column = indent;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::size_t length = end - at;
    if (column > indent && column + 1 + length > kWidth) {
      out += "\n" + std::string(indent + 2, ' ');
      column = indent + 2;
    } else if (column > indent) {
      out += ' ';
      ++column;
    }
    out.append(text, at, length);
    column += length;
    at = end + 1;
  }
  return out + "\n";
}

/// Longer lists of errors are printed by --json only.
constexpr std::size_t kMostListedErrors = 60;

std::string noticed_text(const SeriesPlan& series, const NoticedError& noticed) {
  return noticed.from ? fmt::format("{:.1f}", *noticed.from * series.noise.in_um()) : "no";
}

std::string total_text(const Plan& plan,
                       const SeriesPlan& series,
                       const PredictedFit& fit,
                       const LeverageStats& stats) {
  return fmt::format("{:.2f}", plan.total_sigma(series, fit, stats.worst_place).in_um());
}

std::string row_text(const Plan& plan, const SeriesPlan& series, const ModelPlan& model) {
  std::string out = fmt::format("  {} {:<11}", model.is_programmed ? "*" : " ", name(model.model));
  if (!model.fit) {
    return out + fmt::format("{:>6}  not determined: {}\n", "-", why(model.failure));
  }
  const LeverageStats& stats = model.stats;
  const bool has_places = stats.n > 0;
  const auto of_places = [&](const std::string& text) { return has_places ? text : "-"; };
  // The same everywhere, but for rounding.
  const bool is_even = stats.n > 1 && stats.worst <= stats.mean() * (1 + 1e-9);
  std::string noticed = "-";
  if (model.noticed) noticed = noticed_text(series, *model.noticed);
  return out + fmt::format("{:>6}  {:>8} {:>8}{}  {:>6}  {:>15}  {}\n",
                           model.fit->degrees_of_freedom,
                           of_places(times(stats.worst)),
                           of_places(um_of(stats.worst, series)),
                           has_machine_terms(plan)
                               ? fmt::format("{:>8}",
                                             of_places(total_text(plan, series, *model.fit, stats)))
                               : "",
                           of_places(times(stats.mean())),
                           noticed,
                           is_even ? "alike everywhere" : of_places(place_text(stats.worst_place)));
}

std::string plan_table_text(const Plan& plan, const SeriesPlan& series) {
  std::string out = fmt::format("    {:<11}{:>6}  {:>8} {:>8}{}  {:>6}  {:>15}  {}\n",
                                "model",
                                "d.o.f.",
                                "worst x",
                                "um",
                                has_machine_terms(plan) ? "   total" : "",
                                "mean x",
                                "noticed from um",
                                "the worst is at");
  for (const ModelPlan& model : series.models) out += row_text(plan, series, model);
  return out;
}

/// The answers of a job to an error of each target.
std::string error_table_text(const SeriesPlan& series) {
  if (series.errors.empty() || series.errors.size() > kMostListedErrors) return {};
  const auto share = [](const std::optional<ErrorTrials>& trials) {
    return trials ? fmt::format("{:.0f} %", 100 * trials->named_share()) : std::string("-");
  };
  constexpr auto kRow = "    {:<42}{:>15}  {:<10}  {:>5}  {:>8}\n";
  std::string out =
      fmt::format(kRow, "an error of one target", "noticed from um", "by", "named", "at twice");
  for (const TargetError& error : series.errors) {
    out += fmt::format(kRow,
                       place_text(series.targets[error.i_target]),
                       noticed_text(series, error.noticed),
                       error.noticed.from ? name(error.noticed.by) : "-",
                       share(error.at_once),
                       share(error.at_twice));
  }
  return out;
}

std::string noise_text(const Plan& plan) {
  const double target_um = 1e3 * std::sqrt(plan.machine.of_target_mm2()(0, 0));
  const std::string amount = plan.is_recorded
                                 ? std::string("of each its own")
                                 : fmt::format("{:.2f} um along each axis",
                                               std::hypot(plan.picture_sigma.in_um(), target_um));
  std::string out = fmt::format("Noise of a target: {} ({}", amount, plan.sigma_source);
  if (target_um > 0) {
    out += fmt::format(", stage {:.2f} um, table {:.2f} um",
                       plan.machine.stage_repeatability.in_um(),
                       plan.machine.table_residual.in_um());
  }
  out += ")";
  if (has_machine_terms(plan)) {
    out +=
        fmt::format("; total counts what the machine adds to every hole: {:.2f} um",
                    1e3 * greatest_sigma(plan.machine.shared_mm2() + plan.machine.of_hole_mm2()));
  }
  return out;
}

std::string series_title(const Plan& plan, const SeriesPlan& series) {
  const bool is_base = series.level == CorrectionLevel::Base;
  std::string out = is_base ? "Panel" : "Board";
  if (!series.targets.empty() && !series.targets.front().path.empty()) {
    out += " copy " + path_text(series.targets.front().path);
  }
  out += fmt::format(": {}, {}, model {}",
                     counted(static_cast<std::int64_t>(series.targets.size()), "target"),
                     lines_text(series),
                     name(series.programmed));
  if (plan.chooses_model) out += " (auto: the manual's for this number)";
  if (plan.bends_panel) out += " (of the smooth one)";
  if (plan.is_recorded)
    out += fmt::format(", noise {:.2f} um (root mean square)", series.noise.in_um());
  return out;
}

std::string series_note(const Plan& plan, const SeriesPlan& series) {
  if (series.level == CorrectionLevel::Nested) {
    if (plan.n_nested <= 1) return {};
    const bool is_worst = &series == &plan.series.back();
    if (!is_worst) return fmt::format("The first of {} boards.", plan.n_nested);
    if (plan.n_like_worst == plan.n_nested) {
      return fmt::format("It stands for all {} boards, which are alike.", plan.n_nested);
    }
    const std::size_t n_others = plan.n_like_worst - 1;
    return fmt::format("The worst of {} boards; {} like it.",
                       plan.n_nested,
                       n_others == 0   ? std::string("no other is")
                       : n_others == 1 ? std::string("another one is")
                                       : fmt::format("{} others are", n_others));
  }
  if (series.serves_targets) {
    return "Its holes are all corrected by board series of their own. What it decides is how well "
           "the board targets are found; the figures are theirs.";
  }
  return {};
}

std::string model_text(const Plan& plan) {
  if (plan.bends_panel) {
    return fmt::format(
        "Model \"smooth\": how a panel bends between its targets is not known before they are "
        "measured. All figures are those of the affine map it bends on, the least that a hole can "
        "have; an error of one target may be taken for bending, so that nothing is said of when it "
        "is noticed. It needs {} to {} targets, and no "
        "nested corrections on top.",
        kLeastSmoothTargets,
        kMostSmoothTargets);
  }
  if (!plan.chooses_model) return {};
  return "Model \"auto\": a job chooses by what it measures. Assumed here is the manual's model "
         "for "
         "this number of targets, now and with further ones; the table has the others. When an "
         "error is noticed holds for the assumed model: a softer one may follow the error.";
}

std::string errors_text(const Plan& plan) {
  if (std::ranges::none_of(plan.series, &SeriesPlan::predicts_errors)) return {};
  return fmt::format(
      "noticed from: the smallest error of one target alone that the gates in force notice in "
      "{:.0f} "
      "% of cases, in the direction where it shows least, if the panel lies as drawn; named: how "
      "often a job then names that target",
      100 * kNoticedShare);
}

}  // namespace

std::string plan_text(const Plan& plan, const Survey& survey) {
  std::string out = wrapped(noise_text(plan), 0);
  if (const std::string model = model_text(plan); !model.empty()) out += wrapped(model, 0);
  out += wrapped(
      "x: times the noise of a target that reaches a hole, in its worst direction (one standard "
      "deviation); um: the same for this noise; * the model in force",
      0);
  if (const std::string errors = errors_text(plan); !errors.empty()) out += wrapped(errors, 0);
  for (const SeriesPlan& series : plan.series) {
    out += "\n" + series_title(plan, series) + "\n";
    if (const std::string note = series_note(plan, series); !note.empty()) out += wrapped(note, 2);
    out += plan_table_text(plan, series) + error_table_text(series);
    for (const std::string& line : series_advice(plan, series)) out += wrapped("- " + line, 2);
  }
  if (plan.n_base > kMostBase) {
    out += fmt::format("\n{} further base series are left out.\n", plan.n_base - kMostBase);
  }
  if (plan.series.empty())
    out += "\nThe program measures no series: every hole goes where it is drawn.\n";
  if (plan.n_uncorrected > 0 && !plan.series.empty()) {
    out += fmt::format("\nWithout any correction: {}.\n", counted(plan.n_uncorrected, "place"));
  }
  if (plan.n_own_target > 0) {
    out += fmt::format("\nDrilled at a target of its own, with 1.00 times its noise: {}.\n",
                       counted(plan.n_own_target, "place"));
  }
  const auto visits = visit_advice(plan, survey);
  if (!visits.empty()) out += "\nOrder of visits\n";
  for (const std::string& line : visits) out += wrapped("- " + line, 2);
  return out;
}

}  // namespace panelcal::plan
