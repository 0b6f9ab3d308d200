// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/number_text.h"
#include "calib/base/statistics/chi_square.h"
#include "machine/job/facts/survey_facts.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

// The two sentences of the first screen. They name the one thing to look at, and claim no more
// than the numbers can tell.
namespace panelcal::facts {
namespace {

using internal::counted;
using internal::fixed;
using internal::shortest;

/// Below this chance residuals are not noise of the stated size.
constexpr double kSuspiciousChance = 0.001;
/// With fewer spare equations than this a wrong target cannot be told from its neighbours: one
/// target has two coordinates, and the fit follows both.
constexpr int kSpareToBlame = 3;

std::string shown_output(const JobFactsInput& input) {
  if (!input.output_words.empty()) return input.output_words;
  return input.output_file == "-" ? "the corrected program" : input.output_file;
}

std::string advice_on_lost(const Survey& survey) {
  std::size_t n_lost = 0;
  const Measurement* first = nullptr;
  for (const Measurement& m : survey.measurements) {
    if (m.status == MeasurementStatus::Found || is_left_out(m)) continue;
    if (n_lost++ == 0) first = &m;
  }
  if (first == nullptr) return {};
  std::string_view what = "was not found";
  if (first->status == MeasurementStatus::Ambiguous) what = "is ambiguous";
  if (first->status == MeasurementStatus::Rejected) what = "was rejected";
  std::string out = fmt::format("Look at {}, which {}", target_name(first->request), what);
  if (!first->reason.empty()) out += fmt::format(" ({})", first->reason);
  if (n_lost > 1) out += fmt::format(", and at {} more", n_lost - 1);
  return out + "; clean it or mend the vision tool, then measure again.";
}

std::string advice_on_residual(const Survey& survey, const WorstGate& worst) {
  const std::size_t i = worst.series->points[*worst.gate->i_target];
  const int spare = worst.series->degrees_of_freedom;
  std::string out = fmt::format("Look at {}: its residual is {} um, limit {} um",
                                target_name(survey.measurements[i].request),
                                fixed(worst.gate->value, 1),
                                shortest(worst.gate->limit));
  if (spare < kSpareToBlame) {
    out += fmt::format("; with {} to spare, any of the {} targets of {} may be the wrong one",
                       counted(spare, "equation"),
                       worst.series->points.size(),
                       series_name(*worst.series));
  }
  return out + ".";
}

bool is_larger_than_noise(double chi_square, int degrees_of_freedom) {
  // Written so that a NaN is larger.
  return degrees_of_freedom > 0 &&
         !(chi_square_exceedance(chi_square, degrees_of_freedom) >= kSuspiciousChance);
}

/// A rotation, stretch or offset that is too large: a wrong target that the fit followed, a board
/// that really lies so, or the wrong panel.
std::string advice_on_deformation(const Survey& survey, const WorstGate& worst) {
  const SeriesResult& series = *worst.series;
  const std::string what = fmt::format("{}: {}", series_name(series), worst.gate->text());
  const bool do_disagree = is_larger_than_noise(series.chi_square, series.degrees_of_freedom);
  if (!do_disagree && series.level == CorrectionLevel::Base) {
    return fmt::format(
        "Check that this program and this panel belong together and lie as planned ({}).", what);
  }
  std::string targets;
  for (const std::size_t i : series.measurements) {
    targets +=
        fmt::format("{}#{}", targets.empty() ? "" : ", ", survey.measurements[i].request.seq);
  }
  return fmt::format("Look at {} {} ({}): {}.",
                     series.measurements.size() == 1 ? "target" : "targets",
                     targets,
                     what,
                     do_disagree ? "they do not fit each other, so one of them is likely wrong"
                                 : "one may be wrong, or the board really lies so");
}

std::string advice_on_gate(const Survey& survey) {
  const std::optional<WorstGate> worst = worst_gate(survey);
  if (!worst || worst->gate->accepted) return {};
  const auto i_target = worst->gate->i_target;
  if (i_target && *i_target < worst->series->points.size()) {
    return advice_on_residual(survey, *worst);
  }
  return advice_on_deformation(survey, *worst);
}

/// Cause of a series that does not fit, where that is beyond doubt.
std::string advice_on_fault(const Survey& survey) {
  for (const SeriesResult& series : survey.series) {
    if (!series.fault || series.fault->is_resolved) continue;
    if (!series.fault->is_named() && !series.fault->i_outlier) continue;
    return fmt::format("{}: {}.", series_name(series), series.fault->text());
  }
  return {};
}

/// Says so where the fit rests on fewer targets than the program asks for.
std::string left_out_remark(const Survey& survey) {
  std::string out;
  const std::size_t n = n_dropped(survey);
  if (n == 1) out = " One target was left out of its fit.";
  if (n > 1) out = fmt::format(" {} targets were left out of their fits.", n);
  std::vector<std::string> boards;
  for (const SeriesResult* const board : survey.left_out_boards()) {
    boards.push_back(fmt::format("{} (line {})", board_text(board->path), board->line));
  }
  if (boards.empty()) return out;
  return out + fmt::format(" Left out, and not drilled: board{} {}.",
                           boards.size() == 1 ? "" : "s",
                           fmt::join(boards, ", "));
}

std::string found_sentence(const Survey& survey) {
  return std::ranges::any_of(survey.measurements, is_left_out)
             ? "Every target was found but those that persons left out"
             : "Every target was found";
}

std::string advice_on_errors(const JobFactsInput& input) {
  const auto first = std::ranges::find(input.diagnostics, Severity::Error, &Diagnostic::severity);
  if (first == input.diagnostics.end()) return {};
  return fmt::format("{} ({})", info(first->code).advice, first->text());
}

template <class T>
bool holds_job(const T* verdict) {
  return verdict != nullptr && verdict->decision() == JobDecision::Hold;
}

std::string advice_on_depth(const JobFactsInput& input) {
  if (!holds_job(input.depth) || holds_job(input.verdict)) return {};
  return fmt::format(
      "Probe the surface nearer to the worst place, or at more places; if the mean is small beside "
      "its sigma, the machine's depth_um is too coarse for this tolerance ({}).",
      input.depth->sentence());
}

std::string advice_on_drilling(const JobFactsInput& input) {
  const Survey& survey = survey_of(input);
  if (survey.measurements.empty() && survey.probes.empty()) {
    return fmt::format("Drill {} only if the panel needs no correction.", shown_output(input));
  }
  // One healthy fit in 10 grows a little; a rejected one needs a look.
  const bool has_misfit = std::ranges::any_of(survey.series, [](const SeriesResult& series) {
    return series.misfit_ratio > 1 && series.reliability && series.reliability->is_rejected;
  });
  if (has_misfit) {
    return fmt::format(
        "Look at the fits below before {} is drilled: targets do not agree within their stated "
        "noise, and the predicted sigmas have grown by it.",
        shown_output(input));
  }
  const PooledChiSquare pooled = pooled_chi_square(survey);
  const bool is_noisy = is_larger_than_noise(pooled.chi_square, pooled.degrees_of_freedom);
  if (is_noisy) {
    return fmt::format(
        "Drill {}, but take the predicted sigmas as optimistic: the residuals are "
        "larger than the stated measurement noise explains.",
        shown_output(input));
  }
  std::string out = fmt::format("Load {} and drill.", shown_output(input));
  if (input.verdict != nullptr && !input.unstated.empty()) {
    out += " For a risk state what is missing in [uncertainty] of the machine's file.";
  }
  return out;
}

/// --explain knows lines of the program itself only.
std::string explain_hint(const JobFactsInput& input) {
  const JobVerdict::WorstPlace& worst = input.verdict->worst_tool()->worst;
  if (input.worst_number) return fmt::format("below or by run --explain {}", *input.worst_number);
  if (!worst.file.empty()) return "below";
  return fmt::format("below or by run --explain L{}", worst.line);
}

std::string advice_on_warning(const JobFactsInput& input) {
  const bool is_of_depth =
      input.verdict == nullptr || input.verdict->decision() != JobDecision::DrillWithWarning;
  if (is_of_depth && input.depth != nullptr) {
    return fmt::format(
        "Drill {} if that risk is acceptable; otherwise probe more of the surface, or nearer to "
        "the worst place ({}).",
        shown_output(input),
        input.depth->sentence());
  }
  return fmt::format(
      "Drill {} if that risk is acceptable; otherwise see what the worst place's error is made of, "
      "{} ({}).",
      shown_output(input),
      explain_hint(input),
      input.verdict->sentence());
}

std::string fits_sentence(const Survey& survey) {
  return worst_gate(survey)
             ? "every fit is inside its limits"
             : "no fit was held against any limit, since machine.toml turns them off";
}

/// "all 990 places", or how many of them and what the others lack.
std::string judged_text(const JobVerdict& verdict) {
  const std::int64_t n_others = verdict.n_uncorrected() + verdict.n_not_asked();
  if (n_others == 0) {
    return verdict.n_judged() == 1 ? "the one place is"
                                   : fmt::format("all {} places are", verdict.n_judged());
  }
  std::string lack;
  if (verdict.n_uncorrected() > 0) {
    lack = fmt::format("{} without a correction", verdict.n_uncorrected());
  }
  if (verdict.n_not_asked() > 0) {
    lack +=
        fmt::format("{}{} without a tolerance", lack.empty() ? "" : " and ", verdict.n_not_asked());
  }
  return fmt::format("{} of {} places (not judged: {}) {}",
                     verdict.n_judged(),
                     verdict.n_judged() + n_others,
                     lack,
                     verdict.n_judged() == 1 ? "is" : "are");
}

std::string grounds_of_verdict(const JobFactsInput& input) {
  const Survey& survey = survey_of(input);
  switch (verdict_of(input)) {
    case Verdict::Hold:
      return input.output_file.empty() ? "Nothing was written for the machine."
                                       : "Something failed after the program was written.";
    case Verdict::Forced:
      return "A check failed, and the program was written all the same, because --force was given.";
    case Verdict::Warned:
      return found_sentence(survey) + ", and " + fits_sentence(survey) +
             "; but the tolerance is not as sure to be kept as the machine's file asks." +
             left_out_remark(survey);
    case Verdict::Drill:
      break;
  }
  if (survey.measurements.empty() && !survey.probes.empty()) {
    return "Every surface was found. The program has no targets: coordinates are as programmed.";
  }
  if (survey.measurements.empty()) {
    return "The program has no targets: nothing was measured, and coordinates are as programmed.";
  }
  if (input.verdict != nullptr && input.verdict->decision() == JobDecision::Drill &&
      input.verdict->basis().kind != RiskBasis::Kind::Stated) {
    return fmt::format("{}, and {}; {}.{}",
                       found_sentence(survey),
                       fits_sentence(survey),
                       input.verdict->basis().words,
                       left_out_remark(survey));
  }
  if (input.verdict != nullptr && input.verdict->decision() == JobDecision::Drill) {
    return fmt::format("{}, {}, and {} as sure to keep the tolerance as the machine's file asks.{}",
                       found_sentence(survey),
                       fits_sentence(survey),
                       judged_text(*input.verdict),
                       left_out_remark(survey));
  }
  if (!worst_gate(survey)) {
    return found_sentence(survey) + ", and " + fits_sentence(survey) + "." +
           left_out_remark(survey);
  }
  return found_sentence(survey) + ", and every fit is inside its limits." + left_out_remark(survey);
}

}  // namespace

std::string verdict_sentence(const JobFactsInput& input) {
  const std::vector<std::string> off = survey_of(input).gates_off();
  std::string words = grounds_of_verdict(input);
  if (!input.common_scale.empty()) words += fmt::format(" But {}.", input.common_scale);
  return off.empty() ? words : fmt::format("{} Gates off: {}.", words, fmt::join(off, ", "));
}

std::string next_step(const JobFactsInput& input) {
  const Verdict verdict = verdict_of(input);
  if (verdict == Verdict::Drill) return advice_on_drilling(input);
  if (verdict == Verdict::Warned) return advice_on_warning(input);
  std::string advice = advice_on_lost(survey_of(input));
  if (advice.empty()) advice = advice_on_fault(survey_of(input));
  if (advice.empty()) advice = advice_on_gate(survey_of(input));
  if (advice.empty()) advice = advice_on_depth(input);
  if (advice.empty()) advice = advice_on_errors(input);
  if (verdict == Verdict::Forced) {
    return advice.empty() ? "Measure the first panel before drilling more."
                          : "Before drilling: " + advice;
  }
  return advice.empty() ? "See the messages below, and run again." : advice;
}

}  // namespace panelcal::facts
