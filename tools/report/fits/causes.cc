// SPDX-License-Identifier: Apache-2.0
#include "tools/report/fits/causes.h"

#include "tools/figures/text.h"
#include "tools/report/input/facts.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

/// More digits than these are the priors' and not the data's.
std::string chance(double probability) {
  if (probability > 0.999) return "above 0.999";
  return probability < 0.001 ? "below 0.001" : fixed(probability, 3);
}

std::string test_sentence(const SeriesFault& fault) {
  if (fault.degrees_of_freedom <= 0) {
    return "There is no equation to spare, so the targets cannot be held against each other.";
  }
  const std::string p = fault.p_value < 1e-4 ? "less than 0.0001" : fixed(fault.p_value, 4);
  std::string out = "The chance that healthy targets fit each other as badly is " + p;
  if (fault.false_alarm > 0) {
    out += fmt::format("; they are accused below {:.2g}", fault.false_alarm);
  }
  out += '.';
  if (!fault.weighs_taken_pads) {
    out +=
        " Whether other pads were taken for the targets cannot be told: noise or limits allow too "
        "many.";
  }
  return out;
}

std::string dropped_list(const Survey& survey, const SeriesResult& series) {
  std::string out;
  for (const std::size_t i : series.dropped) {
    if (i >= survey.measurements.size()) continue;
    const MeasurementRequest& request = survey.measurements[i].request;
    out += fmt::format(
        "<p><b>Left out of the fit</b>, as [gates] max_dropped allows: "
        "<a href=\"#target-{}\">{}</a>.</p>\n",
        request.seq,
        escaped(target_name(request)));
  }
  return out;
}

}  // namespace

std::string causes_block(const Survey& survey, const SeriesResult& series) {
  if (!series.fault) return {};
  const SeriesFault& fault = *series.fault;
  std::string out = dropped_list(survey, series);
  out += fmt::format("<p>{}{}</p>\n",
                     test_sentence(fault),
                     fault.is_named()  ? ""
                     : fault.i_outlier ? " The target at fault is certain, the cause is not."
                                       : " The data do not separate these causes:");
  out +=
      "<div class=\"scroll\"><table class=\"grid\"><tr><th>cause</th><th>what speaks for it</th>"
      "<th class=\"num\">probability</th></tr>\n";
  for (const SeriesFault::Suspicion& suspicion : fault.suspicions) {
    out += fmt::format("<tr><td>{}</td><td>{}</td><td class=\"num\">{}</td></tr>\n",
                       escaped(name(suspicion.cause)),
                       escaped(suspicion.text),
                       chance(suspicion.probability));
  }
  return out +
         "</table></div>\n<p class=\"quiet\">Probabilities are among the causes that panelcal "
         "knows.</p>\n";
}

}  // namespace panelcal::report
