// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_table.h"

namespace panelcal {

Eigen::Vector2d SimTable::error_mm(const Position<frame::Machine>& command) const {
  const Eigen::Vector2d at_mm = (command - center).in_mm();
  const Eigen::Vector2d part = at_mm / bow_radius.in_mm();
  return {scale_x_ppm * 1e-6 * at_mm.x() + squareness.in_rad() * at_mm.y() +
              bow_y.in_mm() * part.y() * part.y(),
          scale_y_ppm * 1e-6 * at_mm.y() + bow_x.in_mm() * part.x() * part.x()};
}

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
