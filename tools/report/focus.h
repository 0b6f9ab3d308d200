// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "program/walk/survey.h"

namespace panelcal::report {

/// Every autofocus with its sharpness over the camera's height and the peak that was found. Empty
/// for a program that does not focus.
std::string focus_section(const Survey& survey);

}  // namespace panelcal::report
