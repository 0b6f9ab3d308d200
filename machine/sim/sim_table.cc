// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_table.h"

namespace panelcal {

Expected<Position<frame::Machine>> ErringStage::move_to(const Position<frame::Machine>& command) {
  const auto error = displacement_mm<frame::Machine>(table_.error_mm(command));
  PANELCAL_CHECK(exact_->move_to(command + error));
  return command;
}

std::shared_ptr<Stage> simulated_stage(std::shared_ptr<Stage> exact,
                                       const std::optional<SimTable>& table) {
  if (!table) return exact;
  return std::make_shared<ErringStage>(std::move(exact), *table);
}

}  // namespace panelcal
