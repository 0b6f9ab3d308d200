// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "program/walk/survey.h"
#include "program/writers/svg_writer.h"

namespace panelcal {

/// Every target where it was found, labelled by its number, with the residual of its fit.
std::vector<SvgTarget> picture_targets(const Survey& survey);

}  // namespace panelcal
