// SPDX-License-Identifier: Apache-2.0
#include "machine/job/walk_terms.h"

#include "machine/job/spindle_age.h"
#include "machine/job/text_variables.h"

namespace panelcal {

Expected<std::string> set_walk_terms(const WalkTerms& terms, MachineConfig& machine) {
  PANELCAL_TRY(std::string time, wall_time(terms.clock, terms.now, terms.command));
  if (terms.ages_offset) PANELCAL_CHECK(age_offset(machine, terms.clock, terms.now));
  set_text_variables(terms.program, time, machine.walk.sieb_meyer.text);
  machine.walk.max_operations = terms.max_operations;
  if (terms.reading) machine.reading.take(*terms.reading);
  return time;
}

}  // namespace panelcal
