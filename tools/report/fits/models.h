// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "program/walk/survey.h"

namespace panelcal::report {

/// The models that the targets of a series determine, side by side, and what they speak for; empty
/// where there is nothing to compare.
///
/// See    tests/tools/report/fits/models_test.cc
std::string models_block(const SeriesResult& series);

/// One line for people, with a line end: which model was chosen for the panel's fit and why, and
/// whether a smooth one would predict better. Empty where the model is not left to the targets.
std::string model_line(const SeriesResult& series);

/// The same for all nested fits together: "models of 12 nested fits: 10 offset, 2 rigid".
std::string nested_models_line(const Survey& survey);

}  // namespace panelcal::report
