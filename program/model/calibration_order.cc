// SPDX-License-Identifier: Apache-2.0
#include "program/model/calibration_order.h"

#include <fmt/format.h>

namespace panelcal {

std::string describe(const CalibrationOrder& order) {
  return fmt::format("calibration {} ({}, line {})", order.number, order.command, order.line);
}

}  // namespace panelcal
