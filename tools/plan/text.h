// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/plan/facts.h"

namespace panelcal::plan {

/// The plan as `panelcal plan` prints it.
std::string plan_text(const Plan& plan, const Survey& survey);

// The pieces, which the HTML page has too.

/// "Panel: 3 targets, lines 24 to 26, model stretch, noise 3.54 um (root mean square)" (where it
/// was recorded)
std::string series_title(const Plan& plan, const SeriesPlan& series);
/// The note before the table; may be empty.
std::string series_note(const Plan& plan, const SeriesPlan& series);

/// A row of the table of models, as words.
struct ModelRow {
  std::string model;
  std::string left;  ///< degrees of freedom
  // "-" where no hole is corrected
  std::string worst = "-";
  std::string worst_um = "-";
  std::string total_um = "-";
  std::string place = "-";
  std::string mean = "-";
  std::string noticed;
  bool is_programmed = false;
  std::string why_not;  ///< instead of all others where the model is not determined
};
std::vector<ModelRow> model_rows(const Plan& plan, const SeriesPlan& series);

/// Longer lists of errors are printed by --json only.
inline constexpr std::size_t kMostListedErrors = 60;

/// A row of the table of errors of single targets, as words.
struct ErrorRow {
  std::string target;
  std::string noticed;  ///< um
  std::string by;
  std::string named;  ///< "-": not tried
  std::string named_at_twice;
};
std::vector<ErrorRow> error_rows(const SeriesPlan& series);

std::string noise_text(const Plan& plan);
/// The meaning of "noticed" and "named"; empty where neither is predicted.
std::string errors_text(const Plan& plan);
/// The model assumed where the job will choose it; else empty.
std::string model_text(const Plan& plan);

}  // namespace panelcal::plan
