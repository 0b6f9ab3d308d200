// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "program/walk/survey.h"

namespace panelcal {

/// One line for people, with a line end: which model was chosen for the panel's fit and why, and
/// whether a smooth one would predict better. Empty where the model is not left to the targets.
std::string model_line(const SeriesResult& series);

/// The same for all nested fits together: "models of 12 nested fits: 10 offset, 2 rigid".
std::string nested_models_line(const Survey& survey);

}  // namespace panelcal
