// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "program/walk/survey.h"

namespace panelcal {

/// The measurements and the fits, in a few lines for people.
std::string fits_summary(const Survey& survey);

}  // namespace panelcal
