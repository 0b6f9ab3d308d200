// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "program/walk/walk.h"

namespace panelcal::bench {

/// Metric, trailing zeros kept: three targets of one series, then one block of 15 bytes for each
/// hole, in thirds by three tools. The same count gives the same text everywhere.
std::string plain_program(int n_holes);

/// The same count of holes as a pattern of 100 blocks in nested levels of step and repeat, as a
/// rule of up to 100 copies each. Precondition: n_holes is a multiple of 100.
std::string repeat_program(int n_holes);

/// The same holes as `plain_program`, as SIEB & MEYER's format 5000 writes them: 16 bytes each.
std::string plain_sieb_meyer_program(int n_holes);
/// The same holes as `repeat_program` in nested sections.
std::string repeat_sieb_meyer_program(int n_holes);

/// A panel that lies shifted and turned on the table.
class TurnedPanel final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override;
};

/// The program's targets give one rigid correction.
WalkOptions rigid();
/// The same on a machine that states every one of its errors.
WalkOptions with_uncertainty();
/// And that judges every place by the probability of breaking a tolerance.
WalkOptions with_tolerance();

}  // namespace panelcal::bench
