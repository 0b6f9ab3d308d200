// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/plan/facts.h"

namespace panelcal::plan {

/// The advice: sentences.
std::vector<std::string> series_advice(const Plan& plan, const SeriesPlan& series);
std::vector<std::string> visit_advice(const Plan& plan, const Survey& survey);

/// "(20.000, 30.000), line 24, T3, copy [0,1]"
std::string place_text(const PlannedPlace& place);
/// "holes", "places" (where something is routed too) or "board targets"
std::string places_word(const Plan& plan, const SeriesPlan& series);
/// The same text, a capital at its beginning. Precondition: not empty.
std::string with_capital(std::string text);
/// "1.73"
std::string times(double leverage);
/// The same in um for the series' noise.
std::string um_of(double leverage, const SeriesPlan& series);
/// The reason why a model is not determined.
std::string_view why(FitFailure failure);

}  // namespace panelcal::plan
